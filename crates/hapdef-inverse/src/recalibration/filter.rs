//! Gains and zeros, followed from touch to touch.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Point3};

use super::change::GainChange;
use super::output::TouchInfo;
use super::params::RecalibrationParams;
use super::places::Places;
use super::touch::{Expected, KnownTouch, TouchZero};
use crate::chi_square::{tail_point, upper_tail};
use crate::error::{InverseError, check_finite, check_length};
use crate::response::ResponseMap;

/// What known touches have shown of the gauges since the calibration: mean and covariance of each gauge's relative
/// gain and zero.
#[derive(Clone, Debug)]
pub struct Recalibration {
    params: RecalibrationParams,
    /// Gains, then zeros, then the map's error at each place, per newton `[2 + n_places, n_gauges]`.
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
    places: Places,
    n_touches: usize,
}

/// value = H x + noise.
struct Seen {
    h: DMatrix<f64>,
    value: DVector<f64>,
    noise: DMatrix<f64>,
}

/// What was seen beyond what was expected.
struct Innovation {
    value: DVector<f64>,
    covariance: DMatrix<f64>,
    factor: Cholesky<f64, Dyn>,
    /// Covariance of the state's error with it.
    shared: DMatrix<f64>,
}

impl Recalibration {
    /// As the calibration left the gauges.
    ///
    /// # Errors
    /// [`InverseError`] for parameters that can't be used.
    pub fn new(params: RecalibrationParams) -> Result<Self, InverseError> {
        params.check()?;
        let m = params.gauge_sd.len();
        let variance = |i: usize| if i < m { params.gain_sd } else { params.zero_sd }.powi(2);
        let covariance = DMatrix::from_diagonal(&DVector::from_fn(2 * m, |i, _| variance(i)));
        let mean = DVector::zeros(2 * m);
        Ok(Self { params, mean, covariance, places: Places::default(), n_touches: 0 })
    }

    /// The same from here on with other parameters; what was assumed before the first touch stays.
    ///
    /// # Errors
    /// [`InverseError`] for parameters that can't be used, or of another number of gauges.
    pub fn with_params(self, params: RecalibrationParams) -> Result<Self, InverseError> {
        params.check()?;
        params.check_gauges(self.n_gauges())?;
        Ok(Self { params, ..self })
    }

    /// Takes a touch, or refuses it and stays as it is. `map` is the map as it was calibrated, and `map_error` the
    /// covariance of its error at the touch, per N² `[n_gauges, n_gauges]`; empty for none.
    ///
    /// # Errors
    /// [`InverseError`] for values that can't be used: another number of gauges, readings that are not finite, a
    /// force that does not press, a covariance that is none.
    pub fn update(
        &mut self,
        map: &ResponseMap,
        map_error: &[f64],
        touch: &KnownTouch,
    ) -> Result<TouchInfo, InverseError> {
        self.check(map, map_error, touch)?;
        let mut next = self.clone();
        next.n_touches += 1;
        next.drift(touch.hours_since);
        let has_new_zeros = match &touch.zero {
            TouchZero::Untouched(readings) => next.take_zeros(readings)?,
            TouchZero::Tared | TouchZero::Followed => false,
        };
        let expected = Expected::of(map, touch, &self.params.gauge_sd);
        let seen = next.seen(expected, map_error, touch);
        let innovation = next.innovation(&seen)?;
        let mut info = next.info(&seen, &innovation, has_new_zeros);
        if info.is_accepted {
            next.correct(innovation);
            info.gains_after = next.gains().to_vec();
            *self = next;
        }
        Ok(info)
    }

    /// Number of gauges.
    #[must_use]
    pub fn n_gauges(&self) -> usize {
        self.params.gauge_sd.len()
    }

    /// Touches that were taken.
    #[must_use]
    pub fn n_touches(&self) -> usize {
        self.n_touches
    }

    /// The gains' change since the calibration.
    #[must_use]
    pub fn change(&self) -> GainChange {
        let m = self.n_gauges();
        let covariance = self.covariance.view((0, 0), (m, m));
        GainChange {
            gains: self.gains().to_vec(),
            covariance: covariance.iter().copied().collect(),
        }
    }

    /// Each gauge's zero and its standard deviation `[n_gauges]`, in the unit of the readings; as assumed before the
    /// first touch until an untouched frame was seen.
    #[must_use]
    pub fn zeros(&self) -> Vec<(f64, f64)> {
        let zeros = self.n_gauges()..2 * self.n_gauges();
        zeros.map(|i| (self.mean[i], self.covariance[(i, i)].sqrt())).collect()
    }

    fn gains(&self) -> &[f64] {
        &self.mean.as_slice()[..self.n_gauges()]
    }

    fn check(
        &self,
        map: &ResponseMap,
        map_error: &[f64],
        touch: &KnownTouch,
    ) -> Result<(), InverseError> {
        let m = map.n_gauges();
        self.params.check_gauges(m)?;
        if !map_error.is_empty() {
            check_length("the map's error at a touch", m * m, map_error.len())?;
            check_finite("the map's error at a touch", map_error)?;
        }
        touch.check(map)
    }

    /// Gains and zeros have walked since the touch before.
    fn drift(&mut self, hours: f64) {
        let (m, gain) = (self.n_gauges(), self.params.gain_drift(hours));
        let zero = self.params.zero_drift_per_touch.powi(2);
        for i in 0..2 * m {
            self.covariance[(i, i)] += if i < m { gain } else { zero };
        }
    }

