//! Hypotheses side by side, and the candidates that may replace them.

use crate::estimator::{MAX_CONTACTS, Model};
use crate::tracker::frame::ContactId;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::locate::Fit;

/// Candidates at most: alternatives, peaks, slides. Room for all that one decision proposes with the usual
/// hypotheses; what finds none is left out.
const N_CANDIDATES: usize = 28;

/// The best hypothesis has to be beaten by this in −2 ln evidence, odds of e to 1: two that are alike
/// would else take turns, and what is reported would jump between them.
const SWITCH_MARGIN: f64 = 2.0;

/// A hypothesis that is kept or a candidate.
#[derive(Clone, Copy, Debug)]
pub(super) enum HypothesisRef {
    Best,
    Candidate(usize),
}

/// Hypotheses, the best first, and candidates with how they explain the frame gathered.
#[derive(Clone, Debug)]
pub(super) struct Hypotheses {
    all: Vec<Hypothesis>,
    n: usize,
    pub(super) candidates: Vec<Hypothesis>,
    pub(super) fits: [Fit; N_CANDIDATES],
    n_candidates: usize,
}

impl Hypotheses {
    pub(super) fn new(empty: &Hypothesis, n: usize) -> Self {
        Self {
            all: vec![empty.clone(); n],
            n: 1,
            candidates: vec![empty.clone(); N_CANDIDATES],
            fits: [Fit::NONE; N_CANDIDATES],
            n_candidates: 0,
        }
    }

    pub(super) fn clear(&mut self) {
        self.n = 1;
        self.all[0].n = 0;
        self.n_candidates = 0;
    }

    pub(super) fn n_alive(&self) -> usize {
        self.n
    }

    pub(super) fn best(&self) -> &Hypothesis {
        &self.all[0]
    }

    pub(super) fn best_mut(&mut self) -> &mut Hypothesis {
        &mut self.all[0]
    }

    pub(super) fn get(&self, which: HypothesisRef) -> &Hypothesis {
        match which {
            HypothesisRef::Best => self.best(),
            HypothesisRef::Candidate(c) => &self.candidates[c],
        }
    }

    pub(super) fn get_mut(&mut self, which: HypothesisRef) -> &mut Hypothesis {
        match which {
            HypothesisRef::Best => self.best_mut(),
            HypothesisRef::Candidate(c) => &mut self.candidates[c],
        }
    }

    pub(super) fn alive_mut(&mut self) -> &mut [Hypothesis] {
        &mut self.all[..self.n]
    }

    /// Those beside the best, in no order.
    pub(super) fn others(&self) -> &[Hypothesis] {
        &self.all[1..self.n]
    }

    /// How much worse the second hypothesis is in −2 ln evidence.
    pub(super) fn lead(&self) -> f64 {
        let others = self.all[1..self.n].iter();
        others.map(|other| other.cost() - self.all[0].cost()).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn drop_contact(&mut self, id: ContactId) {
        for hypothesis in &mut self.all[1..self.n] {
            if let Some(i) = hypothesis.tracks().iter().position(|track| track.id == id) {
                hypothesis.remove(i);
            }
        }
    }

    pub(super) fn keep_best_only(&mut self) {
        self.n = 1;
    }

    /// Orders hypotheses by cost and drops those worse than the best by `delta`, or the same as
    /// a better one; whether another is best now.
    pub(super) fn prune(&mut self, model: &Model, delta: f64) -> bool {
        let mut first = 0;
        for j in 1..self.n {
            let is_ahead = self.all[j].cost() + SWITCH_MARGIN < self.all[0].cost();
            if is_ahead && self.all[j].cost() < self.all[first].cost() {
                first = j;
            }
        }
        self.all.swap(0, first);
        let (best, others) = self.all.split_at_mut(1);
        let mut n = 1;
        for j in 0..self.n - 1 {
            let is_near = others[j].cost() <= best[0].cost() + delta;
            let is_new = !is_same(model, &others[j], &best[0])
                && !others[..n - 1].iter().any(|o| is_same(model, o, &others[j]));
            if is_near && is_new {
                others.swap(n - 1, j);
                n += 1;
            }
        }
        self.n = n;
        first != 0
    }

    pub(super) fn begin(&mut self) {
        self.n_candidates = 0;
    }

    /// A copy of hypothesis `j` as a candidate, if there is room.
    pub(super) fn copy(&mut self, j: usize) -> Option<usize> {
        let c = self.n_candidates;
        if c == N_CANDIDATES || j >= self.n {
            return None;
        }
        self.candidates[c].copy_from(&self.all[j]);
        self.n_candidates += 1;
        self.fits[c] = Fit::NONE;
        Some(c)
    }

    /// A copy of candidate `from` as another candidate, if there is room.
    pub(super) fn copy_candidate(&mut self, from: usize) -> Option<usize> {
        let c = self.n_candidates;
        if c == N_CANDIDATES {
            return None;
        }
        let (before, after) = self.candidates.split_at_mut(c);
        after[0].copy_from(&before[from]);
        self.n_candidates += 1;
        self.fits[c] = Fit::NONE;
        Some(c)
    }

    /// A copy of `hypothesis` as a candidate, if there is room.
    pub(super) fn add(&mut self, hypothesis: &Hypothesis) -> Option<usize> {
        let c = self.n_candidates;
        if c == N_CANDIDATES {
            return None;
        }
        self.candidates[c].copy_from(hypothesis);
        self.n_candidates += 1;
        self.fits[c] = Fit::NONE;
        Some(c)
    }

    /// The candidate of least cost.
    pub(super) fn winner(&self) -> Option<usize> {
        (0..self.n_candidates)
            .filter(|&c| self.fits[c].cost.is_finite())
            .min_by(|&a, &b| self.fits[a].cost.total_cmp(&self.fits[b].cost))
    }

    /// Makes candidate `winner` the best hypothesis, and those like it in kind and within `delta`
    /// its alternatives. Costs become the candidates'.
    pub(super) fn take(&mut self, model: &Model, winner: usize, delta: f64) {
        let least = self.fits[winner].cost;
        self.all[0].copy_from(&self.candidates[winner]);
        self.all[0].set_cost(least);
        self.n = 1;
        let n_contacts = self.all[0].n;
        let n_mobile = self.all[0].n_mobile();
        for _ in 1..self.all.len() {
            let (taken, free) = self.all.split_at_mut(self.n);
            let is_wanted = |c: usize| {
                let candidate = &self.candidates[c];
                self.fits[c].cost <= least + delta
                    && candidate.n == n_contacts
                    && candidate.n_mobile() == n_mobile
                    && !taken.iter().any(|other| is_same(model, other, candidate))
            };
            let next = (0..self.n_candidates)
                .filter(|&c| is_wanted(c))
                .min_by(|&a, &b| self.fits[a].cost.total_cmp(&self.fits[b].cost));
            let Some(next) = next else {
                break;
            };
            free[0].copy_from(&self.candidates[next]);
            free[0].set_cost(self.fits[next].cost);
            self.n += 1;
        }
    }
}

/// Whether contacts of the same name are at the same places.
fn is_same(model: &Model, a: &Hypothesis, b: &Hypothesis) -> bool {
    let near = 0.5 * model.sites.spacing_m();
    debug_assert!(a.n <= MAX_CONTACTS);
    a.n == b.n
        && a.tracks().iter().zip(b.tracks()).all(|(a, b)| {
            let gap = model.skin().position(&a.point) - model.skin().position(&b.point);
            gap.norm() <= near
        })
}
