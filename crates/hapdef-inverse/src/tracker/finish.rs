//! The end of a frame: who is let go, and what is said.

use nalgebra::Point3;

use crate::chi_square::upper_tail;
use crate::estimator::{Contact, Verdict, WhyNot, spare_numbers};
use crate::tracker::belief::Slot;
use crate::tracker::follow::{ContactTracker, Mode};
use crate::tracker::frame::TrackedContact;

/// A place is open if its standard deviation exceeds this share of the skin's.
const OPEN_SHARE: f64 = 0.5;

/// Unknowns of a place.
const PLACE_UNKNOWNS: usize = 2;

/// A force is steady within so many standard deviations.
const STEADY_SDS: f64 = 3.0;

impl ContactTracker {
    pub(super) fn release(&mut self) {
        let (least_n, patience) = (self.params.release_force_n, self.params.release_frames);
        let best = self.hypotheses.best_mut();
        let mut n_released = 0;
        for i in (0..best.n).rev() {
            let slot = &mut best.slots[i];
            let sd = slot.covariance[(2, 2)].sqrt();
            let is_weak = slot.force_n < least_n || (slot.force_n < 3.0 * sd && sd < 1.0);
            slot.n_weak = if is_weak { slot.n_weak + 1 } else { slot.n_weak.saturating_sub(2) };
            if slot.n_weak >= patience {
                self.frame.released.push(slot.id);
                best.remove(i);
                n_released += 1;
            }
        }
        if n_released == 0 {
            return;
        }
        self.frame.info.n_released += n_released;
        for id in &self.frame.released {
            self.hypotheses.drop_contact(*id);
        }
        if self.hypotheses.best().n_mobile() == 0
            && matches!(self.mode, Mode::Growing { .. } | Mode::Sliding { .. })
        {
            self.mode = Mode::Quiet { deaf: 0 };
        }
        self.pair_birth.stop();
        self.gathered.clear();
        self.refresh();
    }

    /// Averages forces while all of them are steady.
    fn average(&mut self) {
        let most = self.params.force_frames;
        let best = self.hypotheses.best_mut();
        let slots = &mut best.slots[..best.n];
        let is_steady = slots.iter().all(|slot| {
            let (mean, n) = slot.steady;
            let sd = slot.force_noise_n * (1.0 + 1.0 / n.max(1) as f64).sqrt();
            n > 0 && (slot.force_n - mean).abs() <= STEADY_SDS * sd
        });
        for slot in slots {
            let (mean, n) = if is_steady { slot.steady } else { (0.0, 0) };
            let n = (n + 1).min(most);
            slot.steady = (mean + (slot.force_n - mean) / n as f64, n);
        }
    }

    pub(super) fn report(&mut self, readings: &[f64]) {
        self.average();
        let best = self.hypotheses.best();
        let (frame, model) = (&mut self.frame, &self.model);
        let skin = model.skin();
        frame.contacts.clear();
        for slot in best.slots() {
            let mut covariance = slot.covariance;
            model.tell(covariance.as_mut_slice(), 3);
            let contact = Contact {
                point: slot.point,
                position_m: skin.position(&slot.point),
                force_n: slot.steady.0,
                force_vector_n: -skin.normal(&slot.point) * slot.steady.0,
                covariance,
            };
            frame.contacts.push(TrackedContact {
                id: slot.id,
                phase: slot.phase,
                age_frames: frame.index.saturating_sub(slot.born),
                contact,
            });
        }
        frame.contacts.sort_unstable_by_key(|contact| contact.id);
        for (g, &gauge) in model.live.iter().enumerate() {
            let explained: f64 =
                (0..best.n).map(|i| best.slots[i].force_n * best.atoms[i * best.width + g]).sum();
            let is_read = self.work.filter.live[g];
            let left = readings[gauge] - explained * model.l[g * model.m + g];
            frame.residual[gauge] = if is_read { left } else { 0.0 };
        }
        frame.p_value = upper_tail(frame.chi2, frame.n_dof);
        frame.n_runner_ups = self.hypotheses.n_alive() - 1;
        frame.info.is_inquiry = matches!(self.mode, Mode::Inquiry { .. });
        self.frame.verdict = self.verdict();
    }

    /// What else may explain the frames so far, in no order: how much worse it is than the best
    /// explanation in −2 ln evidence, and its contacts' places, m, and normal forces, N. There are
    /// [`crate::TrackedFrame::n_runner_ups`].
    pub fn runner_ups(
        &self,
    ) -> impl Iterator<Item = (f64, impl Iterator<Item = (Point3<f64>, f64)>)> {
        let best = self.hypotheses.best().total();
        let skin = self.model.skin();
        self.hypotheses.others().iter().map(move |other| {
            let slots = other.slots().iter();
            let contacts = slots.map(move |slot| (skin.position(&slot.point), slot.force_n));
            (other.total() - best, contacts)
        })
    }

    /// Standard deviation of a place anywhere on the skin, m.
    pub(super) fn skin_sd_m(&self) -> f64 {
        (self.model.skin().area_m2() / std::f64::consts::TAU).sqrt()
    }

    fn verdict(&self) -> Verdict {
        let contacts = &self.frame.contacts;
        let skin_sd_m = self.skin_sd_m();
        let open = |slot: &Slot| {
            let p = &slot.covariance;
            let (a, b, d) = (p[(0, 0)], p[(0, 1)], p[(1, 1)]);
            let largest = 0.5 * (a + d) + (0.25 * (a - d).powi(2) + b * b).sqrt();
            largest.sqrt() > OPEN_SHARE * skin_sd_m
        };
        if self.frame.p_value < self.params.misfit_p {
            Verdict::NotIdentifiable(WhyNot::Misfit)
        } else if contacts.is_empty() {
            Verdict::Untouched
        } else if self.hypotheses.best().slots().iter().any(open) {
            Verdict::NotIdentifiable(WhyNot::SingularInformation)
        } else if !self.is_checked() {
            Verdict::NotIdentifiable(WhyNot::Unchecked)
        } else if self.hypotheses.lead() <= self.settings.tie_delta || self.are_two_in_one_place() {
            Verdict::NotIdentifiable(WhyNot::TiedExplanations)
        } else {
            Verdict::Identified
        }
    }

    /// Whether two contacts are where one is told as well as two: one that grows by kilonewtons a frame
    /// is, before its place is exact, explained best by two beside it.
    fn are_two_in_one_place(&self) -> bool {
        let place = |c: &TrackedContact| c.contact.position_m;
        let (contacts, apart_m) = (&self.frame.contacts, self.settings.distinct_m);
        contacts.iter().enumerate().any(|(i, one)| {
            let others = &contacts[..i];
            let is_there = |c: &TrackedContact| (place(c) - place(one)).norm() < apart_m;
            others.iter().any(is_there)
        })
    }

    /// Whether live gauges tell enough to check the newest contact by, the places of the others known.
    fn is_checked(&self) -> bool {
        let n = self.frame.contacts.len();
        let is_last = n >= self.params.max_contacts;
        self.n_live >= n + PLACE_UNKNOWNS + spare_numbers(is_last)
    }
}
