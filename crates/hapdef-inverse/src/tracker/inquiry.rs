//! What is new: nothing, a contact more, a slide, or another hypothesis after all.

use crate::estimator::MAX_CONTACTS;
use crate::skin_point::SkinPoint;
use crate::tracker::belief::{Belief, Slot};
use crate::tracker::follow::{ContactTracker, Mode, Whose};
use crate::tracker::frame::{ContactId, Phase};

/// Places that a new contact is refined from.
const N_PEAKS: usize = 3;

/// Hypotheses to which a contact is added.
pub(super) const N_BASES: usize = 2;

/// Trial steps of each candidate.
const N_TRIALS: usize = 8;

/// What a scan counts of the budget.
pub(super) const SCAN_STEPS: usize = 8;

/// How far a contact may have slid unnoticed, m.
const LEAST_SLIDE_M: f64 = 2e-4;

/// Frames in which alarms are not heard after an inquiry without result.
const N_DEAF: usize = 16;

impl ContactTracker {
    /// All contacts are held: frames add up, and their mean updates the hypotheses.
    pub(super) fn hold(&mut self, is_alarm: bool, deaf: usize) {
        if is_alarm {
            if deaf == 0 {
                self.gathered.clear();
                self.gathered.add(&self.z, 1.0);
                self.mode = Mode::Inquiry { age: 1 };
            } else {
                self.mode = Mode::Quiet { deaf: deaf - 1 };
            }
            return;
        }
        self.mode = Mode::Quiet { deaf: deaf.saturating_sub(1) };
        self.gathered.add(&self.z, 1.0);
        if self.gathered.n_frames < self.params.block_frames {
            return;
        }
        if deaf == 0 && self.is_block_odd() {
            // weak contacts and slow slides, which single frames don't show
            let age = self.params.inquiry_frames.saturating_sub(1);
            self.mode = Mode::Inquiry { age };
            return;
        }
        self.learn();
        self.gathered.clear();
    }

    fn is_block_odd(&mut self) -> bool {
        let scale = self.gathered.frame(&mut self.work.z);
        let best = self.hypotheses.best();
        let forces = best.forces().map(|a| a * scale);
        let work = &mut self.work;
        work.filter.weigh(best, &forces, &mut work.metric);
        let solved = work.metric.solve(&work.z);
        self.is_odd(solved.chi2, best.n)
    }

    /// Updates every hypothesis with the frames gathered; contacts that moved are held from now on.
    pub(super) fn learn(&mut self) {
        let scale = self.gathered.frame(&mut self.work.z);
        let time_s = self.gathered.n_frames as f64 * self.params.frame_period_s;
        let drift = self.params.drift_m_per_sqrt_s.powi(2) * time_s;
        let prior_sd_m = self.skin_sd_m();
        let work = &mut self.work;
        for belief in self.hypotheses.alive_mut() {
            if belief.n == 0 {
                continue;
            }
            for i in 0..belief.n {
                for a in i * belief.d..i * belief.d + 2 {
                    belief.p[a * belief.stride + a] += drift;
                }
            }
            let metric = &mut work.metric;
            let model = &self.model;
            work.filter.update(model, belief, &work.z, scale, prior_sd_m, metric);
            let size_2: f64 = belief.forces().iter().map(|a| a * a).sum();
            let strain = size_2 / self.settings.force_scale_n.powi(2);
            belief.strain = belief.strain.max(strain);
            self.frame.info.n_updates += 1;
        }
        let delta = self.params.hypothesis_delta;
        self.frame.info.is_switched |= self.hypotheses.prune(&self.model, delta);
        self.refresh();
    }

    /// Gathers frames since the alarm, and decides when there are enough.
    pub(super) fn inquire(&mut self, age: usize) {
        self.gathered.add(&self.z, 1.0);
        self.mode = Mode::Inquiry { age };
        let first = self.params.inquiry_frames;
        let is_due = age.is_multiple_of(first) && (age / first).is_power_of_two();
        if is_due && !self.decide(age) && age >= 8 * first {
            self.mode = Mode::Quiet { deaf: N_DEAF };
            self.gathered.clear();
        }
    }

    /// Lets the candidates compete on the frames gathered; whether something changed.
    fn decide(&mut self, age: usize) -> bool {
        self.hypotheses.begin();
        let n_alive = self.hypotheses.n_alive();
        for j in 0..n_alive {
            if let Some(c) = self.hypotheses.copy(j) {
                let behind = self.hypotheses.candidates[c].total() - self.hypotheses.best().total();
                self.hypotheses.candidates[c].handicap = behind;
                self.settle(Whose::Candidate(c), 0);
            }
        }
        let nowhere = self.model.sites.points()[0];
        let newcomer = Slot::new(ContactId(self.next_id), nowhere, self.frame.index);
        for j in 0..n_alive.min(N_BASES) {
            if self.hypotheses.candidates[j].n < self.most_contacts() {
                self.propose_births(j, newcomer);
            }
        }
        let weakest = self.propose_replacement(newcomer);
        self.propose_slides(0, age);
        let stay = self.hypotheses.fits[0].evidence;
        let margin = self.params.birth_margin;
        let winner = self.hypotheses.winner().filter(|&c| {
            let is_other = c > 0 && c < n_alive;
            let margin = if is_other { 0.0 } else { margin };
            c > 0 && self.hypotheses.fits[c].evidence < stay - margin
        });
        let Some(winner) = winner else {
            return false;
        };
        self.adopt_winner(winner, n_alive, weakest);
        self.refresh();
        true
    }

