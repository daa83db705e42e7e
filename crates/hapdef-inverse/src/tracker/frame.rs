//! What the tracker says after each frame.

use hapdef_contact::{Phase, Verdict};

use crate::estimator::LocatedContact;

/// A contact's name, never given twice by one tracker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContactId(pub u64);

/// A contact that is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackedContact {
    /// Its name.
    pub id: ContactId,
    /// What it does.
    pub phase: Phase,
    /// Frames since it was found.
    pub age_frames: u64,
    /// Where it is and how it presses. Position covariances are those of the last update.
    pub contact: LocatedContact,
}

/// What ran in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TrackInfo {
    /// Trial steps of refinements, each times the contacts that moved.
    pub n_trials: usize,
    /// Scans of all sites.
    pub n_scans: usize,
    /// Rows of a pair scan.
    pub n_pair_rows: usize,
    /// Updates of the held contacts' places and map errors.
    pub n_updates: usize,
    /// Whether a new contact or a slide was being looked for.
    pub is_detecting: bool,
    /// Whether a contact that has come or slides was refined.
    pub is_refined: bool,
    /// Contacts born in this frame.
    pub n_born: usize,
    /// Contacts that began to slide in this frame.
    pub n_slides: usize,
    /// Contacts let go in this frame.
    pub n_released: usize,
    /// Whether a full search was adopted since the frame before.
    pub is_adopted: bool,
    /// Whether another hypothesis became the best one.
    pub is_switched: bool,
}

/// The contacts after a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedFrame {
    /// Frames before this one.
    pub index: u64,
    /// The contacts of the best hypothesis, the oldest first.
    pub contacts: Vec<TrackedContact>,
    /// Contacts let go in this frame.
    pub released: Vec<ContactId>,
    /// rᵀ S⁻¹ r of this frame, S the noise with what is left unknown of places and map errors.
    pub chi2: f64,
    /// Gauges read less forces solved.
    pub n_dof: usize,
    /// P(χ² of `n_dof` > `chi2`).
    pub p_value: f64,
    /// Readings less what the contacts explain `[n_gauges]`, in their unit; 0 for gauges not read.
    pub residual: Vec<f64>,
    /// What the frames so far decide.
    pub verdict: Verdict,
    /// Hypotheses beside the best that are still alive.
    pub n_runner_ups: usize,
    /// What ran.
    pub info: TrackInfo,
}
