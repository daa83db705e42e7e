//! Tares that don't hold: refused, or found out when what pressed unseen lets go.

use std::sync::Arc;

use hapdef_contact::{Contact, TouchPhase, UnknownReason};
use hapdef_inverse::{DriftState, TareEnd};

use super::Compute;
use super::cause::{LEAST_P, MOST_DRIFT_S, is_better, is_drift, is_press, is_release};
use super::conditioning::Conditioning;
use crate::estimator::Explained;
use crate::sink::LiveEvent;
use crate::tare_fault::{Retare, TareFault, TareFaultKind, TareOutcome};

/// A release is believed with so many numbers to check it by beside the three of each of its contacts: with one left, a
/// wrong map lets three mirrored contacts explain a press.
const LEAST_CHECKS: usize = 4;

/// Times after something began to touch when it is looked whether it is a release, s: at once, and later for
/// hands that let go slowly.
const LOOKS_S: [f64; 5] = [0.08, 0.16, 0.32, 0.64, 1.28];

/// Time over which readings are averaged for a look, s.
const MEAN_S: f64 = 0.032;

/// Readings have settled whose halves of that time differ by so many standard deviations, or by this share.
const SETTLED_SDS: f64 = 5.0;
const SETTLED_SHARE: f64 = 0.03;

/// Times that a tare that was asked for begins again by itself because its readings moved: a hand that asks for it
/// has often not let go yet.
const MOST_REPEATS: usize = 2;

/// What is watched after the zero was taken.
#[derive(Clone, Debug, Default)]
pub(super) struct TareWatch {
    /// The fault that makes the zero invalid.
    fault: Option<Arc<TareFault>>,
    /// Times that the tare began again.
    pub(super) n_repeats: usize,
    /// When nothing touched last, or the first frame came, on the host's clock.
    untouched_ns: Option<u64>,
    /// The device was away since then.
    pub(super) has_gap: bool,
    /// Frames since something began to touch.
    n_touched: usize,
    /// Mean readings that are being explained `[n_gauges]`, µε.
    asked: Option<Vec<f64>>,
    /// Sums of the readings in both halves of the time before a look `[n_gauges]`.
    halves: [Vec<f64>; 2],
}

impl TareWatch {
    /// Whether the zero is not that of an untouched limb.
    pub(super) fn is_invalid(&self) -> bool {
        self.fault.is_some()
    }

    /// Of readings of so many gauges.
    pub(super) fn new(n_gauges: usize) -> Self {
        Self { halves: [vec![0.0; n_gauges], vec![0.0; n_gauges]], ..Self::default() }
    }

    /// Nothing touches: what is asked about is over.
    fn let_go(&mut self) {
        (self.n_touched, self.asked) = (0, None);
    }

    /// Adds a frame in which something touches; whether it is time for a look at [`TareWatch::mean`], the
    /// readings having settled.
    fn look(&mut self, readings: &[f64], period_s: f64, sd_ue: f64) -> bool {
        self.n_touched += 1;
        let n_mean = ((MEAN_S / period_s) as usize).max(2);
        let n_look = LOOKS_S.map(|at_s| (at_s / period_s).round() as usize);
        let Some(&n_look) = n_look.iter().find(|n| **n >= self.n_touched) else {
            return false;
        };
        let n_left = n_look - self.n_touched;
        if n_left >= n_mean {
            return false;
        }
        if n_left + 1 == n_mean {
            self.halves.iter_mut().for_each(|half| half.fill(0.0));
        }
        let half = &mut self.halves[usize::from(2 * n_left < n_mean)];
        half.iter_mut().zip(readings).for_each(|(sum, r)| *sum += 2.0 * r / n_mean as f64);
        let pairs = || self.halves[0].iter().zip(&self.halves[1]);
        let most = pairs().map(|(a, b)| a.abs().max(b.abs())).fold(0.0, f64::max);
        let apart = pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let noise = SETTLED_SDS * sd_ue * (4.0 / n_mean as f64).sqrt();
        n_left == 0 && apart < noise.max(SETTLED_SHARE * most)
    }

    /// Mean readings before a look `[n_gauges]`, µε.
    fn mean(&self) -> Vec<f64> {
        self.halves[0].iter().zip(&self.halves[1]).map(|(a, b)| 0.5 * (a + b)).collect()
    }
}

