//! A contact that moves over the skin, followed until it stays.

use crate::tracker::detection::{SCAN_STEPS, mobile_force};
use crate::tracker::follow::{ContactTracker, HypothesisRef, Mode};
use crate::tracker::frame::Phase;
use crate::tracker::growth::SCANS;
use crate::tracker::hypothesis::Track;

/// What is left of the frames gathered after each frame.
const KEEP: f64 = 0.8;

/// Trial steps in each frame.
const N_TRIALS: usize = 4;

/// Frames between hops, sites that are tried, and how far away, in spacings of the sites.
const HOP_FRAMES: usize = 8;
const N_HOPS: usize = 4;
const HOP_SPACINGS: f64 = 3.0;

/// Frames after which it is asked whether the contact moved.
const BLOCK: usize = 32;

/// The age of a contact that has come to rest.
const REST_AGE: usize = 16;

/// It stays if it moved less than this, m, …
const STILL_M: f64 = 4e-4;

/// … or less than so many standard deviations of its place.
const STILL_SDS: f64 = 2.0;

/// Alarms in a row after which something else must have happened.
const N_STUCK: usize = 24;

impl ContactTracker {
    /// The best hypothesis has a sliding contact.
    pub(super) fn start_slide(&mut self) {
        self.hypotheses.keep_best_only();
        self.frame.info.n_slides += 1;
        self.mode = Mode::Sliding { age: 0, still: 0 };
        if let Some((place, _)) = self.sliding() {
            self.anchor_m = place;
        }
    }

    pub(super) fn slide(&mut self, age: usize, still: usize, is_alarm: bool) {
        self.gathered.fade(KEEP);
        self.gathered.add(&self.z, 1.0);
        self.frame.info.is_refined = true;
        self.mode = Mode::Sliding { age, still };
        let further_m = self.params.slide_m_per_s * self.params.frame_period_s;
        for track in &mut self.hypotheses.best_mut().tracks {
            if let Some((_, sd_m)) = &mut track.slide {
                *sd_m += further_m;
            }
        }
        if age.is_power_of_two() && SCANS.contains(&age) {
            self.compare(age);
            if !matches!(self.mode, Mode::Sliding { .. }) {
                return;
            }
        } else if age.is_multiple_of(HOP_FRAMES) {
            self.hop();
        } else {
            self.settle(HypothesisRef::Best, N_TRIALS);
            self.refresh();
        }
        let is_alarm = is_alarm && self.solve();
        self.n_stuck = if is_alarm { self.n_stuck + 1 } else { 0 };
        if self.n_stuck >= N_STUCK {
            self.hold_mobile();
            return;
        }
        if !age.is_multiple_of(BLOCK) {
            return;
        }
        let Some((place, sd_m)) = self.sliding() else {
            return;
        };
        let moved_m = (place - self.anchor_m).norm();
        self.anchor_m = place;
        let is_still = moved_m < STILL_M.max(STILL_SDS * sd_m);
        self.mode = Mode::Sliding { age, still: if is_still { still + 1 } else { 0 } };
        if is_still && still >= 1 {
            self.come_to_rest();
        }
    }

    /// Lets the sliding contact go on from the best sites around it: the map's slope jumps at edges of
    /// faces, and steps downhill may end at a kink.
    fn hop(&mut self) {
        let best = self.hypotheses.best();
        let moving = (0..best.n).find(|&i| best.tracks[i].phase == Phase::Sliding);
        let Some(i) = moving.filter(|_| self.spend(SCAN_STEPS) == SCAN_STEPS) else {
            return;
        };
        let track = self.hypotheses.best().tracks[i];
        self.hypotheses.begin();
        let (Some(stay), Some(base)) = (self.hypotheses.copy(0), self.hypotheses.copy(0)) else {
            return;
        };
        self.settle(HypothesisRef::Candidate(stay), N_TRIALS);
        self.hypotheses.candidates[base].remove(i);
        self.scan_beside(base, track.force_n);
        let x = self.model.skin().position(&track.point);
        let reach_m = HOP_SPACINGS * self.model.sites.spacing_m();
        let far = |y: &nalgebra::Point3<f64>| (y - x).norm() > reach_m;
        for (gain, y) in self.work.scan.gains.iter_mut().zip(self.model.sites.positions()) {
            *gain = if far(y) { 0.0 } else { *gain };
        }
        self.model.largest(&self.work.scan.gains, N_HOPS, &mut self.work.scan.peaks);
        for k in 0..self.work.scan.peaks.len() {
            let Some(c) = self.hypotheses.copy_candidate(base) else {
                break;
            };
            let point = self.model.sites.points()[self.work.scan.peaks[k].site];
            self.hypotheses.candidates[c].push(&self.model, Track { point, ..track });
            self.settle(HypothesisRef::Candidate(c), N_TRIALS);
        }
        if let Some(winner) = self.hypotheses.winner() {
            self.hypotheses.take(&self.model, winner, 0.0);
        }
        self.refresh();
    }

    /// From now on the contact is searched like one that has come.
    fn come_to_rest(&mut self) {
        let best = self.hypotheses.best_mut();
        for i in 0..best.n {
            if best.tracks[i].phase == Phase::Sliding {
                best.tracks[i].phase = Phase::Born;
                best.tracks[i].slide = None;
                self.before.copy_from(best);
                self.before.remove(i);
            }
        }
        self.trace = [mobile_force(self.hypotheses.best()); 2];
        self.gathered.clear();
        self.was_good = true;
        self.mode = Mode::Growing { age: REST_AGE };
    }

    /// Where the sliding contact is, and its standard deviation, m.
    fn sliding(&self) -> Option<(nalgebra::Point3<f64>, f64)> {
        let best = self.hypotheses.best();
        let track = best.tracks().iter().find(|s| s.phase == Phase::Sliding)?;
        let c = &track.covariance;
        let sd_m = (c[(0, 0)] + c[(1, 1)]).sqrt();
        Some((self.model.skin().position(&track.point), sd_m))
    }
}
