//! The end of a frame: who is let go, and what is said.

use nalgebra::Point3;

use crate::chi_square::upper_tail;
use crate::estimator::{Contact, Verdict, WhyNot, spare_numbers};
use crate::tracker::follow::{ContactTracker, Mode};
use crate::tracker::frame::TrackedContact;
use crate::tracker::hypothesis::Track;

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
            let track = &mut best.tracks[i];
            let sd = track.covariance[(2, 2)].sqrt();
            let is_weak = track.force_n < least_n || (track.force_n < 3.0 * sd && sd < 1.0);
            track.n_weak = if is_weak { track.n_weak + 1 } else { track.n_weak.saturating_sub(2) };
            if track.n_weak >= patience {
                self.frame.released.push(track.id);
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
            self.mode = Mode::Quiet { holdoff: 0 };
        }
        self.pair_birth.stop();
        self.gathered.clear();
        self.refresh();
    }

    /// Averages forces while all of them are steady.
    fn average(&mut self) {
        let most = self.params.force_frames;
        let best = self.hypotheses.best_mut();
        let tracks = &mut best.tracks[..best.n];
        let is_steady = tracks.iter().all(|track| {
            let (mean, n) = track.steady;
            let sd = track.force_noise_n * (1.0 + 1.0 / n.max(1) as f64).sqrt();
            n > 0 && (track.force_n - mean).abs() <= STEADY_SDS * sd
        });
        for track in tracks {
            let (mean, n) = if is_steady { track.steady } else { (0.0, 0) };
            let n = (n + 1).min(most);
            track.steady = (mean + (track.force_n - mean) / n as f64, n);
        }
    }

    pub(super) fn report(&mut self, readings: &[f64]) {
        self.average();
        let best = self.hypotheses.best();
        let (frame, model) = (&mut self.frame, &self.model);
        let skin = model.skin();
        frame.contacts.clear();
        for track in best.tracks() {
            let mut covariance = track.covariance;
            model.tell(covariance.as_mut_slice(), 3);
            let contact = Contact {
                point: track.point,
                position_m: skin.position(&track.point),
                force_n: track.steady.0,
                force_vector_n: -skin.normal(&track.point) * track.steady.0,
                covariance,
            };
            frame.contacts.push(TrackedContact {
                id: track.id,
                phase: track.phase,
                age_frames: frame.index.saturating_sub(track.born),
                contact,
            });
        }
        frame.contacts.sort_unstable_by_key(|contact| contact.id);
        for (g, &gauge) in model.live.iter().enumerate() {
            let explained: f64 =
                (0..best.n).map(|i| best.tracks[i].force_n * best.atoms[i * best.width + g]).sum();
            let is_read = self.work.filter.live[g];
            let left = readings[gauge] - explained * model.l[g * model.m + g];
            frame.residual[gauge] = if is_read { left } else { 0.0 };
        }
        frame.p_value = upper_tail(frame.chi2, frame.n_dof);
        frame.n_runner_ups = self.hypotheses.n_alive() - 1;
        frame.info.is_detecting = matches!(self.mode, Mode::DetectionWindow { .. });
        self.frame.verdict = self.verdict();
    }

    /// What else may explain the frames so far, in no order: how much worse it is than the best
    /// explanation in −2 ln evidence, and its contacts' places, m, and normal forces, N. There are
    /// [`crate::TrackedFrame::n_runner_ups`].
    pub fn runner_ups(
        &self,
    ) -> impl Iterator<Item = (f64, impl Iterator<Item = (Point3<f64>, f64)>)> {
        let best = self.hypotheses.best().cost();
        let skin = self.model.skin();
        self.hypotheses.others().iter().map(move |other| {
            let tracks = other.tracks().iter();
            let contacts = tracks.map(move |track| (skin.position(&track.point), track.force_n));
            (other.cost() - best, contacts)
        })
    }

    /// Standard deviation of a place anywhere on the skin, m.
    pub(super) fn skin_sd_m(&self) -> f64 {
        (self.model.skin().area_m2() / std::f64::consts::TAU).sqrt()
    }

    fn verdict(&self) -> Verdict {
        let contacts = &self.frame.contacts;
        let skin_sd_m = self.skin_sd_m();
        let open = |track: &Track| {
            let p = &track.covariance;
            let (a, b, d) = (p[(0, 0)], p[(0, 1)], p[(1, 1)]);
            let largest = 0.5 * (a + d) + (0.25 * (a - d).powi(2) + b * b).sqrt();
            largest.sqrt() > OPEN_SHARE * skin_sd_m
        };
        if self.frame.p_value < self.params.misfit_p {
            Verdict::NotIdentifiable(WhyNot::Misfit)
        } else if contacts.is_empty() {
            Verdict::Untouched
        } else if self.hypotheses.best().tracks().iter().any(open) {
            Verdict::NotIdentifiable(WhyNot::SingularInformation)
        } else if !self.is_checked() {
            Verdict::NotIdentifiable(WhyNot::Unchecked)
        } else if self.hypotheses.lead() <= self.settings.tie_delta || self.are_two_in_one_place() {
            Verdict::NotIdentifiable(WhyNot::TiedExplanations)
        } else {
            Verdict::Identified
        }
    }

    /// Whether two contacts are where the readings fit one as well as two: one that grows by kilonewtons a frame
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
