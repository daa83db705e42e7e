//! What readings and the response map are worth: covariances.

use crate::dense::{cholesky, inverse};
use crate::error::{InverseError, check_finite, check_length, check_not_negative, check_positive};
use crate::other_loads::OtherLoads;

/// Noise of the readings and error of the response map. All in the unit of the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseParams {
    /// Standard deviation of each gauge's noise `[n_gauges]`.
    pub gauge_sd: Vec<f64>,
    /// Step of each gauge's converter `[n_gauges]`, which adds step²/12; empty for none. Left out, a held
    /// press on a converter of 12 bits showed a second, weak contact in 18 % of the frames.
    pub quantisation_step: Vec<f64>,
    /// Error of the response map.
    pub model_error: ModelError,
    /// The force at which the error of the map is put into the scan's whitening, N.
    pub typical_force_n: f64,
    /// Loads that are no contacts; none where nothing but contacts strains the limb.
    pub loads: OtherLoads,
}

/// Error of the response map: a contact of force A adds A² C(p) to the covariance of the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelError {
    /// ρ: C gets a diagonal ½ ρ² (gᵢ² + sᵢ² q), where sᵢ² is the mean square of gᵢ over the skin
    /// and q the mean of gⱼ²/sⱼ² over the gauges: relative, and nowhere zero.
    pub relative: f64,
    /// Root mean square of tangential over normal force, each tangent: C gets μ² (g_t₁ g_t₁ᵀ +
    /// g_t₂ g_t₂ᵀ). A friction coefficient uniform in 0…μ in a random direction has μ/√6.
    pub friction_rms: f64,
    /// How much wider than the map's tip those that touch are, m: C gets d dᵀ with d the mean of g on a
    /// ring of this radius around p less g(p); see [`crate::tip_ring_m`].
    pub tip_ring_m: f64,
    /// A covariance for each scan site `[n_sites, n_gauges, n_gauges]`, per N²; empty for none.
    pub per_site: Vec<f64>,
    /// What the covariance of a contact's place is multiplied by when it is reported. It changes no
    /// search, no count and no verdict.
    pub place_factor: f64,
}

impl Default for ModelError {
    /// A map without error.
    fn default() -> Self {
        Self {
            relative: 0.0,
            friction_rms: 0.0,
            tip_ring_m: 0.0,
            per_site: Vec::new(),
            place_factor: 1.0,
        }
    }
}

impl NoiseParams {
    /// The same standard deviation on every gauge, nothing else.
    #[must_use]
    pub fn uniform(n_gauges: usize, sd: f64) -> Self {
        Self {
            gauge_sd: vec![sd; n_gauges],
            quantisation_step: Vec::new(),
            model_error: ModelError::default(),
            typical_force_n: 10.0,
            loads: OtherLoads::default(),
        }
    }

    pub(crate) fn check(&self, n_gauges: usize, n_sites: usize) -> Result<(), InverseError> {
        check_length("gauge_sd", n_gauges, self.gauge_sd.len())?;
        for &sd in &self.gauge_sd {
            check_positive("gauge_sd", sd)?;
        }
        if !self.quantisation_step.is_empty() {
            check_length("quantisation_step", n_gauges, self.quantisation_step.len())?;
        }
        for &step in &self.quantisation_step {
            check_not_negative("quantisation_step", step)?;
        }
        check_positive("typical_force_n", self.typical_force_n)?;
        self.loads.check(n_gauges)?;
        let error = &self.model_error;
        check_not_negative("model_error.relative", error.relative)?;
        check_not_negative("model_error.friction_rms", error.friction_rms)?;
        check_not_negative("model_error.tip_ring_m", error.tip_ring_m)?;
        check_positive("model_error.place_factor", error.place_factor)?;
        if !error.per_site.is_empty() {
            let expected = n_sites * n_gauges * n_gauges;
            check_length("model_error.per_site", expected, error.per_site.len())?;
            check_finite("model_error.per_site", &error.per_site)?;
        }
        Ok(())
    }

    /// Variance of a gauge's noise with its converter's.
    pub(crate) fn variance(&self, gauge: usize) -> f64 {
        let step = self.quantisation_step.get(gauge).copied().unwrap_or(0.0);
        self.gauge_sd[gauge].powi(2) + step * step / 12.0
    }

    /// Covariance of the readings of the gauges `live` of an untouched limb `[n_live, n_live]`: noise and
    /// the loads that are no contacts.
    pub(crate) fn covariance(&self, live: &[usize]) -> Vec<f64> {
        let m = live.len();
        let mut covariance = vec![0.0; m * m];
        for (g, &gauge) in live.iter().enumerate() {
            covariance[g * m + g] = self.variance(gauge);
        }
        self.loads.add_to(live, self.gauge_sd.len(), &mut covariance);
        covariance
    }

    /// How many numbers of a frame of the gauges `live` the loads take: m − tr (N S⁻¹), rounded, N the noise and S
    /// the covariance with them.
    pub(crate) fn n_taken(&self, live: &[usize]) -> usize {
        let m = live.len();
        let (mut l, mut inverted) = (self.covariance(live), vec![0.0; m * m]);
        if self.loads.is_empty() || !cholesky(&mut l, m, 0.0) {
            return 0;
        }
        inverse(&l, m, &mut inverted);
        let each = live.iter().enumerate();
        let left: f64 = each.map(|(g, gauge)| self.variance(*gauge) * inverted[g * m + g]).sum();
        (m as f64 - left).round() as usize
    }
}

impl ModelError {
    pub(crate) fn is_none(&self) -> bool {
        let is_zero = |v: f64| v == 0.0;
        [self.relative, self.friction_rms, self.tip_ring_m].into_iter().all(is_zero)
            && self.per_site.is_empty()
    }
}
