//! Two contacts that came at once: all pairs of sites, the best refined, spread over frames.

use crate::estimator::Model;
use crate::tracker::detection::mobile_force;
use crate::tracker::follow::{ContactTracker, HypothesisRef};
use crate::tracker::frame::ContactId;
use crate::tracker::hypothesis::{Hypothesis, Track};
use crate::tracker::locate::{Fit, Refiner, Target};
use crate::tracker::scan::{PairJob, SiteScan};

/// Pairs that are refined.
const N_PAIRS: usize = 64;

/// Trial steps of each.
const N_TRIALS: usize = 8;

/// Pairs that are refined again at the end.
const N_FINALISTS: usize = 4;

/// Trial steps of each of them.
const N_FINAL_TRIALS: usize = 10;

/// A search for pairs that goes on from frame to frame.
#[derive(Clone, Debug)]
pub(super) struct PairBirth {
    job: PairJob,
    /// The contacts beside which the pair came.
    base: Hypothesis,
    trial: Hypothesis,
    /// The best pairs so far, best first.
    finalists: Vec<Hypothesis>,
    fits: [Fit; N_FINALISTS],
    next: usize,
    /// The frame searched.
    z: Vec<f64>,
    scale: f64,
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
    fn rank(&mut self, fit: Fit) {
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
            if self.steps_left < 2 * N_TRIALS {
                return;
            }
            self.refine_pair();
        }
        if self.steps_left >= 2 * (N_TRIALS + N_FINALISTS * N_FINAL_TRIALS)
            || self.steps_left == self.params.steps_per_frame
        {
            self.finish_pairs();
            self.pair_birth.stop();
        }
    }

    fn refine_pair(&mut self) {
        let Self { pair_birth, model, .. } = self;
        let pair = pair_birth.job.pairs[pair_birth.next];
        pair_birth.next += 1;
        pair_birth.trial.copy_from(&pair_birth.base);
        for site in pair.sites {
            let point = model.sites.points()[site];
            let track = Track::new(ContactId(0), point, self.frame.index);
            pair_birth.trial.push(model, track);
        }
        let target = Target { z: &pair_birth.z, scale: pair_birth.scale };
        let mut refiner = Refiner {
            model,
            params: &self.settings,
            filter: &mut self.work.filter,
            metric: &mut self.work.metric,
            locator: &mut self.work.locator,
            n_trials: 0,
        };
        let fit = refiner.settle(&mut pair_birth.trial, &target, 2 * N_TRIALS);
        let n_trials = refiner.n_trials;
        pair_birth.rank(fit);
        self.frame.info.n_trials += n_trials;
        self.spend(n_trials);
    }

    /// The best pairs against what there is, on all frames so far.
    fn finish_pairs(&mut self) {
        let best = self.hypotheses.best();
        let Some(&first) = best.tracks().iter().find(|track| track.is_mobile()) else {
            return;
        };
        let second = best.tracks().iter().filter(|track| track.is_mobile()).nth(1);
        let second = second.map_or(ContactId(self.next_id), |track| track.id);
        self.hypotheses.begin();
        let Some(stay) = self.hypotheses.copy(0) else {
            return;
        };
        self.settle(HypothesisRef::Candidate(stay), N_TRIALS);
        for k in 0..N_FINALISTS {
            if !self.pair_birth.fits[k].cost.is_finite() {
                break;
            }
            let Some(c) = self.hypotheses.add(&self.pair_birth.finalists[k]) else {
                break;
            };
            let candidate = &mut self.hypotheses.candidates[c];
            let n = candidate.n;
            for (track, id) in candidate.tracks[n - 2..n].iter_mut().zip([first.id, second]) {
                (track.id, track.born) = (id, first.born);
            }
            self.settle(HypothesisRef::Candidate(c), N_FINAL_TRIALS);
        }
        let stay = self.hypotheses.fits[stay].cost;
        let n_mobile = self.hypotheses.best().n_mobile();
        let margin = if n_mobile == 1 { self.params.birth_margin } else { 0.0 };
        let better = |&c: &usize| c > 0 && self.hypotheses.fits[c].cost < stay - margin;
        if let Some(winner) = self.hypotheses.winner().filter(better) {
            let delta = self.params.hypothesis_delta;
            self.hypotheses.take(&self.model, winner, delta);
            self.next_id += u64::from(second.0 == self.next_id);
            self.frame.info.n_born += usize::from(n_mobile == 1);
            self.trace = [mobile_force(self.hypotheses.best()); 2];
            self.n_stuck = 0;
            self.refresh();
        }
    }
}
