//! What the tracker is busy with, and what it remembers for that.

use nalgebra::Point3;

use crate::tracker::workspace::Workspace;

/// What the tracker is busy with. The table in [`crate::tracker`] says what leads from one to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum State {
    /// All contacts are held, or there are none.
    Holding(Holding),
    /// The residual was too large: what is new is being decided.
    Detecting(DetectionWindow),
    /// Contacts have come, and their places are searched again as their forces grow.
    Growing(Growing),
    /// A contact moves over the skin.
    Sliding(Sliding),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Holding {
    /// Frames for which alarms are still held off.
    pub(super) holdoff: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DetectionWindow {
    /// Frames since the alarm, its own included.
    pub(super) age: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Growing {
    /// Frames since the contacts came.
    pub(super) age: usize,
    /// Their forces together, averaged over a few frames and over more, N.
    pub(super) averages_n: [f64; 2],
    /// Whether they have explained what was gathered of late.
    pub(super) was_explained: bool,
    /// Frames in a row that alarmed although the contacts were refined.
    pub(super) n_stuck: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sliding {
    /// Frames since the contact began to slide.
    pub(super) age: usize,
    /// Blocks of frames in a row in which it hardly moved.
    pub(super) n_still: usize,
    /// Where it was a block ago, m.
    pub(super) anchor_m: Point3<f64>,
    /// Of the state before, for the one after.
    pub(super) was_explained: bool,
    /// Frames in a row that alarmed although the contact was refined.
    pub(super) n_stuck: usize,
}

impl State {
    /// All contacts are held, and the next alarm counts.
    pub(super) const HOLDING: Self = Self::Holding(Holding { holdoff: 0 });
}

impl Growing {
    /// The best hypothesis has contacts that came `age` frames ago.
    pub(super) fn new(work: &Workspace, age: usize, was_explained: bool) -> Self {
        let averages_n = [work.hypotheses.best().mobile_force(); 2];
        Self { age, averages_n, was_explained, n_stuck: 0 }
    }
}
