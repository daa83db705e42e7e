//! What a calibration may change, and how far.

use crate::error::{InverseError, check_length, check_not_negative, check_positive};
use crate::response::ResponseMap;

/// Whether all gauges share a mode's coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeScope {
    /// A coefficient of its own for every gauge: a gauge's shift or turn.
    EachGauge,
    /// One coefficient: the stiffness of a part of the limb.
    Shared,
}

/// A way in which the response may differ: its derivative with respect to one cause.
#[derive(Clone, Copy, Debug)]
pub struct ModeMap<'a> {
    /// Change of the response per unit of the cause, on the skin of the map that is calibrated, made
    /// with the same [`crate::ResponseParams`].
    pub map: &'a ResponseMap,
    /// Whose coefficient it is.
    pub scope: ModeScope,
    /// Standard deviation of the coefficient before any press, in the cause's unit.
    pub prior_sd: f64,
}

/// Parameters of [`crate::Calibrated::fit`].
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationParams {
    /// Standard deviation of each gauge's noise in a press `[n_gauges]`, in the unit of the
    /// readings; quantisation included.
    pub gauge_sd: Vec<f64>,
    /// Standard deviation of a press's position along each tangent, m: adds A² |∇g|² σ² to its
    /// noise.
    pub position_sd_m: f64,
    /// Standard deviation of a press's force, N: adds g² σ² to its noise.
    pub force_sd_n: f64,
    /// Standard deviation of each gauge's relative gain.
    pub gain_sd: f64,
    /// Standard deviation of what a gauge takes from each other one, relative to their typical
    /// responses; 0 for no mix.
    pub mix_sd: f64,
    /// Length over which the map's size is averaged to scale the residual's, m.
    pub envelope_m: f64,
    /// Length over which the map's variance is taken to scale the residual's near a gauge, m.
    pub steep_m: f64,
    /// Correlation lengths of the residual that are tried, m.
    pub lengths_m: Vec<f64>,
    /// Correlation lengths of what varies with the map's variance that are tried, m.
    pub steep_lengths_m: Vec<f64>,
    /// Presses at most on which lengths and sizes are chosen.
    pub n_evidence: usize,
    /// Presses at most; of more, this many spread over the list are used.
    pub max_presses: usize,
    /// A press whose held-out residual is less probable than this is rejected.
    pub reject_p: f64,
    /// Places proposed for the next presses.
    pub n_next: usize,
    /// Whether presses are held out to see how large the reported regions have to be, which repeats the fit
    /// up to ten times; else [`crate::ModelError::place_factor`] is 1.
    pub holds_out: bool,
    /// Threads; the result does not depend on it.
    pub n_threads: usize,
}

impl CalibrationParams {
    /// Gains known to 3 %, no mix, presses placed exactly.
    #[must_use]
    pub fn new(gauge_sd: Vec<f64>) -> Self {
        Self {
            gauge_sd,
            position_sd_m: 0.0,
            force_sd_n: 0.0,
            gain_sd: 0.03,
            mix_sd: 0.0,
            envelope_m: 12e-3,
            steep_m: 4e-3,
            lengths_m: vec![6e-3, 9e-3, 14e-3, 21e-3, 32e-3],
            steep_lengths_m: vec![3e-3, 5e-3, 8e-3],
            n_evidence: 600,
            max_presses: 4000,
            reject_p: 1e-9,
            n_next: 10,
            holds_out: true,
            n_threads: 2,
        }
    }

    pub(crate) fn widths_m(&self) -> [f64; 2] {
        [self.envelope_m, self.steep_m]
    }

    pub(crate) fn check(&self, n_gauges: usize) -> Result<(), InverseError> {
        check_length("gauge_sd", n_gauges, self.gauge_sd.len())?;
        for &sd in &self.gauge_sd {
            check_positive("gauge_sd", sd)?;
        }
        check_not_negative("position_sd_m", self.position_sd_m)?;
        check_not_negative("force_sd_n", self.force_sd_n)?;
        check_not_negative("gain_sd", self.gain_sd)?;
        check_not_negative("mix_sd", self.mix_sd)?;
        check_positive("envelope_m", self.envelope_m)?;
        check_positive("the number of lengths_m", self.lengths_m.len() as f64)?;
        for &length_m in &self.lengths_m {
            check_positive("lengths_m", length_m)?;
        }
        check_positive("steep_m", self.steep_m)?;
        let n_steep = self.steep_lengths_m.len() as f64;
        check_positive("the number of steep_lengths_m", n_steep)?;
        for &length_m in &self.steep_lengths_m {
            check_positive("steep_lengths_m", length_m)?;
        }
        check_positive("n_evidence", self.n_evidence as f64)?;
        check_positive("max_presses", self.max_presses as f64)?;
        check_positive("reject_p", self.reject_p)?;
        check_positive("n_threads", self.n_threads as f64)
    }
}
