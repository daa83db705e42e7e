//! Two contacts that came at once: all pairs of sites, the best refined, spread over frames.

use crate::estimator::Model;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::locate::Fit;
use crate::tracker::scan::{PairJob, SiteScan};

/// Pairs that are refined again at the end, on all frames gathered since: the right one
/// need not be the first on the frame that was searched.
pub(super) const N_FINALISTS: usize = 4;

/// A search for pairs that goes on from frame to frame.
#[derive(Clone, Debug)]
pub(super) struct PairBirth {
    pub(super) job: PairJob,
    /// The contacts beside which the pair came.
    pub(super) base: Hypothesis,
    pub(super) trial: Hypothesis,
    /// The best pairs so far, best first.
    pub(super) finalists: Vec<Hypothesis>,
    pub(super) fits: [Fit; N_FINALISTS],
    pub(super) next: usize,
    /// The frame searched.
    pub(super) z: Vec<f64>,
    pub(super) scale: f64,
}

impl PairBirth {
    pub(super) fn new(model: &Model, empty: &Hypothesis) -> Self {
        Self {
            job: PairJob::new(model),
            base: empty.clone(),
            trial: empty.clone(),
            finalists: vec![empty.clone(); N_FINALISTS],
            fits: [Fit::NONE; N_FINALISTS],
            next: 0,
            z: vec![0.0; model.width],
            scale: 0.0,
        }
    }

    pub(super) fn is_active(&self) -> bool {
        self.job.is_active
    }

    /// Whether all pairs are refined and the best of them wait for a frame that has room for them.
    pub(super) fn is_ready(&self) -> bool {
        self.is_active() && self.job.n_left() == 0 && self.next == self.job.pairs.len()
    }

    pub(super) fn stop(&mut self) {
        self.job.is_active = false;
    }

    /// Takes what `scan` projected beside `base`.
    pub(super) fn prepare(&mut self, base: &Hypothesis, scan: &SiteScan) {
        if !self.is_active() {
            self.base.copy_from(base);
            self.job.prepare(scan);
        }
    }

    pub(super) fn start(&mut self, z: &[f64], scale: f64) {
        self.z.copy_from_slice(z);
        self.scale = scale;
        self.fits = [Fit::NONE; N_FINALISTS];
        self.next = 0;
        self.job.start();
    }

    /// Puts the trial among the finalists if it is good enough.
    pub(super) fn rank(&mut self, fit: Fit) {
        let place = self.fits.partition_point(|f| f.cost <= fit.cost);
        if place == N_FINALISTS || !fit.cost.is_finite() {
            return;
        }
        self.fits[place..].rotate_right(1);
        self.finalists[place..].rotate_right(1);
        self.fits[place] = fit;
        self.finalists[place].copy_from(&self.trial);
    }
}
