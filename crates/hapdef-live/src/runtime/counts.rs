//! What the computing thread counts.

use std::sync::Arc;

use hapdef_daq::source::LinkState;

use crate::health::Health;
use crate::tare_fault::TareFault;

/// Counts since the start, and what was said last.
#[derive(Clone, Debug, Default)]
pub(super) struct Counts {
    pub(super) n_frames: u64,
    pub(super) n_lost: u64,
    pub(super) n_dropped: u64,
    pub(super) n_unusable: u64,
    pub(super) n_restarts: u64,
    pub(super) n_opened: u64,
    pub(super) n_conditioned: u64,
    pub(super) n_estimated: u64,
    pub(super) n_refused: u64,
    pub(super) n_deadline_missed: u64,
    pub(super) last_refusal: Option<Arc<str>>,
    pub(super) device_fault: Option<Arc<str>>,
    pub(super) tare_fault: Option<Arc<TareFault>>,
    pub(super) link: Option<LinkState>,
    pub(super) noise_ue: Vec<f64>,
    pub(super) n_noisier: usize,
}

impl Counts {
    /// Into a health record.
    pub(super) fn fill(&self, health: &mut Health) {
        health.n_frames = self.n_frames;
        health.n_lost = self.n_lost;
        health.n_dropped = self.n_dropped;
        health.n_unusable = self.n_unusable;
        health.n_restarts = self.n_restarts;
        health.n_reconnects = self.n_opened.saturating_sub(1);
        health.n_conditioned = self.n_conditioned;
        health.n_estimated = self.n_estimated;
        health.n_refused = self.n_refused;
        health.n_deadline_missed = self.n_deadline_missed;
        health.last_refusal.clone_from(&self.last_refusal);
        health.device_fault.clone_from(&self.device_fault);
        health.tare_fault.clone_from(&self.tare_fault);
        health.link.clone_from(&self.link);
        health.noise_ue.clone_from(&self.noise_ue);
        health.n_noisier = self.n_noisier;
    }
}
