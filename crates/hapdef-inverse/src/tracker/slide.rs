//! A contact that moves over the skin, followed until it stays.

use crate::tracker::follow::{ContactTracker, Mode, Whose};
use crate::tracker::frame::Phase;
use crate::tracker::growth::SCANS;
use crate::tracker::inquiry::mobile_force;

/// What is left of the frames gathered after each frame.
const KEEP: f64 = 0.8;

/// Trial steps in each frame.
const N_TRIALS: usize = 4;

/// Frames after which it is asked whether the contact moved.
const BLOCK: usize = 16;

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
        for slot in &mut self.hypotheses.best_mut().slots {
            if let Some((_, sd_m)) = &mut slot.slide {
                *sd_m += further_m;
            }
        }
        if age.is_power_of_two() && SCANS.contains(&age) {
            self.compare(age);
            if !matches!(self.mode, Mode::Sliding { .. }) {
                return;
            }
        } else {
            self.settle(Whose::Best, N_TRIALS);
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
        self.mode = Mode::Sliding {
            age,
            still: if is_still { still + 1 } else { 0 },
        };
        if is_still && still >= 1 {
            self.come_to_rest();
        }
    }

    /// From now on the contact is searched like one that has come.
    fn come_to_rest(&mut self) {
        let best = self.hypotheses.best_mut();
        for i in 0..best.n {
            if best.slots[i].phase == Phase::Sliding {
                best.slots[i].phase = Phase::Born;
                best.slots[i].slide = None;
                self.before.copy_from(best);
                self.before.remove(i);
            }
        }
        self.trace = [mobile_force(self.hypotheses.best()); 2];
        self.gathered.clear();
        self.was_good = true;
        self.mode = Mode::Growing { age: BLOCK };
    }

    /// Where the sliding contact is, and its standard deviation, m.
    fn sliding(&self) -> Option<(nalgebra::Point3<f64>, f64)> {
        let best = self.hypotheses.best();
        let slot = best.slots().iter().find(|s| s.phase == Phase::Sliding)?;
        let c = &slot.covariance;
        let sd_m = (c[(0, 0)] + c[(1, 1)]).sqrt();
        Some((self.model.skin().position(&slot.point), sd_m))
    }
}
