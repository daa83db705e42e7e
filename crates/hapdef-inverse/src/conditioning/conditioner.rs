//! The filter in front of the estimator.

use hapdef_contact::{GaugeHealth, TouchPhase};

use crate::chi_square::upper_tail;
use crate::conditioning::conditioned::{Conditioned, DriftState, TareEnd};
use crate::conditioning::detector::TouchDetector;
use crate::conditioning::drift::{DRIFT_S, Drift};
use crate::conditioning::faults::{Watch, find_faults};
use crate::conditioning::limits::DriftLimits;
use crate::conditioning::load_fit::LoadFit;
use crate::conditioning::params::ConditionerParams;
use crate::conditioning::tare::TareCheck;
use crate::conditioning::tracker::Tracker;
use crate::error::{InverseError, check_length, check_positive};

/// Takes tare, drift, temperature and creep off raw readings and masks bad gauges.
///
/// A contact whose readings grow more slowly than zeros may drift can't be distinguished from drift and is
/// learned; [`ConditionerParams::drift_limit`] says how slowly.
#[derive(Clone, Debug)]
pub struct Conditioner {
    params: ConditionerParams,
    trackers: Vec<Tracker>,
    watches: Vec<Watch>,
    touch: TouchDetector,
    drift: Drift,
    loads: LoadFit,
    is_taring: bool,
    check: TareCheck,
    /// What there was before the tare that is taken or was the last one.
    before: Before,
    moved: Vec<f64>,
    tare_temperature_k: Option<f64>,
    /// Running means of the readings since the last frame that was surely touched `[n_gauges]`.
    slow: Vec<f64>,
    /// Raw readings less what measured loads read `[n_gauges]`.
    net: Vec<f64>,
    n_slow: usize,
    /// Frames that baselines have not learned from yet `[lag_frames + 1][n_gauges + 2]`: raw values less drift, the
    /// temperature above the tare's, the time since the release.
    ring: Vec<f64>,
    ring_start: usize,
    ring_len: usize,
    /// Of the last contact: mean reading of each gauge, how long it took, how long ago, s.
    load: Vec<f64>,
    touched_s: f64,
    released_s: f64,
}

/// What a tare is compared with, and goes back to.
#[derive(Clone, Debug, Default)]
struct Before {
    zero: Option<(Vec<Tracker>, Drift, Option<f64>)>,
    /// Where nothing was tared before: the readings with which the first tare that was refused began.
    first: Option<Vec<f64>>,
}

impl Conditioner {
    /// A conditioner that starts by taring.
    ///
    /// # Errors
    /// [`InverseError`] for unusable parameters.
    pub fn new(params: ConditionerParams) -> Result<Self, InverseError> {
        params.check()?;
        let n = params.gauge_sd.len();
        let tracker = |&sd: &f64| Tracker::new(sd, params.temperature_sd, params.creep_sd);
        Ok(Self {
            trackers: params.gauge_sd.iter().map(tracker).collect(),
            watches: vec![Watch::new(); n],
            touch: TouchDetector::new(),
            drift: Drift::new(n, DriftLimits::new(&params), params.period_s),
            loads: LoadFit::new(&params.loads, &params.gauge_sd),
            is_taring: true,
            check: TareCheck::new(n, params.tare_frames, params.period_s),
            before: Before::default(),
            moved: Vec::new(),
            tare_temperature_k: None,
            slow: vec![0.0; n],
            net: vec![0.0; n],
            n_slow: 0,
            ring: vec![0.0; (params.lag_frames + 1) * (n + 2)],
            ring_start: 0,
            ring_len: 0,
            load: vec![0.0; n],
            touched_s: 0.0,
            released_s: 0.0,
            params,
        })
    }

    /// An output for [`Conditioner::step_into`].
    #[must_use]
    pub fn output(&self) -> Conditioned {
        let n = self.trackers.len();
        Conditioned {
            readings: vec![0.0; n],
            baseline_sd: vec![0.0; n],
            live: vec![true; n],
            is_mask_new: false,
            health: vec![GaugeHealth::Good; n],
            phase: TouchPhase::Taring,
            tare_end: None,
            drift: DriftState::Still,
        }
    }

    /// The next frames, untouched, are the new tare. What was learned of temperature and creep stays.
    pub fn tare(&mut self) {
        if !self.is_taring {
            let zero = (self.trackers.clone(), self.drift.clone(), self.tare_temperature_k);
            self.before = Before { zero: Some(zero), first: None };
        }
        self.begin_tare();
    }

    fn begin_tare(&mut self) {
        self.is_taring = true;
        self.check.start_over();
        self.start_over();
        self.tare_temperature_k = None;
    }

