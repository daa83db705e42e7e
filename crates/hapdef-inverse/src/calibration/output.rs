//! What a calibration gives.

use nalgebra::Point3;

use crate::noise::ModelError;
use crate::response::ResponseMap;
use crate::skin_point::SkinPoint;

/// A calibrated map and what it is worth.
#[derive(Clone, Debug)]
pub struct Calibrated {
    /// The map. Modes change it in all directions; the residual, which presses against the normal
    /// show, only along the normal.
    pub map: ResponseMap,
    /// Its error, a covariance for each scan site, from the residual's posterior and rescaled so
    /// that held-out presses have unit variance.
    pub model_error: ModelError,
    /// What was found.
    pub info: CalibrationInfo,
}

/// What a calibration found.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationInfo {
    /// Presses that the map rests on.
    pub n_used: usize,
    /// Presses that were left out as bad, by index.
    pub rejected: Vec<RejectedPress>,
    /// Coefficients of the modes, posterior mean: for each mode in the order given the gauges' own
    /// `[n_gauges]` or the shared one `[1]`.
    pub mode_coefficients: Vec<Vec<f64>>,
    /// Relative change of each gauge's gain `[n_gauges]`.
    pub gains: Vec<f64>,
    /// Causes that are farther from what was expected than four standard deviations of their
    /// priors: an expectation, a press or a gauge is wrong.
    pub beyond_prior: Vec<BeyondPrior>,
    /// Correlation length of each gauge's residual `[n_gauges]`, m.
    pub lengths_m: Vec<f64>,
    /// Size of each gauge's residual, relative to the map `[n_gauges]`.
    pub residual_sizes: Vec<f64>,
    /// What each gauge's posterior variance was multiplied by on average `[n_gauges]`.
    pub variance_scales: Vec<f64>,
    /// The error at each press as if it had not been used (leave one out), in the order of the
    /// presses used.
    pub held_out: Vec<HeldOutError>,
    /// Root mean square of those errors over that of the readings, noise included.
    pub relative_error: f64,
    /// The same before calibration.
    pub relative_error_before: f64,
    /// Relative error at presses not used, by number of presses used.
    pub curve: Vec<CurvePoint>,
    /// Where the next presses help most, the best first.
    pub next: Vec<NextPress>,
}

/// A cause that came out farther from what was expected than its prior allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeyondPrior {
    /// Index of the mode; `None` for a gauge's gain.
    pub mode: Option<usize>,
    /// Index of the gauge; `None` for a mode that all share.
    pub gauge: Option<usize>,
    /// Its coefficient in standard deviations of its prior.
    pub sds: f64,
}

/// A press as if it had not been used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOutError {
    /// Index of the press.
    pub press: usize,
    /// Norm of the error over the gauges, per newton.
    pub error: f64,
    /// Norm of the measured response, per newton.
    pub response: f64,
    /// Mean square of the error over its standard deviation, over the gauges.
    pub mean_square_z: f64,
}

/// A point of the learning curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Presses used.
    pub n_presses: usize,
    /// Root mean square of the error at other presses over that of their response.
    pub relative_error: f64,
}

/// A place for a further press.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextPress {
    /// Where on the skin.
    pub point: SkinPoint,
    /// Where in space, m.
    pub position_m: Point3<f64>,
    /// Root mean square over the gauges of the map's standard deviation there, relative to each
    /// gauge's typical response, presses proposed before it made.
    pub relative_sd: f64,
}

/// A press that was left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RejectedPress {
    /// Index of the press.
    pub press: usize,
    /// Why.
    pub reason: RejectReason,
}

/// Why a press was left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RejectReason {
    /// Its readings contradict those of the presses around it.
    Outlier {
        /// χ² of its residual, with as many degrees of freedom as there are gauges.
        chi2: f64,
        /// The χ² at which presses are rejected.
        limit: f64,
    },
    /// It is one of more presses than are used.
    NotNeeded,
}

impl CalibrationInfo {
    /// Presses needed for a relative error `relative`, from a power law through the learning curve's
    /// last points; `None` where the curve does not fall.
    #[must_use]
    pub fn presses_for(&self, relative: f64) -> Option<f64> {
        let tail = &self.curve[self.curve.len().saturating_sub(3)..];
        let n = tail.len() as f64;
        let logs = |p: &CurvePoint| ((p.n_presses as f64).ln(), p.relative_error.ln());
        let mean = tail.iter().map(logs).fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
        let (mut xx, mut xy) = (0.0, 0.0);
        for point in tail {
            let (x, y) = logs(point);
            xx += (x - mean.0).powi(2);
            xy += (x - mean.0) * (y - mean.1);
        }
        let slope = xy / xx;
        let is_falling = slope.is_finite() && slope < 0.0 && relative > 0.0;
        is_falling.then(|| (mean.0 + (relative.ln() - mean.1) / slope).exp())
    }
}