impl Compute {
    /// What the end of a tare means: it is taken, or refused with what presses.
    pub(super) fn end_tare(&mut self, end: TareEnd) {
        let Some(conditioning) = &self.conditioning else {
            return;
        };
        let conditioner = &conditioning.conditioner;
        let (kind, readings) = match end {
            TareEnd::Refused(found) => {
                let kind = TareFaultKind::Moved { gauge: found.gauge, by_ue: found.by };
                (Some(kind), Some(conditioner.tare_moved().to_vec()))
            }
            // what let go unseen is no press when its zero is given up
            TareEnd::Taken if self.tare_watch.is_invalid() && conditioner.has_zero_before() => {
                (None, None)
            }
            TareEnd::Taken => (None, conditioner.tare_shift()),
        };
        let is_steady = kind.is_none();
        let contacts = readings.map_or_else(Vec::new, |shift| self.pressing(&shift, is_steady));
        let kind = match kind {
            None if contacts.is_empty() => return self.tare_taken(),
            None => TareFaultKind::Pressed,
            Some(kind) => kind,
        };
        let Some(conditioning) = &mut self.conditioning else {
            return;
        };
        if kind == TareFaultKind::Pressed {
            conditioning.conditioner.refuse_tare();
        }
        conditioning.noise.start_over();
        let conditioner = &mut conditioning.conditioner;
        let is_moved = matches!(kind, TareFaultKind::Moved { .. });
        if is_moved && !conditioner.is_taring() && self.tare_watch.n_repeats < MOST_REPEATS {
            self.tare_watch.n_repeats += 1;
            conditioner.tare();
        }
        let is_again = conditioner.is_taring();
        let outcome = match (is_again, self.tare_watch.is_invalid()) {
            (true, _) => TareOutcome::Again,
            (false, true) => TareOutcome::Waits,
            (false, false) => TareOutcome::Kept,
        };
        self.tare_watch.let_go();
        self.tell_tare_fault(TareFault { kind, contacts, outcome });
    }

    /// The contacts that moved the readings by `shift` `[n_gauges]`, µε. A single one is believed wherever it explains
    /// them; of more than that, which explain much, a steady zero is asked first whether it drifted there.
    fn pressing(&mut self, shift: &[f64], is_steady: bool) -> Vec<Contact> {
        let Some([pressing, released]) = self.explain(shift) else {
            return Vec::new();
        };
        if !is_press(&pressing) || is_better(&released, &pressing) {
            return Vec::new();
        }
        let is_several = is_steady && pressing.contacts.len() > 1;
        if is_several && self.has_drifted(shift) { Vec::new() } else { pressing.contacts }
    }

    /// Whether drift since nothing touched explains that the zero moved by `shift` `[n_gauges]`, µε.
    fn has_drifted(&self, shift: &[f64]) -> bool {
        let since_ns = self.tare_watch.untouched_ns.unwrap_or_default();
        let time_s = self.frame.t_host_ns.saturating_sub(since_ns) as f64 * 1e-9;
        let most_s = if self.tare_watch.has_gap { f64::INFINITY } else { MOST_DRIFT_S };
        let time_s = time_s.max(self.setup.params.tare_s).min(most_s);
        let least = self.setup.noise_ue;
        let noise_ue: Vec<f64> = match &self.counts.noise_ue[..] {
            [] => vec![least; shift.len()],
            noise_ue => noise_ue.iter().map(|noise| noise.max(least)).collect(),
        };
        let conditioning = self.conditioning.as_ref();
        conditioning.is_some_and(|c| is_drift(c, shift, &noise_ue, time_s))
    }

    fn tare_taken(&mut self) {
        self.take_noise();
        self.tare_watch.fault = None;
        self.tare_watch.let_go();
        self.counts.tare_fault = None;
        self.tell(&LiveEvent::Tared);
    }

    fn tell_tare_fault(&mut self, fault: TareFault) {
        let fault = Arc::new(fault);
        let has_zero = |c: &Conditioning| c.conditioner.has_zero_before();
        let is_invalid = match fault.outcome {
            TareOutcome::Again => !self.conditioning.as_ref().is_some_and(has_zero),
            outcome => outcome == TareOutcome::Waits,
        };
        if is_invalid {
            self.tare_watch.fault = Some(Arc::clone(&fault));
        }
        self.counts.tare_fault = Some(Arc::clone(&fault));
        self.tell(&LiveEvent::TareFault(fault));
    }