    fn adopt_winner(&mut self, winner: usize, n_alive: usize, weakest: Option<(usize, ContactId)>) {
        let is_birth =
            self.hypotheses.candidates[winner].slots().iter().any(|slot| slot.phase == Phase::Born);
        let replaced = weakest.filter(|_| is_birth);
        let before = replaced.map_or(0, |(base, _)| base);
        self.before.copy_from(&self.hypotheses.candidates[before]);
        let delta = self.params.hypothesis_delta;
        self.hypotheses.take(&self.model, winner, delta);
        self.n_stuck = 0;
        self.was_good = false;
        if winner < n_alive {
            self.frame.info.is_switched = true;
            self.mode = Mode::Quiet { deaf: 0 };
            self.gathered.clear();
        } else if is_birth {
            if let Some((_, id)) = replaced {
                self.frame.released.push(id);
                self.frame.info.n_released += 1;
            }
            self.next_id += 1;
            self.frame.info.n_born += 1;
            self.trace = [mobile_force(self.hypotheses.best()); 2];
            let age = self.gathered.n_frames;
            self.mode = Mode::Growing { age };
        } else {
            self.start_slide();
        }
    }

    /// Where no contact more can be held: candidates with `newcomer` in place of the weakest contact.
    /// Returns the candidate without either and who it lacks.
    fn propose_replacement(&mut self, newcomer: Slot) -> Option<(usize, ContactId)> {
        let first = &self.hypotheses.candidates[0];
        if first.n < self.most_contacts() {
            return None;
        }
        let forces = first.forces();
        let weakest = (0..first.n).min_by(|&i, &j| forces[i].total_cmp(&forces[j]))?;
        let id = first.slots[weakest].id;
        let base = self.hypotheses.copy_candidate(0)?;
        self.hypotheses.candidates[base].remove(weakest);
        self.propose_births(base, newcomer);
        Some((base, id))
    }

    /// Candidates with `newcomer` more than candidate `base`, at the best places of a scan for a
    /// contact of about its force.
    pub(super) fn propose_births(&mut self, base: usize, newcomer: Slot) {
        if self.spend(SCAN_STEPS) < SCAN_STEPS {
            return;
        }
        self.scan_beside(base, newcomer.force_n);
        self.work.scan.find_peaks(&self.model, N_PEAKS);
        for k in 0..self.work.scan.peaks.len() {
            let site = self.work.scan.peaks[k].site;
            let point = self.model.sites.points()[site];
            if !self.is_apart(&self.hypotheses.candidates[base], &point) {
                continue;
            }
            let Some(c) = self.hypotheses.copy_candidate(base) else {
                return;
            };
            let slot = Slot { point, ..newcomer };
            self.hypotheses.candidates[c].push(&self.model, slot);
            self.settle(Whose::Candidate(c), N_TRIALS);
            let candidate = &self.hypotheses.candidates[c];
            let born = &candidate.slots[candidate.n - 1];
            let is_weak = born.force_n < self.params.release_force_n;
            if is_weak || !self.is_apart(&self.hypotheses.candidates[base], &born.point) {
                self.hypotheses.fits[c].evidence = f64::INFINITY;
            }
        }
    }

    /// Scans the sites beside candidate `base` on the frames gathered.
    pub(super) fn scan_beside(&mut self, base: usize, newcomer_n: f64) {
        self.frame.info.n_scans += 1;
        let scale = self.gathered.frame(&mut self.work.z);
        let belief = &self.hypotheses.candidates[base];
        let forces = belief.forces().map(|a| a * scale);
        let work = &mut self.work;
        work.filter.weigh_beside(belief, &forces, newcomer_n * scale, &mut work.metric);
        let solved = work.metric.solve(&work.z);
        work.scan.scan(&work.metric, &solved.forces);
    }

    /// Candidates in which one of the contacts of candidate `base` has slid for `n_frames`.
    pub(super) fn propose_slides(&mut self, base: usize, n_frames: usize) {
        let time_s = n_frames as f64 * self.params.frame_period_s;
        let sd_m = self.params.slide_m_per_s * time_s + LEAST_SLIDE_M;
        for i in 0..self.hypotheses.candidates[base].n {
            let slot = self.hypotheses.candidates[base].slots[i];
            if slot.force_n < self.params.release_force_n {
                continue;
            }
            let Some(c) = self.hypotheses.copy_candidate(base) else {
                return;
            };
            let from = self.model.skin().position(&slot.point);
            let candidate = &mut self.hypotheses.candidates[c];
            candidate.slots[i].phase = Phase::Sliding;
            candidate.slots[i].slide = Some((from, sd_m));
            candidate.forget(&self.model, i);
            self.settle(Whose::Candidate(c), N_TRIALS);
        }
    }

    fn is_apart(&self, belief: &Belief, point: &SkinPoint) -> bool {
        let skin = self.model.skin();
        let x = skin.position(point);
        let far = |slot: &Slot| (skin.position(&slot.point) - x).norm() >= self.params.min_gap_m;
        debug_assert!(belief.n <= MAX_CONTACTS);
        belief.slots().iter().all(far)
    }
}

/// Forces of the contacts that move, together.
pub(super) fn mobile_force(belief: &Belief) -> f64 {
    let mobile = belief.slots().iter().filter(|slot| slot.is_mobile());
    mobile.map(|slot| slot.force_n).sum()
}
