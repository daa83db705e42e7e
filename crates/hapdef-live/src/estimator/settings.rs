//! How contacts are looked for on a map, as a scene says it and a bundle keeps it.

use std::sync::Arc;

use hapdef_inverse::{
    ContactEstimator, EstimatorParams, ModelError, NoiseParams, ResponseMap, ScanSites, WideParams,
};
use serde::{Deserialize, Serialize};

use crate::error::LiveError;

/// Noise, the map's error and the bounds of the search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuperpositionSettings {
    /// Standard deviation of a reading's noise, µε.
    pub noise_ue: f64,
    /// Relative error of the map; 0 where its error is given site by site.
    pub map_error: f64,
    /// Factor by which a calibration scales a position's estimated covariance, from a calibration; 1 without one and in older bundles.
    #[serde(default = "unchanged")]
    pub place_factor: f64,
    /// Largest friction coefficient of what touches.
    pub friction: f64,
    /// How much wider than the map's tip those that touch are, m, as [`ModelError::tip_ring_m`]; 0 in
    /// older bundles.
    #[serde(default)]
    pub tip_ring_m: f64,
    /// Radius of the tip that is in the map, m; 0 in older bundles.
    #[serde(default)]
    pub tip_radius_m: f64,
    /// Radius of the widest contact that is looked for, m; 0 for none wider than the tip, as in older bundles.
    #[serde(default)]
    pub palm_radius_m: f64,
    /// Sites of the scan.
    pub n_sites: usize,
    /// Contacts at a time at most.
    pub max_contacts: usize,
    /// Explanations with a larger force are not believed, N.
    pub max_force_n: f64,
}

impl SuperpositionSettings {
    /// The estimator on `map` (µε/N), with `site_error` `[n_sites, n_gauges, n_gauges]`, µε²/N², as
    /// the covariance of its error at every site, or empty.
    ///
    /// # Errors
    /// [`LiveError::Inverse`] when the map has fewer than three gauges or a value can't be used.
    pub fn estimator(
        &self,
        map: Arc<ResponseMap>,
        site_error: Vec<f64>,
    ) -> Result<ContactEstimator, LiveError> {
        let sites = Arc::new(ScanSites::farthest(map.skin(), self.n_sites)?);
        let noise = NoiseParams {
            model_error: ModelError {
                relative: self.map_error,
                friction_rms: friction_rms(self.friction),
                tip_ring_m: self.tip_ring_m,
                per_site: site_error,
                place_factor: self.place_factor,
            },
            ..NoiseParams::uniform(map.n_gauges(), self.noise_ue)
        };
        let params = EstimatorParams {
            max_contacts: self.max_contacts,
            max_force_n: self.max_force_n,
            wide: WideParams::up_to(self.palm_radius_m, self.tip_radius_m),
            ..EstimatorParams::default()
        };
        Ok(ContactEstimator::new(map, sites, noise, params)?)
    }
}

fn unchanged() -> f64 {
    1.0
}

/// Root mean square along each tangent of a friction coefficient uniform in 0…`most` in a random
/// direction, over the normal force.
#[must_use]
pub fn friction_rms(most: f64) -> f64 {
    most / 6.0_f64.sqrt()
}
