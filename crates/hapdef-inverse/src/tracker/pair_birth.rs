//! Two contacts that came at once: all pairs of sites, the best refined, spread over frames.

use crate::estimator::Model;
use crate::tracker::belief::{Belief, Slot};
use crate::tracker::follow::{ContactTracker, Mode, Whose};
use crate::tracker::frame::ContactId;
use crate::tracker::inquiry::mobile_force;
use crate::tracker::locate::{Fit, Target, Workshop};
use crate::tracker::scan::{PairJob, SiteScan};

/// Pairs that are refined.
const N_PAIRS: usize = 32;

/// Trial steps of each.
const N_TRIALS: usize = 8;

/// Trial steps of the best at the end.
const N_FINAL_TRIALS: usize = 24;

/// A search for pairs that goes on from frame to frame.
#[derive(Clone, Debug)]
pub(super) struct PairBirth {
    job: PairJob,
    /// The contacts beside which the pair came.
    base: Belief,
    trial: Belief,
    best: Belief,
    best_fit: Fit,
    next: usize,
    /// The frame searched.
    z: Vec<f64>,
    scale: f64,
}

impl PairBirth {
    pub(super) fn new(model: &Model, empty: &Belief) -> Self {
        Self {
            job: PairJob::new(model),
            base: empty.clone(),
            trial: empty.clone(),
            best: empty.clone(),
            best_fit: Fit::NONE,
            next: 0,
            z: vec![0.0; model.width],
            scale: 0.0,
        }
    }

    pub(super) fn is_active(&self) -> bool {
        self.job.is_active
    }

    pub(super) fn stop(&mut self) {
        self.job.is_active = false;
    }

    /// Takes what `scan` projected beside `base`.
    pub(super) fn prepare(&mut self, base: &Belief, scan: &SiteScan) {
        if !self.is_active() {
            self.base.copy_from(base);
            self.job.prepare(scan);
        }
    }

    pub(super) fn start(&mut self, z: &[f64], scale: f64) {
        self.z.copy_from_slice(z);
        self.scale = scale;
        self.best_fit = Fit::NONE;
        self.next = 0;
        self.job.start();
    }
}

impl ContactTracker {
    /// Goes on with the search for pairs as far as the frame's budget lets it.
    pub(super) fn search_pairs(&mut self) {
        let n_left = self.pair_birth.job.n_left();
        if n_left > 0 {
            let n_rows = self.spend(n_left);
            self.frame.info.n_pair_rows += n_rows;
            if self.pair_birth.job.go_on(n_rows) {
                self.pair_birth.job.rank(&self.model, N_PAIRS);
            }
            return;
        }
        while self.pair_birth.next < self.pair_birth.job.pairs.len() {
            if self.steps_left < N_TRIALS {
                return;
            }
            self.refine_pair();
        }
        if self.steps_left >= N_FINAL_TRIALS {
            self.finish_pairs();
            self.pair_birth.stop();
        }
    }

    fn refine_pair(&mut self) {
        let Self {
            pair_birth, model, ..
        } = self;
        let pair = pair_birth.job.pairs[pair_birth.next];
        pair_birth.next += 1;
        pair_birth.trial.copy_from(&pair_birth.base);
        for site in pair.sites {
            let point = model.sites.points()[site];
            let slot = Slot::new(ContactId(0), point, self.frame.index);
            pair_birth.trial.push(model, slot);
        }
        let target = Target {
            z: &pair_birth.z,
            scale: pair_birth.scale,
        };
        let mut workshop = Workshop {
            model,
            params: &self.settings,
            filter: &mut self.work.filter,
            metric: &mut self.work.metric,
            locator: &mut self.work.locator,
            n_trials: 0,
        };
        let fit = workshop.settle(&mut pair_birth.trial, &target, N_TRIALS);
        let n_trials = workshop.n_trials;
        if fit.evidence < pair_birth.best_fit.evidence {
            pair_birth.best_fit = fit;
            pair_birth.best.copy_from(&pair_birth.trial);
        }
        self.frame.info.n_trials += n_trials;
        self.spend(n_trials);
    }

    /// The best pair against the single contact, on all frames so far.
    fn finish_pairs(&mut self) {
        let best = self.hypotheses.best();
        let newest = best.slots().iter().find(|slot| slot.is_mobile());
        let (Some(&newest), true) = (newest, self.pair_birth.best_fit.evidence.is_finite()) else {
            return;
        };
        self.hypotheses.begin();
        let (Some(single), Some(pair)) = (
            self.hypotheses.copy(0),
            self.hypotheses.add(&self.pair_birth.best),
        ) else {
            return;
        };
        let candidate = &mut self.hypotheses.candidates[pair];
        let (first, second) = (candidate.n - 2, candidate.n - 1);
        candidate.slots[first].id = newest.id;
        candidate.slots[first].born = newest.born;
        candidate.slots[second].id = ContactId(self.next_id);
        self.settle(Whose::Candidate(pair), N_FINAL_TRIALS);
        self.settle(Whose::Candidate(single), N_TRIALS);
        let fits = &self.hypotheses.fits;
        if fits[pair].evidence < fits[single].evidence - self.params.birth_margin {
            let delta = self.params.hypothesis_delta;
            self.hypotheses.take(&self.model, pair, delta);
            self.next_id += 1;
            self.frame.info.n_born += 1;
            self.trace = [mobile_force(self.hypotheses.best()); 2];
            self.n_stuck = 0;
            debug_assert!(matches!(self.mode, Mode::Growing { .. }));
            self.refresh();
        }
    }
}
