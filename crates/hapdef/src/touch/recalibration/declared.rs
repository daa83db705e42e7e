//! A touch as somebody declares it, before it is found on the skin.

use hapdef_inverse::{KnownTouch, Press, RecalibrationParams, Skin, TouchZero};
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::error::HapdefError;

/// A touch of known place and force, with what the gauges read.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredTouch {
    /// Where it comes from, for the journal: a file and its line.
    pub from: String,
    /// When, on any clock that goes on from touch to touch, s; none where it is not known.
    pub t_s: Option<f64>,
    /// Where, in the deck's coordinates; the nearest point of the skin counts, m.
    pub position_m: [f64; 3],
    /// With which force.
    pub force: DeclaredForce,
    /// Standard deviation of the place along the skin, m.
    pub position_sd_m: f64,
    /// Standard deviation of each component of the force, N.
    pub force_sd_n: f64,
    /// Readings while it is held `[n_gauges]`, µε.
    pub readings_ue: Vec<f64>,
    /// What they are above.
    pub zero: TouchZero,
}

/// The force on the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeclaredForce {
    /// Against the skin's normal, N.
    Normal(f64),
    /// Along x, y, z of the deck's coordinates, N.
    Vector([f64; 3]),
}

/// What is assumed of gauges and touches.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TouchAssumptions {
    /// Standard deviation of a reading's noise, µε, quantisation included.
    pub noise_ue: f64,
    /// How far a relative gain may have changed between the calibration and the first touch, standard deviation.
    pub gain_sd: f64,
    /// How far it changes from one touch to the next, standard deviation.
    pub gain_drift_per_touch: f64,
    /// How far it changes in an hour, standard deviation.
    pub gain_drift_per_hour: f64,
    /// A touch whose readings are less probable than this is refused.
    pub refuse_p: f64,
    /// Farthest a touch may lie from the skin, m.
    pub off_skin_m: f64,
}

impl Default for TouchAssumptions {
    /// As [`RecalibrationParams::new`] has them for a noise of 1 µε; 2 mm off the skin.
    fn default() -> Self {
        let RecalibrationParams {
            gain_sd,
            gain_drift_per_touch,
            gain_drift_per_hour,
            refuse_p,
            ..
        } = RecalibrationParams::new(vec![1.0]);
        let (noise_ue, off_skin_m) = (1.0, 2e-3);
        Self { noise_ue, gain_sd, gain_drift_per_touch, gain_drift_per_hour, refuse_p, off_skin_m }
    }
}

impl TouchAssumptions {
    pub(super) fn params(&self, n_gauges: usize) -> RecalibrationParams {
        RecalibrationParams {
            gain_sd: self.gain_sd,
            gain_drift_per_touch: self.gain_drift_per_touch,
            gain_drift_per_hour: self.gain_drift_per_hour,
            refuse_p: self.refuse_p,
            ..RecalibrationParams::new(vec![self.noise_ue; n_gauges])
        }
    }
}

impl DeclaredTouch {
    /// The touch on `skin`, at most `off_skin_m` from where it was declared, `hours_since` the touch before.
    pub(super) fn on(
        &self,
        skin: &Skin,
        off_skin_m: f64,
        hours_since: f64,
    ) -> Result<KnownTouch, HapdefError> {
        let position = Point3::from(self.position_m);
        let point = Press::at_position(skin, &position, off_skin_m, 1.0, Vec::new())?.point;
        let force_n = match self.force {
            DeclaredForce::Normal(force_n) => -skin.normal(&point) * force_n,
            DeclaredForce::Vector(force_n) => Vector3::from(force_n),
        };
        Ok(KnownTouch {
            point,
            force_n,
            position_sd_m: self.position_sd_m,
            force_sd_n: self.force_sd_n,
            readings: self.readings_ue.clone(),
            zero: self.zero.clone(),
            hours_since,
        })
    }
}
