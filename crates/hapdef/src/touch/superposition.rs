//! Contacts by superposition, as the scene asks for it.

use std::sync::Arc;

use hapdef_inverse::{
    ContactEstimate, ContactEstimator, EstimatorParams, EstimatorScratch, ModelError, NoiseParams,
    ResponseMap, ScanSites, Verdict,
};

use super::{Touch, TouchContact, TouchEstimator, TouchQuality, TouchUncertainty};
use crate::error::HapdefError;
use crate::scene::{Scene, SuperpositionSpec};

/// [`ContactEstimator`] with its buffers.
pub struct Superposition {
    estimator: ContactEstimator,
    scratch: EstimatorScratch,
    estimate: ContactEstimate,
}

/// The estimator that the scene's section asks for, on the limb's response `map`.
///
/// # Errors
/// [`HapdefError::Inverse`] when the map has fewer than three gauges or a value can't be used.
pub fn superposition(
    scene: &Scene,
    spec: &SuperpositionSpec,
    map: ResponseMap,
) -> Result<Superposition, HapdefError> {
    let sites = ScanSites::farthest(map.skin(), spec.n_sites)?;
    let noise = NoiseParams {
        model_error: ModelError {
            relative: spec.map_error,
            friction_rms: friction_rms(spec.friction),
            per_site: Vec::new(),
        },
        ..NoiseParams::uniform(map.n_gauges(), spec.noise_ue)
    };
    let params = estimator_params(scene);
    let estimator = ContactEstimator::new(Arc::new(map), Arc::new(sites), noise, params)?;
    Ok(Superposition::new(estimator))
}

/// Knobs of the estimator for a scene: no more contacts than the scene has, and no force beyond
/// half more than its strongest, which a contact of where the map is uncertain would else explain
/// anything with.
#[must_use]
pub fn estimator_params(scene: &Scene) -> EstimatorParams {
    EstimatorParams {
        max_contacts: scene.contact.max_contacts,
        max_force_n: 1.5 * scene.contact.force_range_n[1],
        ..EstimatorParams::default()
    }
}

/// Root mean square along each tangent of a friction coefficient uniform in 0…`most` in a random
/// direction, over the normal force.
pub(super) fn friction_rms(most: f64) -> f64 {
    most / 6.0_f64.sqrt()
}

impl Superposition {
    /// Wraps an estimator.
    #[must_use]
    pub fn new(estimator: ContactEstimator) -> Self {
        Self {
            scratch: estimator.scratch(),
            estimate: ContactEstimate::default(),
            estimator,
        }
    }

    /// The last frame's estimate in full.
    #[must_use]
    pub fn estimate_in_full(&self) -> &ContactEstimate {
        &self.estimate
    }
}

impl TouchEstimator for Superposition {
    fn name(&self) -> &'static str {
        "superposition"
    }

    fn n_gauges(&self) -> usize {
        self.estimator.map().n_gauges()
    }

    fn estimate(&mut self, readings_ue: &[f64], touch: &mut Touch) -> Result<(), HapdefError> {
        self.estimator
            .estimate_into(readings_ue, &mut self.scratch, &mut self.estimate)?;
        let skin = self.estimator.map().skin();
        touch.contacts.clear();
        touch
            .contacts
            .extend(self.estimate.contacts.iter().map(|contact| TouchContact {
                position_m: contact.position_m,
                force_n: contact.force_n,
                uncertainty: Some(TouchUncertainty {
                    tangents: skin.tangents(&contact.point),
                    covariance: contact.covariance,
                }),
            }));
        touch.quality = Some(TouchQuality {
            is_identified: !matches!(self.estimate.verdict, Verdict::NotIdentifiable(_)),
            chi2: self.estimate.chi2,
            n_dof: self.estimate.n_dof,
            p_value: self.estimate.p_value,
            n_alternatives: self.estimate.runner_ups.len(),
        });
        Ok(())
    }
}