    fn start_over(&mut self) {
        (self.n_slow, self.ring_len) = (0, 0);
        self.slow.fill(0.0);
        self.touch = TouchDetector::new();
        (self.touched_s, self.released_s) = (0.0, 0.0);
    }

    /// Takes back the tare: the zero is the one before it, or the tare begins again where there was none.
    pub fn refuse_tare(&mut self) {
        match self.before.zero.take() {
            Some((trackers, drift, temperature_k)) => {
                (self.trackers, self.drift) = (trackers, drift);
                self.start_over();
                (self.is_taring, self.tare_temperature_k) = (false, temperature_k);
            }
            None => {
                self.before.first.get_or_insert_with(|| self.check.ends()[0].to_vec());
                self.begin_tare();
            }
        }
    }

    /// Whether the next frames are a tare.
    #[must_use]
    pub fn is_taring(&self) -> bool {
        self.is_taring
    }

    /// Standard deviation of each gauge's noise in a frame `[n_gauges]`.
    #[must_use]
    pub fn gauge_sd(&self) -> &[f64] {
        &self.params.gauge_sd
    }

    /// Whether there was a zero before the last tare.
    #[must_use]
    pub fn has_zero_before(&self) -> bool {
        self.before.zero.is_some()
    }

    /// What the readings of the last tare are above those that were untouched before it `[n_gauges]`: the zero
    /// before it, or how the first tare began that was refused; none after the first tare.
    #[must_use]
    pub fn tare_shift(&self) -> Option<Vec<f64>> {
        let zero = |(trackers, drift, _): &(Vec<Tracker>, Drift, Option<f64>)| {
            let zeros = trackers.iter().zip(&drift.offset);
            zeros.map(|(tracker, offset)| tracker.expected(0.0, 0.0) + offset).collect()
        };
        let before: Option<Vec<f64>> = match &self.before.zero {
            Some(before) => Some(zero(before)),
            None => self.before.first.clone(),
        };
        let pairs =
            |before: Vec<f64>| self.check.mean.iter().zip(before).map(|(m, b)| m - b).collect();
        before.map(pairs)
    }

    /// What of `moved` `[n_gauges]` drift does not explain that had `time_s` for it: all gauges together and one more
    /// than the others by any amount, as temperature and creep move them, and each in any direction as fast as it may.
    ///
    /// # Errors
    /// [`InverseError`] for a wrong length or a time that is not above 0.
    pub fn beyond_drift(&self, moved: &[f64], time_s: f64) -> Result<Vec<f64>, InverseError> {
        check_length("what moved", self.trackers.len(), moved.len())?;
        check_positive("the time to drift", time_s)?;
        let (mut sorted, mut beyond) = (moved.to_vec(), moved.to_vec());
        self.drift.limits.of_any_amount().beyond(moved, time_s, &mut sorted, &mut beyond);
        Ok(beyond)
    }

    /// How far the readings of the last tare that was refused for it moved from its beginning to its end
    /// `[n_gauges]`.
    #[must_use]
    pub fn tare_moved(&self) -> &[f64] {
        &self.moved
    }

    /// Moves the zero by `by` `[n_gauges]`, as by what is known to have pressed during the tare: nothing touches
    /// from now on.
    ///
    /// # Errors
    /// [`InverseError::Length`].
    pub fn shift(&mut self, by: &[f64]) -> Result<(), InverseError> {
        check_length("the shift", self.trackers.len(), by.len())?;
        self.trackers.iter_mut().zip(by).for_each(|(tracker, by)| tracker.shift(*by));
        self.start_over();
        Ok(())
    }

    /// Another standard deviation of the readings' noise `[n_gauges]`, as if it had been given at first.
    ///
    /// # Errors
    /// [`InverseError`] for a wrong length or a value that is not above 0.
    pub fn set_gauge_sd(&mut self, gauge_sd: &[f64]) -> Result<(), InverseError> {
        check_length("gauge_sd", self.trackers.len(), gauge_sd.len())?;
        for &sd in gauge_sd {
            check_positive("gauge_sd", sd)?;
        }
        self.params.gauge_sd.copy_from_slice(gauge_sd);
        let trackers = self.trackers.iter_mut().zip(gauge_sd);
        trackers.for_each(|(tracker, sd)| tracker.set_noise(*sd));
        self.loads.set_gauge_sd(gauge_sd);
        Ok(())
    }

    /// One frame of raw readings `[n_gauges]` with the temperature (K or °C) where there is a channel
    /// for it. Allocates nothing.
    ///
    /// # Errors
    /// [`InverseError::Length`]. Values that are not finite are masked, not refused.
    pub fn step_into(
        &mut self,
        raw: &[f64],
        temperature_k: Option<f64>,
        out: &mut Conditioned,
    ) -> Result<(), InverseError> {
        self.step_beside(raw, None, temperature_k, out)
    }

