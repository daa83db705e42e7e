//! How gains and zeros may change.

use crate::error::{InverseError, check_length, check_not_negative, check_positive};

/// Parameters of [`crate::Recalibration`]. Zeros and noise are in the unit of the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct RecalibrationParams {
    /// Standard deviation of each gauge's noise in a touch `[n_gauges]`, quantisation included.
    pub gauge_sd: Vec<f64>,
    /// How far a relative gain may have changed between the calibration and the first touch, standard deviation.
    pub gain_sd: f64,
    /// How far it changes from one touch to the next, standard deviation; 0 forgets nothing.
    pub gain_drift_per_touch: f64,
    /// How far it changes in an hour, standard deviation; the variance grows with the time.
    pub gain_drift_per_hour: f64,
    /// How far a zero may be from none before the first untouched frame, standard deviation.
    pub zero_sd: f64,
    /// How far it changes from one touch to the next, standard deviation.
    pub zero_drift_per_touch: f64,
    /// Distance over which the map's error stays alike, m: its correlation falls as exp(−d²/2ℓ²).
    pub map_length_m: f64,
    /// Places whose map error is remembered; of more, the one touched longest ago is forgotten.
    pub max_places: usize,
    /// A touch whose χ² is less probable than this is refused.
    pub refuse_p: f64,
}

impl RecalibrationParams {
    /// Gains known to 3 % before the first touch, that drift by 0.1 % a touch and 0.2 % an hour; zeros that
    /// move by five times the noise from touch to touch.
    #[must_use]
    pub fn new(gauge_sd: Vec<f64>) -> Self {
        let largest = gauge_sd.iter().copied().fold(0.0, f64::max);
        Self {
            gauge_sd,
            gain_sd: 0.03,
            gain_drift_per_touch: 1e-3,
            gain_drift_per_hour: 2e-3,
            zero_sd: 1e3 * largest,
            zero_drift_per_touch: 5.0 * largest,
            // About the length with which a calibration begins to look for its own map's error.
            map_length_m: 0.01,
            // The state has so many values for each gauge; places touched longer ago say little of gains that drift.
            max_places: 32,
            // Hardly a right touch in the life of a limb, while one declared centimetres away is far beyond it:
            // `--example recalibration` counts both.
            refuse_p: 1e-6,
        }
    }

    /// Variance that a gain gains from one touch to the next, `hours` later.
    pub(super) fn gain_drift(&self, hours: f64) -> f64 {
        self.gain_drift_per_touch.powi(2) + hours * self.gain_drift_per_hour.powi(2)
    }

    pub(super) fn check(&self) -> Result<(), InverseError> {
        check_positive("the number of gauges in gauge_sd", self.gauge_sd.len() as f64)?;
        for &sd in &self.gauge_sd {
            check_positive("gauge_sd", sd)?;
        }
        check_not_negative("gain_sd", self.gain_sd)?;
        check_not_negative("gain_drift_per_touch", self.gain_drift_per_touch)?;
        check_not_negative("gain_drift_per_hour", self.gain_drift_per_hour)?;
        check_not_negative("zero_sd", self.zero_sd)?;
        check_not_negative("zero_drift_per_touch", self.zero_drift_per_touch)?;
        check_positive("map_length_m", self.map_length_m)?;
        check_positive("max_places", self.max_places as f64)?;
        check_positive("refuse_p", self.refuse_p)
    }

    pub(super) fn check_gauges(&self, n_gauges: usize) -> Result<(), InverseError> {
        check_length("gauge_sd", n_gauges, self.gauge_sd.len())
    }
}
