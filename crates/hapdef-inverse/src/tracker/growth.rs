//! A contact has come: its place is searched again and again as its force grows.

use crate::chi_square::upper_tail;
use crate::estimator::MAX_CONTACTS;
use crate::tracker::detection::{N_BASES, SCAN_STEPS, mobile_force};
use crate::tracker::follow::{ContactTracker, HypothesisRef, Mode};
use crate::tracker::frame::{ContactId, Phase};
use crate::tracker::hypothesis::Track;
use crate::tracker::locate::MAX_CROSSINGS;
use crate::walk::AtWall;

/// Least weight of a frame, N.
const LEAST_WEIGHT: f64 = 0.05;

/// Frames between refinements.
const STRIDE: usize = 4;

/// The last age at which the whole skin is scanned again, and the first.
pub(super) const SCANS: std::ops::RangeInclusive<usize> = 4..=64;

/// The last age at which a slide may be all that happened.
const SLIDE_AGE: usize = 32;

/// Places around a contact are tried where what it explains is less probable than this, …
const HOP_P: f64 = 0.1;

/// … from this age on, …
const LEAST_HOP_AGE: usize = 8;

/// … in so many directions, this far away at one age and the next, in spacings of the sites.
const N_DIRECTIONS: u32 = 6;
const HOP_SPACINGS: [f64; 2] = [0.4, 0.8];

/// Trial steps of a refinement.
const N_TRIALS: usize = 6;

/// The earliest age at which a contact is held.
const LEAST_AGE: usize = 32;

/// A force is steady if its averages differ by less than this share …
const STEADY_SHARE: f64 = 0.02;

/// … and this, N.
const STEADY_N: f64 = 0.05;

/// Where the frames are explained from this age on, a misfit is another contact that comes, not one
/// that came at the same time.
const GOOD_AGE: usize = 16;

/// What is not explained stays open for so many times the usual frames.
const OPEN_FACTOR: usize = 4;

/// Alarms in a row after which refining is not enough.
const N_STUCK: usize = 3;

impl ContactTracker {
    pub(super) fn grow(&mut self, age: usize, is_alarm: bool) {
        let force_n = mobile_force(self.hypotheses.best());
        self.gathered.add(&self.z, force_n.max(LEAST_WEIGHT));
        self.trace[0] += (force_n - self.trace[0]) / 4.0;
        self.trace[1] += (force_n - self.trace[1]) / 16.0;
        self.mode = Mode::Growing { age };
        self.frame.info.is_refined = true;
        let is_due = age.is_power_of_two() && SCANS.contains(&age) || age.is_multiple_of(64);
        if is_due {
            self.compare(age);
            if !matches!(self.mode, Mode::Growing { .. }) {
                return;
            }
        } else if (is_alarm || age.is_multiple_of(STRIDE)) && !self.pair_birth.is_ready() {
            self.settle(HypothesisRef::Best, N_TRIALS);
            self.refresh();
        }
        let is_alarm = is_alarm && self.solve();
        self.n_stuck = if is_alarm { self.n_stuck + 1 } else { 0 };
        if self.pair_birth.is_active() {
            self.search_pairs();
        } else if is_due {
            self.consider_pairs(age);
        }
        self.consider_holding(age);
    }

    /// Whether χ² is too large for a frame in which `n` unknowns were fitted.
    pub(super) fn is_odd(&self, chi2: f64, n: usize) -> bool {
        upper_tail(chi2, self.n_live.saturating_sub(n)) < self.params.alarm_p
    }

    /// Lets a contact that came and contacts that slide compete again on the frames gathered since
    /// `n_frames`: the hypotheses there are, the best places of a new scan, slides.
    pub(super) fn compare(&mut self, n_frames: usize) {
        let best = self.hypotheses.best();
        let mobile = best.tracks().iter().find(|track| track.is_mobile());
        let n_mobile = best.n_mobile();
        let Some(&mobile) = mobile else {
            return;
        };
        self.hypotheses.begin();
        for j in 0..self.hypotheses.n_alive() {
            if let Some(c) = self.hypotheses.copy(j) {
                self.settle(HypothesisRef::Candidate(c), N_TRIALS);
            }
        }
        if n_mobile == 1 {
            self.propose_again(&mobile, n_frames);
            self.propose_hops(&mobile, n_frames);
        }
        if let Some(winner) = self.hypotheses.winner() {
            let delta = self.params.hypothesis_delta;
            self.hypotheses.take(&self.model, winner, delta);
        }
        self.change_mode(&mobile);
        self.refresh();
    }

    /// Candidates from the contacts there were before `mobile` moved.
    fn propose_again(&mut self, mobile: &Track, n_frames: usize) {
        let newcomer = Track::new(ContactId(self.next_id), mobile.point, self.frame.index);
        if mobile.phase == Phase::Born {
            for j in 0..self.hypotheses.n_alive().min(N_BASES) {
                self.propose_elsewhere(j, mobile);
            }
        }
        if let Some(base) = self.hypotheses.add(&self.before) {
            let now = self.hypotheses.candidates[0].tracks;
            let forces_now = &now[..self.hypotheses.candidates[0].n];
            for track in &mut self.hypotheses.candidates[base].tracks {
                let same = forces_now.iter().find(|other| other.id == track.id);
                track.force_n = same.map_or(track.force_n, |other| other.force_n);
            }
            if mobile.phase != Phase::Born && self.before.n < self.most_contacts() {
                self.propose_births(base, newcomer);
            }
            if n_frames <= SLIDE_AGE {
                self.propose_slides(base, n_frames);
            }
        }
    }