    /// The same with loads that are measured, whose part `of_loads` `[n_gauges]` of the readings is taken off; gauges
    /// are judged by what they read.
    ///
    /// # Errors
    /// As [`Conditioner::step_into`].
    pub fn step_beside(
        &mut self,
        raw: &[f64],
        of_loads: Option<&[f64]>,
        temperature_k: Option<f64>,
        out: &mut Conditioned,
    ) -> Result<(), InverseError> {
        let n = self.trackers.len();
        check_length("the raw readings", n, raw.len())?;
        check_length("what measured loads read", n, of_loads.map_or(n, <[f64]>::len))?;
        let mut net = std::mem::take(&mut self.net);
        net.copy_from_slice(raw);
        if let Some(of_loads) = of_loads {
            net.iter_mut().zip(of_loads).for_each(|(net, load)| *net -= load);
        }
        let stepped = self.step(raw, &net, temperature_k, out);
        self.net = net;
        stepped
    }

    /// A frame of readings `raw`, of which `net` are the loads' rest.
    fn step(
        &mut self,
        raw: &[f64],
        net: &[f64],
        temperature_k: Option<f64>,
        out: &mut Conditioned,
    ) -> Result<(), InverseError> {
        let n = self.trackers.len();
        check_length("the conditioned readings", n, out.readings.len())?;
        let temperature_k = temperature_k.filter(|t| t.is_finite());
        if self.tare_temperature_k.is_none() {
            self.tare_temperature_k = temperature_k;
        }
        let warmer_k = match (temperature_k, self.tare_temperature_k) {
            (Some(now), Some(then)) => now - then,
            _ => 0.0,
        };
        (out.tare_end, out.drift) = (None, DriftState::Still);
        if self.is_taring {
            self.add_to_tare(net, out);
            return Ok(());
        }
        self.drift.pass();
        self.take_off(net, warmer_k, out);
        find_faults(&mut self.watches, raw, &self.params, out);
        // contacts and zeros are judged by what loads leave
        self.loads.take_off(&mut out.readings, &out.live);
        let is_new = self.decide(out);
        self.follow(net, warmer_k, is_new, out);
        let is_touched = self.touch.is_touched;
        if let Some(moved) = self.drift.take(out, &self.params.gauge_sd, is_touched) {
            // as what is learned
            self.slow.iter_mut().zip(moved).for_each(|(slow, moved)| *slow -= moved);
        }
        if self.drift.was_drift {
            // nothing has touched since
            (self.touch, self.n_slow) = (TouchDetector::new(), 0);
            self.slow.fill(0.0);
        }
        self.loads.put_back(&mut out.readings, &out.live);
        out.drift = self.drift.state;
        out.phase = if self.touch.is_touched { TouchPhase::Touched } else { TouchPhase::Untouched };
        Ok(())
    }

    fn add_to_tare(&mut self, raw: &[f64], out: &mut Conditioned) {
        out.readings.fill(0.0);
        (out.phase, out.is_mask_new) = (TouchPhase::Taring, false);
        if raw.iter().any(|r| !r.is_finite()) {
            return;
        }
        if !self.check.take(raw) {
            return;
        }
        out.tare_end = Some(match self.check.judge(&self.params.gauge_sd, self.drift.limits) {
            Some(found) => TareEnd::Refused(found),
            None => TareEnd::Taken,
        });
        if out.tare_end != Some(TareEnd::Taken) {
            let [first, last] = self.check.ends();
            self.moved = last.iter().zip(first).map(|(last, first)| last - first).collect();
            self.refuse_tare();
            return;
        }
        self.is_taring = false;
        let n = self.params.tare_frames;
        for (tracker, mean) in self.trackers.iter_mut().zip(&self.check.mean) {
            tracker.tare(*mean, n);
        }
        self.drift.tare(&self.check, n as f64 * self.params.period_s);
    }

    /// ln of what a contact that lasted `touched_s` leaves `released_s` after it went, per unit of
    /// its reading and creep: logarithmic creep, superposed for load and release.
    fn recovery(&self, released_s: f64) -> f64 {
        let tau = self.params.creep_time_s;
        ((released_s + self.touched_s + tau) / (released_s + tau)).ln()
    }

    fn take_off(&mut self, raw: &[f64], warmer_k: f64, out: &mut Conditioned) {
        let walk = self.params.drift_sd.powi(2) * self.params.period_s;
        // of a contact that lasts what has crept so far, of one that has gone what is left of it
        let crept = if self.touch.is_touched {
            (1.0 + self.touched_s / self.params.creep_time_s).ln()
        } else {
            self.recovery(self.released_s)
        };
        for (gauge, tracker) in self.trackers.iter_mut().enumerate() {
            tracker.drift(walk);
            let creep = self.load[gauge] * crept;
            out.readings[gauge] =
                raw[gauge] - tracker.expected(warmer_k, creep) - self.drift.offset[gauge];
            let variance = tracker.variance(warmer_k, creep).max(0.0);
            out.baseline_sd[gauge] = (variance + self.drift.held.variance[gauge]).sqrt();
        }
    }

