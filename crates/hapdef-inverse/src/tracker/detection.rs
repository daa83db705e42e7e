//! What is new: nothing, a contact more, a slide, or another hypothesis after all.

use crate::estimator::MAX_CONTACTS;
use crate::skin_point::SkinPoint;
use crate::tracker::follow::{ContactTracker, HypothesisRef, Mode};
use crate::tracker::frame::{ContactId, Phase};
use crate::tracker::hypothesis::{Hypothesis, Track};

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

/// Frames in which alarms are held off after a detection window without result.
const N_HOLDOFF: usize = 16;

impl ContactTracker {
    /// All contacts are held: frames add up, and their mean updates the hypotheses.
    pub(super) fn hold(&mut self, is_alarm: bool, holdoff: usize) {
        if is_alarm {
            if holdoff == 0 {
                self.gathered.clear();
                self.gathered.add(&self.z, 1.0);
                self.mode = Mode::DetectionWindow { age: 1 };
            } else {
                self.mode = Mode::Quiet { holdoff: holdoff - 1 };
            }
            return;
        }
        self.mode = Mode::Quiet { holdoff: holdoff.saturating_sub(1) };
        self.gathered.add(&self.z, 1.0);
        if self.gathered.n_frames < self.params.block_frames {
            return;
        }
        if holdoff == 0 && self.is_block_odd() {
            // weak contacts and slow slides, which single frames don't show
            let age = self.params.detection_frames.saturating_sub(1);
            self.mode = Mode::DetectionWindow { age };
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
        for hypothesis in self.hypotheses.alive_mut() {
            if hypothesis.n == 0 {
                continue;
            }
            for i in 0..hypothesis.n {
                for a in i * hypothesis.d..i * hypothesis.d + 2 {
                    hypothesis.p[a * hypothesis.stride + a] += drift;
                }
            }
            let metric = &mut work.metric;
            let model = &self.model;
            work.filter.update(model, hypothesis, &work.z, scale, prior_sd_m, metric);
            let size_2: f64 = hypothesis.forces().iter().map(|a| a * a).sum();
            let prior_penalty = size_2 / self.settings.force_scale_n.powi(2);
            hypothesis.prior_penalty = hypothesis.prior_penalty.max(prior_penalty);
            self.frame.info.n_updates += 1;
        }
        let delta = self.params.hypothesis_delta;
        self.frame.info.is_switched |= self.hypotheses.prune(&self.model, delta);
        self.refresh();
    }

    /// Gathers frames since the alarm, and decides when there are enough.
    pub(super) fn detect(&mut self, age: usize) {
        self.gathered.add(&self.z, 1.0);
        self.mode = Mode::DetectionWindow { age };
        let first = self.params.detection_frames;
        let is_due = age.is_multiple_of(first) && (age / first).is_power_of_two();
        if is_due && !self.decide(age) && age >= 8 * first {
            self.mode = Mode::Quiet { holdoff: N_HOLDOFF };
            self.gathered.clear();
        }
    }

    /// Lets the candidates compete on the frames gathered; whether something changed.
    fn decide(&mut self, age: usize) -> bool {
        self.hypotheses.begin();
        let n_alive = self.hypotheses.n_alive();
        for j in 0..n_alive {
            if let Some(c) = self.hypotheses.copy(j) {
                let behind = self.hypotheses.candidates[c].cost() - self.hypotheses.best().cost();
                self.hypotheses.candidates[c].handicap = behind;
                self.settle(HypothesisRef::Candidate(c), 0);
            }
        }
        let nowhere = self.model.sites.points()[0];
        let newcomer = Track::new(ContactId(self.next_id), nowhere, self.frame.index);
        for j in 0..n_alive.min(N_BASES) {
            if self.hypotheses.candidates[j].n < self.most_contacts() {
                self.propose_births(j, newcomer);
            }
        }
        let weakest = self.propose_replacement(newcomer);
        self.propose_slides(0, age);
        let stay = self.hypotheses.fits[0].cost;
        let margin = self.params.birth_margin;
        let winner = self.hypotheses.winner().filter(|&c| {
            let is_other = c > 0 && c < n_alive;
            let margin = if is_other { 0.0 } else { margin };
            c > 0 && self.hypotheses.fits[c].cost < stay - margin
        });
        let Some(winner) = winner else {
            return false;
        };
        self.adopt_winner(winner, n_alive, weakest);
        self.refresh();
        true
    }

    fn adopt_winner(&mut self, winner: usize, n_alive: usize, weakest: Option<(usize, ContactId)>) {
        let is_birth = self.hypotheses.candidates[winner]
            .tracks()
            .iter()
            .any(|track| track.phase == Phase::Born);
        let replaced = weakest.filter(|_| is_birth);
        let before = replaced.map_or(0, |(base, _)| base);
        self.before.copy_from(&self.hypotheses.candidates[before]);
        let delta = self.params.hypothesis_delta;
        self.hypotheses.take(&self.model, winner, delta);
        self.n_stuck = 0;
        self.was_good = false;
        if winner < n_alive {
            self.frame.info.is_switched = true;
            self.mode = Mode::Quiet { holdoff: 0 };
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
    fn propose_replacement(&mut self, newcomer: Track) -> Option<(usize, ContactId)> {
        let first = &self.hypotheses.candidates[0];
        if first.n < self.most_contacts() {
            return None;
        }
        let forces = first.forces();
        let weakest = (0..first.n).min_by(|&i, &j| forces[i].total_cmp(&forces[j]))?;
        let id = first.tracks[weakest].id;
        let base = self.hypotheses.copy_candidate(0)?;
        self.hypotheses.candidates[base].remove(weakest);
        self.propose_births(base, newcomer);
        Some((base, id))
    }

    /// Candidates with `newcomer` more than candidate `base`, at the best places of a scan for a
    /// contact of about its force.
    pub(super) fn propose_births(&mut self, base: usize, newcomer: Track) {
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
            let track = Track { point, ..newcomer };
            self.hypotheses.candidates[c].push(&self.model, track);
            self.settle(HypothesisRef::Candidate(c), N_TRIALS);
            let candidate = &self.hypotheses.candidates[c];
            let born = &candidate.tracks[candidate.n - 1];
            let is_weak = born.force_n < self.params.release_force_n;
            if is_weak || !self.is_apart(&self.hypotheses.candidates[base], &born.point) {
                self.hypotheses.fits[c].cost = f64::INFINITY;
            }
        }
    }

    /// Scans the sites beside candidate `base` on the frames gathered.
    pub(super) fn scan_beside(&mut self, base: usize, newcomer_n: f64) {
        self.frame.info.n_scans += 1;
        let scale = self.gathered.frame(&mut self.work.z);
        let hypothesis = &self.hypotheses.candidates[base];
        let forces = hypothesis.forces().map(|a| a * scale);
        let work = &mut self.work;
        work.filter.weigh_beside(hypothesis, &forces, newcomer_n * scale, &mut work.metric);
        let solved = work.metric.solve(&work.z);
        work.scan.scan(&work.metric, &solved.forces);
    }

    /// Candidates in which one of the contacts of candidate `base` has slid for `n_frames`.
    pub(super) fn propose_slides(&mut self, base: usize, n_frames: usize) {
        let time_s = n_frames as f64 * self.params.frame_period_s;
        let sd_m = self.params.slide_m_per_s * time_s + LEAST_SLIDE_M;
        for i in 0..self.hypotheses.candidates[base].n {
            let track = self.hypotheses.candidates[base].tracks[i];
            if track.force_n < self.params.release_force_n {
                continue;
            }
            let Some(c) = self.hypotheses.copy_candidate(base) else {
                return;
            };
            let from = self.model.skin().position(&track.point);
            let candidate = &mut self.hypotheses.candidates[c];
            candidate.tracks[i].phase = Phase::Sliding;
            candidate.tracks[i].slide = Some((from, sd_m));
            candidate.forget(&self.model, i);
            self.settle(HypothesisRef::Candidate(c), N_TRIALS);
        }
    }

    fn is_apart(&self, hypothesis: &Hypothesis, point: &SkinPoint) -> bool {
        let skin = self.model.skin();
        let x = skin.position(point);
        let far = |track: &Track| (skin.position(&track.point) - x).norm() >= self.params.min_gap_m;
        debug_assert!(hypothesis.n <= MAX_CONTACTS);
        hypothesis.tracks().iter().all(far)
    }
}

/// Forces of the contacts that move, together.
pub(super) fn mobile_force(hypothesis: &Hypothesis) -> f64 {
    let mobile = hypothesis.tracks().iter().filter(|track| track.is_mobile());
    mobile.map(|track| track.force_n).sum()
}