    /// Candidates with the contact `mobile` of candidate `from` in other places.
    fn propose_elsewhere(&mut self, from: usize, mobile: &Track) {
        let tracks = self.hypotheses.candidates[from].tracks();
        let Some(i) = tracks.iter().position(|track| track.id == mobile.id) else {
            return;
        };
        if let Some(base) = self.hypotheses.copy_candidate(from) {
            self.hypotheses.candidates[base].remove(i);
            self.propose_births(base, *mobile);
        }
    }

    /// Candidates that start around the place of `mobile` where it does not explain the frames well:
    /// the map's slope jumps at edges of faces, and steps downhill may end at a kink.
    fn propose_hops(&mut self, mobile: &Track, n_frames: usize) {
        let from = self.hypotheses.candidates[0].tracks().iter();
        let Some(i) = from.clone().position(|track| track.id == mobile.id) else {
            return;
        };
        let n_dof = self.n_live.saturating_sub(self.hypotheses.candidates[0].n + 2);
        let p = upper_tail(self.hypotheses.fits[0].chi2, n_dof);
        if n_frames < LEAST_HOP_AGE || p > HOP_P {
            return;
        }
        let spacings = HOP_SPACINGS[n_frames.trailing_zeros() as usize % 2];
        let distance_m = spacings * self.model.sites.spacing_m();
        let point = self.hypotheses.candidates[0].tracks[i].point;
        let [t1, t2] = self.model.skin().tangents(&point);
        for turn in 0..N_DIRECTIONS {
            let angle = f64::from(turn) / f64::from(N_DIRECTIONS) * std::f64::consts::TAU;
            let step = (t1 * angle.cos() + t2 * angle.sin()) * distance_m;
            let skin = self.model.skin();
            let walk = skin.walk_at_most(&point, &step, AtWall::Slide, MAX_CROSSINGS);
            let Some(c) = self.hypotheses.copy_candidate(0) else {
                return;
            };
            self.hypotheses.candidates[c].tracks[i].point = walk.point;
            self.settle(HypothesisRef::Candidate(c), N_TRIALS);
        }
    }

    /// Follows what `mobile`, the contact that moved before, has turned out to be.
    fn change_mode(&mut self, mobile: &Track) {
        let best = self.hypotheses.best();
        let Some(&now) = best.tracks().iter().find(|track| track.is_mobile()) else {
            return;
        };
        let force_n = mobile_force(best);
        if mobile.phase == Phase::Sliding && now.phase == Phase::Born {
            self.next_id += u64::from(now.id.0 == self.next_id);
            self.frame.info.n_born += 1;
            self.trace = [force_n; 2];
            let age = *SCANS.start();
            self.mode = Mode::Growing { age };
        } else if mobile.phase == Phase::Born && now.phase == Phase::Sliding {
            self.frame.released.push(mobile.id);
            self.frame.info.n_released += 1;
            self.pair_birth.stop();
            self.start_slide();
        }
    }

    /// Looks for two contacts at once where those that came do not explain the frames gathered, and
    /// never did.
    fn consider_pairs(&mut self, age: usize) {
        let fit = self.settle(HypothesisRef::Best, 0);
        let best = self.hypotheses.best();
        let n_mobile = best.n_mobile();
        let n_dof = self.n_live.saturating_sub(best.n + 2 * n_mobile);
        let is_good = n_dof == 0 || upper_tail(fit.chi2, n_dof) >= self.params.pair_p;
        let force_n = mobile_force(best);
        if is_good {
            self.was_good = age >= GOOD_AGE;
            return;
        }
        let is_room = self.before.n + 2 <= self.most_contacts().min(MAX_CONTACTS);
        if self.was_good || n_mobile > 2 || !is_room || self.spend(SCAN_STEPS) < SCAN_STEPS {
            return;
        }
        self.hypotheses.begin();
        if let Some(base) = self.hypotheses.add(&self.before) {
            self.scan_beside(base, force_n);
            self.pair_birth.prepare(&self.hypotheses.candidates[base], &self.work.scan);
            let scale = self.gathered.frame(&mut self.work.z);
            self.pair_birth.start(&self.work.z, scale);
        }
    }

    fn consider_holding(&mut self, age: usize) {
        if !matches!(self.mode, Mode::Growing { .. }) {
            return;
        }
        let [fast, slow] = self.trace;
        let is_steady = (fast - slow).abs() < STEADY_SHARE * slow + STEADY_N;
        let is_other = self.n_stuck >= N_STUCK && self.was_good;
        let is_time = (is_steady && age >= LEAST_AGE) || age >= self.params.settle_frames;
        let is_explained = self.was_good || age >= OPEN_FACTOR * self.params.settle_frames;
        if is_other || (is_time && is_explained && !self.pair_birth.is_active()) {
            self.pair_birth.stop();
            self.hold_mobile();
        }
    }

    /// Holds all contacts that move, and learns from the frames gathered.
    pub(super) fn hold_mobile(&mut self) {
        for hypothesis in self.hypotheses.alive_mut() {
            hypothesis.set_cost(hypothesis.handicap);
            hypothesis.handicap = 0.0;
        }
        self.learn();
        self.gathered.clear();
        self.n_stuck = 0;
        self.mode = Mode::Quiet { holdoff: 0 };
    }
}