    /// Says what the zero is worth: after conditioning, before contacts are looked for.
    pub(super) fn judge_zero(&mut self) {
        let now_ns = self.frame.t_host_ns;
        self.tare_watch.untouched_ns.get_or_insert(now_ns);
        if self.frame.phase == TouchPhase::Untouched {
            (self.tare_watch.untouched_ns, self.tare_watch.has_gap) = (Some(now_ns), false);
            self.tare_watch.let_go();
        }
        if self.tare_watch.is_invalid() {
            self.frame.phase = TouchPhase::Unknown(UnknownReason::TareInvalid);
        }
    }

    /// Looks at the contacts found: whether they are a release or drift.
    pub(super) fn judge_contacts(&mut self) {
        let Some(conditioning) = &self.conditioning else {
            return;
        };
        let drift = conditioning.out.drift;
        let touch = &mut self.frame.touch;
        if self.frame.phase == TouchPhase::Untouched && drift == DriftState::Followed {
            // what the filter catches up with within tenths of a second
            if !touch.contacts.is_empty() {
                touch.clear();
            }
            return;
        }
        if self.frame.phase != TouchPhase::Touched {
            return;
        }
        if drift == DriftState::Unsure {
            touch.clear();
            self.frame.phase = TouchPhase::Unknown(UnknownReason::Drift);
            return;
        }
        let quality = touch.quality;
        let is_explained = quality.is_some_and(|quality| quality.is_identified());
        if matches!(drift, DriftState::TooFast { .. }) && !is_explained {
            self.frame.phase = TouchPhase::Unknown(UnknownReason::Drift);
        }
        self.look_for_release();
    }

    /// Finds out whether what touches is the release of what pressed during the tare: it is looked at now and then,
    /// and the answer comes later, as full searches take longer than frames may.
    fn look_for_release(&mut self) {
        let Some(device) = &self.device else {
            return;
        };
        let sd_ue = self.counts.noise_ue.iter().copied().fold(self.setup.noise_ue, f64::max);
        let is_due = self.tare_watch.look(&self.frame.tared_ue, device.period_s, sd_ue);
        let touch = &self.frame.touch;
        let is_press = touch.contacts.len() == 1
            && touch.quality.is_some_and(|q| q.is_identified() && q.p_value > LEAST_P);
        let answer = self.setup.estimator.as_mut().and_then(|estimator| estimator.explained());
        self.judge_release(answer);
        let is_over = self.frame.phase != TouchPhase::Touched;
        let Some(estimator) = &mut self.setup.estimator else {
            return;
        };
        if !is_due || is_press || is_over {
            return;
        }
        let live = self.conditioning.as_ref().map(|c| &c.out.live[..]);
        let mean = self.tare_watch.mean();
        let answer = estimator.begin_to_explain(&mean, live).ok().flatten();
        self.tare_watch.asked = Some(mean);
        self.judge_release(answer);
    }

    /// What explains the readings that were asked about, pressing and released, says whether something was let go.
    fn judge_release(&mut self, found: Option<[Explained; 2]>) {
        let Some([pressing, released]) = found else {
            return;
        };
        let Some(mean) = self.tare_watch.asked.take() else {
            return;
        };
        let is_checked = 3 * released.contacts.len() + LEAST_CHECKS <= mean.len();
        if !is_checked || !is_release(&released, &pressing) {
            return;
        }
        let is_put_right = self.setup.params.retare == Retare::Auto;
        if is_put_right && let Some(conditioning) = &mut self.conditioning {
            // lengths are those of the device
            let _ = conditioning.conditioner.shift(&mean);
            self.start_over();
            self.tare_watch.let_go();
            self.frame.phase = TouchPhase::Untouched;
        } else {
            self.frame.phase = TouchPhase::Unknown(UnknownReason::TareInvalid);
        }
        self.frame.touch.clear();
        let outcome = if is_put_right { TareOutcome::PutRight } else { TareOutcome::Waits };
        let (kind, contacts) = (TareFaultKind::PressedUnseen, released.contacts);
        self.tell_tare_fault(TareFault { kind, contacts, outcome });
    }

    fn explain(&mut self, readings_ue: &[f64]) -> Option<[Explained; 2]> {
        let live = self.conditioning.as_ref().map(|c| &c.out.live[..]);
        let estimator = self.setup.estimator.as_mut()?;
        estimator.explain(readings_ue, live).ok().flatten()
    }
}