    /// Takes an untouched frame; `true` where the zeros are farther off than they drift and begin anew with it.
    fn take_zeros(&mut self, readings: &[f64]) -> Result<bool, InverseError> {
        let m = self.n_gauges();
        let variances = self.params.gauge_sd.iter().map(|sd| sd * sd);
        let seen = Seen {
            h: DMatrix::from_fn(m, self.mean.len(), |i, j| if j == m + i { 1.0 } else { 0.0 }),
            value: DVector::from_column_slice(readings),
            noise: DMatrix::from_diagonal(&DVector::from_iterator(m, variances)),
        };
        let innovation = self.innovation(&seen)?;
        let is_far = innovation.p_value() < self.params.refuse_p;
        if is_far {
            self.forget_zeros();
        }
        let innovation = self.innovation(&seen)?;
        self.correct(innovation);
        Ok(is_far)
    }

    fn forget_zeros(&mut self) {
        let m = self.n_gauges();
        for i in m..2 * m {
            self.mean[i] = 0.0;
            self.covariance.row_mut(i).fill(0.0);
            self.covariance.column_mut(i).fill(0.0);
            self.covariance[(i, i)] = self.params.zero_sd.powi(2);
        }
    }

    /// What a touch shows; its place is remembered.
    fn seen(&mut self, expected: Expected, map_error: &[f64], touch: &KnownTouch) -> Seen {
        let m = self.n_gauges();
        let mut noise = expected.noise;
        let mut place = None;
        if !map_error.is_empty() {
            let error = DMatrix::from_row_slice(m, m, map_error);
            let (index, alike) = self.place(&expected.position, &error);
            noise += error * (expected.force_n.powi(2) * (1.0 - alike * alike));
            place = Some((index, expected.force_n * alike));
        }
        let mut h = DMatrix::zeros(m, self.mean.len());
        for i in 0..m {
            h[(i, i)] = expected.response[i];
            h[(i, m + i)] = if touch.zero == TouchZero::Tared { 0.0 } else { 1.0 };
            if let Some((index, force_n)) = place {
                h[(i, (2 + index) * m + i)] = force_n;
            }
        }
        let value = DVector::from_column_slice(&touch.readings) - expected.response;
        Seen { h, value, noise }
    }

    /// The place of the state whose map error is most like that at `position`, and their correlation: a new one
    /// where all are far, with the map's `error` there.
    fn place(&mut self, position: &Point3<f64>, error: &DMatrix<f64>) -> (usize, f64) {
        let (m, touch) = (self.n_gauges(), self.n_touches);
        if let Some((index, alike)) = self.places.like(position, self.params.map_length_m) {
            self.places.touched(index, touch);
            return (index, alike);
        }
        if let Some(oldest) = self.places.make_room(self.params.max_places) {
            let start = (2 + oldest) * m;
            self.mean = std::mem::take(&mut self.mean).remove_rows(start, m);
            let covariance = std::mem::take(&mut self.covariance);
            self.covariance = covariance.remove_rows(start, m).remove_columns(start, m);
        }
        let n = self.mean.len();
        self.mean = std::mem::take(&mut self.mean).resize_vertically(n + m, 0.0);
        self.covariance = std::mem::take(&mut self.covariance).resize(n + m, n + m, 0.0);
        self.covariance.view_mut((n, n), (m, m)).copy_from(error);
        (self.places.add(*position, touch), 1.0)
    }

    /// ν = y − H x and its covariance S = H P Hᵀ + R.
    fn innovation(&self, seen: &Seen) -> Result<Innovation, InverseError> {
        let shared = &self.covariance * seen.h.transpose();
        let covariance = symmetric(&(&seen.h * &shared + &seen.noise));
        let what = "the covariance of a touch's readings";
        let factor = covariance.clone().cholesky();
        let factor = factor.ok_or(InverseError::NotPositiveDefinite { what })?;
        let value = &seen.value - &seen.h * &self.mean;
        Ok(Innovation { value, covariance, factor, shared })
    }

    fn info(&self, seen: &Seen, innovation: &Innovation, has_new_zeros: bool) -> TouchInfo {
        let m = self.n_gauges();
        let p_value = innovation.p_value();
        let response = (0..m).map(|i| seen.h[(i, i)]);
        let known = &seen.h * &self.mean;
        TouchInfo {
            is_accepted: p_value >= self.params.refuse_p,
            chi2: innovation.chi2(),
            limit: tail_point(self.params.refuse_p, m),
            p_value,
            expected: response.zip(known.iter()).map(|(s, known)| s + known).collect(),
            innovation: innovation.value.as_slice().to_vec(),
            innovation_sd: innovation.covariance.diagonal().iter().map(|v| v.sqrt()).collect(),
            has_new_zeros,
            gains_before: self.gains().to_vec(),
            gains_after: self.gains().to_vec(),
        }
    }

    /// x ← x + P Hᵀ S⁻¹ ν and P ← P − P Hᵀ S⁻¹ H P, as W Wᵀ with W = P Hᵀ L⁻ᵀ and S = L Lᵀ.
    fn correct(&mut self, innovation: Innovation) {
        self.mean += &innovation.shared * innovation.factor.solve(&innovation.value);
        let mut whitened = innovation.shared.transpose();
        innovation.factor.l_dirty().solve_lower_triangular_mut(&mut whitened);
        self.covariance.gemm_tr(-1.0, &whitened, &whitened, 1.0);
        self.covariance = symmetric(&self.covariance);
    }
}

impl Innovation {
    /// νᵀ S⁻¹ ν.
    fn chi2(&self) -> f64 {
        self.value.dot(&self.factor.solve(&self.value))
    }

    fn p_value(&self) -> f64 {
        upper_tail(self.chi2(), self.value.len())
    }
}

fn symmetric(a: &DMatrix<f64>) -> DMatrix<f64> {
    (a + a.transpose()) * 0.5
}
