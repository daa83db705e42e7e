//! Full searches: when one is wanted, and what becomes of its outcome.

use crate::tracker::detection::mobile_force;
use crate::tracker::follow::{ContactTracker, HypothesisRef, Mode};
use crate::tracker::frame::ContactId;
use crate::tracker::hypothesis::Track;
use crate::tracker::search::{SearchOutcome, SearchRequest};

/// A search that found nothing better is asked for again after so many times the frames that
/// made it wanted.
const PATIENCE: usize = 8;

/// Trial steps with which an outcome is brought to the tracker's own covariances.
const N_TRIALS: usize = 24;

/// A contact found within this of one that was there has its name, m.
const SAME_M: f64 = 0.015;

impl ContactTracker {
    /// The frames that a full search should look at, once for each time that one is wanted: when no
    /// hypothesis has explained [`crate::TrackerParams::search_frames`] frames.
    pub fn wanted_search(&mut self) -> Option<SearchRequest<'_>> {
        let patience = self.params.search_frames;
        let is_new = self.recent.asked.is_none_or(|n| n > PATIENCE * patience);
        if self.recent.n_bad < patience || !is_new || self.recent.gathered.n_frames == 0 {
            return None;
        }
        self.recent.asked = Some(0);
        Some(SearchRequest {
            frame: self.frame.index,
            readings: &self.recent.mean,
            live: &self.recent.live,
        })
    }

    /// Takes the contacts that a full search found, if they explain the latest frames better than
    /// the best hypothesis; whether it did. Contacts near those that were there keep their names.
    pub fn adopt(&mut self, outcome: &SearchOutcome) -> bool {
        let found = &outcome.estimate.contacts;
        if found.len() > self.most_contacts() || self.recent.gathered.n_frames == 0 {
            return false;
        }
        self.steps_left = self.params.steps_per_frame.max(2 * N_TRIALS);
        self.gathered.copy_from(&self.recent.gathered);
        self.hypotheses.begin();
        let (Some(stay), Some(new)) = (self.hypotheses.copy(0), self.hypotheses.copy(0)) else {
            return false;
        };
        self.settle(HypothesisRef::Candidate(stay), 0);
        self.hypotheses.candidates[new].n = 0;
        self.before.copy_from(&self.hypotheses.candidates[new]);
        let first_id = self.next_id;
        for contact in found {
            let id = self.name_at(new, contact.position_m);
            let mut track = Track::new(id, contact.point, self.frame.index);
            track.force_n = contact.force_n;
            self.hypotheses.candidates[new].push(&self.model, track);
        }
        self.settle(HypothesisRef::Candidate(new), N_TRIALS);
        let fits = &self.hypotheses.fits;
        let is_better = fits[new].cost < fits[stay].cost - self.params.birth_margin;
        self.pair_birth.stop();
        if is_better {
            self.hypotheses.fits[stay].cost = f64::INFINITY;
            self.hypotheses.take(&self.model, new, 0.0);
            self.trace = [mobile_force(self.hypotheses.best()); 2];
            let age = self.gathered.n_frames;
            self.n_stuck = 0;
            self.was_good = true;
            self.mode = Mode::Growing { age };
            self.recent.forgive();
            self.is_adopted = true;
        } else {
            self.next_id = first_id;
            self.gathered.clear();
            self.hold_or_start_over();
        }
        self.refresh();
        is_better
    }

    fn hold_or_start_over(&mut self) {
        let is_moving = self.hypotheses.best().n_mobile() > 0;
        if !is_moving {
            self.mode = Mode::Quiet { holdoff: 0 };
        }
    }

    /// The name of the contact that is nearest to `x` and has not given its name to candidate `new`
    /// yet, or a new one.
    fn name_at(&mut self, new: usize, x: nalgebra::Point3<f64>) -> ContactId {
        let skin = self.model.skin();
        let taken = self.hypotheses.candidates[new].tracks();
        let nearest = self
            .hypotheses
            .best()
            .tracks()
            .iter()
            .filter(|track| taken.iter().all(|other| other.id != track.id))
            .map(|track| (track.id, (skin.position(&track.point) - x).norm()))
            .filter(|(_, gap)| *gap <= SAME_M)
            .min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map_or_else(
            || {
                self.next_id += 1;
                ContactId(self.next_id - 1)
            },
            |(id, _)| id,
        )
    }
}
