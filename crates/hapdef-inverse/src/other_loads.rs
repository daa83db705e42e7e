//! Loads on the limb that are no contacts: what the next joint passes on, weight, motion, temperature.

use crate::dense::{cholesky, inverse};
use crate::error::{InverseError, check_finite, check_length, check_not_negative};
use crate::noise::NoiseParams;

/// Loads that are no contacts, independent of each other: each adds an amount to the readings that is
/// only known up to a standard deviation.
///
/// They are nuisance parameters, marginalised (Gelman et al., Bayesian Data Analysis, 3rd ed., section
/// 14.6): a load of standard deviation s and response b adds s² b bᵀ to the covariance of the readings,
/// with which contacts are searched, counted and judged. Of a load that is measured, take off what is
/// measured ([`OtherLoads::take_off`]); `sd` is then what the measurement is worth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OtherLoads {
    /// What each gauge reads for one unit of each load `[n_loads, n_gauges]`, in the unit of the readings.
    pub response: Vec<f64>,
    /// Standard deviation of each load `[n_loads]`, in its own unit.
    pub sd: Vec<f64>,
}

impl OtherLoads {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.sd.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sd.is_empty()
    }

    /// Takes `amounts` `[n_loads]` of the loads off `readings` `[n_gauges]`.
    ///
    /// # Errors
    /// [`InverseError::Length`]; [`InverseError`] for an amount that is not finite.
    pub fn take_off(&self, amounts: &[f64], readings: &mut [f64]) -> Result<(), InverseError> {
        check_length("the loads' amounts", self.len(), amounts.len())?;
        check_finite("the loads' amounts", amounts)?;
        check_length("the loads' response", self.len() * readings.len(), self.response.len())?;
        for (row, amount) in self.rows(readings.len()).zip(amounts) {
            readings.iter_mut().zip(row).for_each(|(reading, unit)| *reading -= amount * unit);
        }
        Ok(())
    }

    pub(crate) fn check(&self, n_gauges: usize) -> Result<(), InverseError> {
        check_length("the loads' response", self.len() * n_gauges, self.response.len())?;
        check_finite("the loads' response", &self.response)?;
        self.sd.iter().try_for_each(|sd| check_not_negative("the loads' sd", *sd))
    }

    /// Adds Σ s² b bᵀ of the gauges `live` to `covariance` `[n_live, n_live]`.
    pub(crate) fn add_to(&self, live: &[usize], n_gauges: usize, covariance: &mut [f64]) {
        for (row, sd) in self.rows(n_gauges).zip(&self.sd) {
            for (into, &g) in covariance.chunks_exact_mut(live.len()).zip(live) {
                let scale = sd * sd * row[g];
                into.iter_mut().zip(live).for_each(|(c, &h)| *c += scale * row[h]);
            }
        }
    }

    /// How many numbers of a frame the loads take: m − tr (R (R + Σ s² b bᵀ)⁻¹), rounded, R the noise of
    /// the gauges `live`.
    pub(crate) fn n_taken(&self, noise: &NoiseParams, live: &[usize]) -> usize {
        let m = live.len();
        let mut l = vec![0.0; m * m];
        self.add_to(live, noise.gauge_sd.len(), &mut l);
        let variance: Vec<f64> = live.iter().map(|&gauge| noise.variance(gauge)).collect();
        (0..m).for_each(|g| l[g * m + g] += variance[g]);
        let mut inverted = vec![0.0; m * m];
        if self.is_empty() || !cholesky(&mut l, m, 0.0) {
            return 0;
        }
        inverse(&l, m, &mut inverted);
        let left: f64 = (0..m).map(|g| variance[g] * inverted[g * m + g]).sum();
        (m as f64 - left).round() as usize
    }

    fn rows(&self, n_gauges: usize) -> impl Iterator<Item = &[f64]> {
        self.response.chunks_exact(n_gauges.max(1))
    }
}
