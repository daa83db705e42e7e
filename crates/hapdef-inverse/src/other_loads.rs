//! Loads on the limb that are no contacts: what the next joint passes on, weight, motion, temperature.

use nalgebra::DMatrix;

use crate::error::{InverseError, check_finite, check_length, check_not_negative, check_positive};

/// A load counts where it moves the gauges so many times as strongly, squared, as the largest component of noise alone:
/// that one passes the edge by a few per cent in any finite number of frames.
const LEAST_LOAD: f64 = 1.5;

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
    /// The loads that show in frames in which nothing touches, `frames` `[n_frames, n_gauges]`, tared: the
    /// directions in which they move more than noise of standard deviation `gauge_sd` `[n_gauges]` does (the
    /// principal components of the whitened frames beyond the largest of noise alone, Marchenko and Pastur 1967), the
    /// strongest first.
    /// Of amounts of standard deviation `margin` in units of those seen, since later ones may be larger.
    ///
    /// Needs no model of the limb, and has no error of one: on a limb whose map is calibrated, computed responses
    /// are off by per cents, which of hundreds of microstrains look like contacts.
    ///
    /// # Errors
    /// [`InverseError::Length`] for fewer frames than gauges; [`InverseError`] for values that can't be used.
    pub fn learned(frames: &[f64], gauge_sd: &[f64], margin: f64) -> Result<Self, InverseError> {
        let m = gauge_sd.len();
        let n = frames.len() / m.max(1);
        check_length("the untouched frames", n.max(m) * m, frames.len())?;
        check_finite("the untouched frames", frames)?;
        gauge_sd.iter().try_for_each(|sd| check_positive("gauge_sd", *sd))?;
        check_positive("margin", margin)?;
        let whitened = DMatrix::from_fn(m, n, |g, i| frames[i * m + g] / gauge_sd[g]);
        let seen = (&whitened * whitened.transpose() / n as f64).symmetric_eigen();
        let of_noise = (1.0 + (m as f64 / n as f64).sqrt()).powi(2);
        let mut order: Vec<usize> = (0..m).collect();
        order.sort_by(|a, b| seen.eigenvalues[*b].total_cmp(&seen.eigenvalues[*a]));
        let mut loads = Self::default();
        for k in order {
            let variance = seen.eigenvalues[k];
            if variance > LEAST_LOAD * of_noise {
                let sd = (variance - 1.0).sqrt();
                loads.response.extend((0..m).map(|g| seen.eigenvectors[(g, k)] * sd * gauge_sd[g]));
                loads.sd.push(margin);
            }
        }
        Ok(loads)
    }

    /// The same with an error of the responses, `relative` to what all loads together do to each gauge and apart for
    /// each: a load more for every gauge, none without an error. Responses computed of a drawn limb are off by as much
    /// as its map.
    #[must_use]
    pub fn with_response_error(mut self, relative: f64, n_gauges: usize) -> Self {
        if relative <= 0.0 {
            return self;
        }
        let mut variance = vec![0.0; n_gauges];
        for (row, sd) in self.rows(n_gauges).zip(&self.sd) {
            variance.iter_mut().zip(row).for_each(|(sum, unit)| *sum += (sd * unit).powi(2));
        }
        for (gauge, variance) in variance.into_iter().enumerate().filter(|(_, v)| *v > 0.0) {
            self.response.extend((0..n_gauges).map(|g| f64::from(u8::from(g == gauge))));
            self.sd.push(relative * variance.sqrt());
        }
        self
    }

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

    fn rows(&self, n_gauges: usize) -> impl Iterator<Item = &[f64]> {
        self.response.chunks_exact(n_gauges.max(1))
    }
}
