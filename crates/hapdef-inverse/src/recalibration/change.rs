//! A map and its error with gains that have changed.

use crate::error::{InverseError, check_finite, check_length};
use crate::response::ResponseMap;
use crate::sites::ScanSites;

/// How the gauges' gains have changed since a calibration, and how well that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct GainChange {
    /// Relative change of each gain `[n_gauges]`.
    pub gains: Vec<f64>,
    /// Its covariance `[n_gauges, n_gauges]`.
    pub covariance: Vec<f64>,
}

impl GainChange {
    /// The map of gauges whose gains have changed: (1 + γ) ∘ g.
    ///
    /// # Errors
    /// [`InverseError`] for another number of gauges than the map's, or gains that are not finite.
    pub fn map(&self, map: &ResponseMap) -> Result<ResponseMap, InverseError> {
        self.check(map)?;
        let values = map.nodal().into_iter().zip(self.gains.iter().cycle());
        let changed: Vec<_> = values.map(|(value, gain)| value * (1.0 + gain)).collect();
        ResponseMap::from_values(map.skin().clone(), map.n_gauges(), &changed)
    }

    /// The error of that map at `sites` `[n_sites, n_gauges, n_gauges]`, per N², from that of `map` as it was
    /// calibrated: (1 + γᵢ)(1 + γⱼ) Cᵢⱼ + Γᵢⱼ gᵢ gⱼ, with Γ the covariance of the gains.
    ///
    /// # Errors
    /// As [`GainChange::map`]; [`InverseError::Length`] for an error at other sites.
    pub fn site_error(
        &self,
        map: &ResponseMap,
        sites: &ScanSites,
        site_error: &[f64],
    ) -> Result<Vec<f64>, InverseError> {
        self.check(map)?;
        let m = map.n_gauges();
        check_length("site_error", sites.len() * m * m, site_error.len())?;
        let mut changed = Vec::with_capacity(site_error.len());
        for (point, error) in sites.points().iter().zip(site_error.chunks_exact(m * m)) {
            let g = map.normal(point);
            for (at, error) in error.iter().enumerate() {
                let (i, j) = (at / m, at % m);
                let scale = (1.0 + self.gains[i]) * (1.0 + self.gains[j]);
                changed.push(scale * error + self.covariance[at] * g[i] * g[j]);
            }
        }
        Ok(changed)
    }

    fn check(&self, map: &ResponseMap) -> Result<(), InverseError> {
        let m = map.n_gauges();
        check_length("the gains", m, self.gains.len())?;
        check_length("the covariance of the gains", m * m, self.covariance.len())?;
        check_finite("the gains", &self.gains)?;
        check_finite("the covariance of the gains", &self.covariance)
    }
}