    /// Whether something began or ceased to touch.
    fn decide(&mut self, out: &Conditioned) -> bool {
        let (mut chi2, mut n_dof) = (0.0, 0);
        self.n_slow = (self.n_slow + 1).min(self.params.slow_frames);
        let gain = 1.0 / self.n_slow as f64;
        // variance of a mean, then of an exponential average
        let is_full = self.n_slow == self.params.slow_frames;
        let share = if is_full { gain / (2.0 - gain) } else { gain };
        for gauge in 0..out.readings.len() {
            if !out.live[gauge] {
                continue;
            }
            let noise = self.params.gauge_sd[gauge].powi(2);
            let baseline = out.baseline_sd[gauge].powi(2);
            let r = out.readings[gauge];
            self.slow[gauge] += gain * (r - self.slow[gauge]);
            chi2 += r * r / (noise + baseline);
            n_dof += 1;
        }
        let slow_variance = |gauge: usize| {
            self.params.gauge_sd[gauge].powi(2) * share + out.baseline_sd[gauge].powi(2)
        };
        let slow_chi2 = |slow: &[f64]| -> f64 {
            let live = (0..slow.len()).filter(|&gauge| out.live[gauge]);
            live.map(|gauge| slow[gauge].powi(2) / slow_variance(gauge)).sum()
        };
        let mut slow = slow_chi2(&self.slow);
        if upper_tail(slow, n_dof) < self.params.release_p {
            slow = slow_chi2(self.drift.beyond(&self.slow, DRIFT_S));
        }
        if upper_tail(chi2, n_dof) < self.params.touch_p {
            self.n_slow = 0;
        }
        self.touch.decide(chi2, slow, n_dof, &self.params)
    }

    /// Learns from an old frame while nothing touches; keeps the load while something does.
    fn follow(&mut self, raw: &[f64], warmer_k: f64, is_new: bool, out: &Conditioned) {
        let period_s = self.params.period_s;
        if self.touch.is_touched {
            if is_new {
                let recovery = self.recovery(self.released_s);
                for (tracker, load) in self.trackers.iter_mut().zip(&mut self.load) {
                    tracker.absorb(*load * recovery);
                    *load = 0.0;
                }
                (self.touched_s, self.ring_len) = (0.0, 0);
            }
            self.touched_s += period_s;
            let gain = period_s / self.touched_s;
            for gauge in 0..raw.len() {
                if out.live[gauge] {
                    self.load[gauge] += gain * (out.readings[gauge] - self.load[gauge]);
                }
            }
            self.released_s = 0.0;
            return;
        }
        if is_new {
            let quiet_s = period_s * self.params.release_frames as f64;
            self.touched_s = (self.touched_s - quiet_s).max(0.0);
            self.released_s = quiet_s;
        }
        self.released_s += period_s;
        let width = raw.len() + 2;
        let n_rows = self.ring.len() / width;
        let at = (self.ring_start + self.ring_len) % n_rows * width;
        let row = &mut self.ring[at..at + width];
        for gauge in 0..raw.len() {
            let free = raw[gauge] - self.drift.offset[gauge] - self.loads.explained[gauge];
            row[gauge] = if out.live[gauge] { free } else { f64::NAN };
        }
        row[raw.len()] = warmer_k;
        row[raw.len() + 1] = self.released_s;
        self.ring_len += 1;
        if self.ring_len == n_rows {
            let at = self.ring_start * width;
            let ring = std::mem::take(&mut self.ring);
            let row = &ring[at..at + width];
            self.learn(&row[..raw.len()], row[raw.len()], row[raw.len() + 1]);
            self.ring = ring;
            self.ring_start = (self.ring_start + 1) % n_rows;
            self.ring_len -= 1;
        }
    }

    fn learn(&mut self, raw: &[f64], warmer_k: f64, released_s: f64) {
        let recovery = self.recovery(released_s);
        for (gauge, tracker) in self.trackers.iter_mut().enumerate() {
            if raw[gauge].is_finite() {
                let creep = self.load[gauge] * recovery;
                let before = tracker.expected(warmer_k, creep);
                tracker.learn(raw[gauge], warmer_k, creep);
                // what is learned has been in the running mean's readings, too
                self.slow[gauge] -= tracker.expected(warmer_k, creep) - before;
            }
        }
    }
}
