//! What the filter makes of a frame.

use hapdef_contact::{GaugeHealth, TouchPhase};

/// A frame after conditioning.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditioned {
    /// Readings less baseline, temperature and creep `[n_gauges]`; 0 for gauges that don't count.
    pub readings: Vec<f64>,
    /// Standard deviation of what was taken off `[n_gauges]`, to be added to the noise.
    pub baseline_sd: Vec<f64>,
    /// Gauges that count `[n_gauges]`.
    pub live: Vec<bool>,
    /// Whether `live` differs from the frame before: time for [`crate::ContactEstimator::masked`].
    pub is_mask_new: bool,
    /// Why gauges don't count `[n_gauges]`.
    pub health: Vec<GaugeHealth>,
    /// What is going on.
    pub phase: TouchPhase,
    /// Where this frame was the last of a tare, how that ended.
    pub tare_end: Option<TareEnd>,
    /// How the zero drifts.
    pub drift: DriftState,
}

/// How a tare ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TareEnd {
    /// Its mean is the new zero; where it drifts within the limits, the line through it at its end.
    Taken,
    /// The readings moved: the zero is the one before, or the tare begins again where there was none.
    Refused(TareMove),
}

/// How the readings of a refused tare moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TareMove {
    /// The gauge that moved most beyond noise and drift.
    pub gauge: usize,
    /// How far, in the unit of the readings.
    pub by: f64,
    /// How it moved.
    pub how: MoveKind,
}

/// How readings move that have to stand still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveKind {
    /// A slope beyond what drift may have.
    Trend,
    /// Off the line through the tare for a part of it.
    Jump,
}

/// How the zero drifts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DriftState {
    /// Not so that it could be told from noise.
    #[default]
    Still,
    /// Steadily, and the zero follows it.
    Followed,
    /// A contact left readings that drift may have left, too, since the zero was followed: their line is still too short
    /// to tell.
    Unsure,
    /// The readings have moved on one line for seconds, and faster than is taken for drift.
    TooFast {
        /// The gauge that is farthest beyond its limit.
        gauge: usize,
        /// How fast, per s.
        rate: f64,
    },
}
