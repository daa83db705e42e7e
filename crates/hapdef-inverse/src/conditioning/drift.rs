//! Zeros that drift steadily, followed while nothing touches.

use crate::chi_square::upper_tail;
use crate::conditioning::conditioned::{Conditioned, DriftState};
use crate::conditioning::held::Held;
use crate::conditioning::limits::DriftLimits;
use crate::conditioning::line::{Line, MOVES_P};
use crate::conditioning::tare::TareCheck;

/// Running means are no contact that drift within its limits explains which began this long ago: it is seen and
/// followed after 0.2 s. Without it the first tenths of a second of each drift were contacts.
pub(crate) const DRIFT_S: f64 = 0.3;

/// Length of a block whose mean is one measurement, s.
const BLOCK_S: f64 = 0.032;

/// A rate that is as probable as this by noise alone is none …
const STANDS_P: f64 = 1e-2;

/// … once its line is this many blocks long.
const LEAST_LINE: usize = 16;

/// Blocks that a line is taken for that starts anew: its value follows at half of each miss.
const FRESH_LINE: usize = 4;

/// A zero may be moved so much faster than drift is allowed to be, to catch up with what was missed.
const CATCH_UP: f64 = 1.25;

/// Blocks in a row on one line from which it is sure how fast readings drift that are too fast, 2 s.
const SURE_LINE: usize = 62;

/// Drift may go unseen for so long, s, before something touches: that of one gauge alone is seen after 0.6 s.
const UNSEEN_S: f64 = 1.0;

/// Untouched for so many blocks, zeros are followed again.
const N_QUIET: usize = 32;

/// Gauges need not all have drifted for the same time: by this share of it each may differ. Temperature reaches
/// gauges within seconds of each other.
const APART: f64 = 0.25;

/// Zeros that drift steadily.
#[derive(Clone, Debug)]
pub(crate) struct Drift {
    pub(crate) limits: DriftLimits,
    period_s: f64,
    block: usize,
    line: Line,
    n_frames: usize,
    sums: Vec<f64>,
    counts: Vec<usize>,
    /// What the zero has drifted by, and how fast, per s `[n_gauges]`.
    pub(crate) offset: Vec<f64>,
    rate: Vec<f64>,
    /// What is not known of the zero since it was touched.
    pub(crate) held: Held,
    /// While touched: the readings' own line, which nothing is taken off by `[n_gauges]`.
    touched: [Vec<f64>; 2],
    was_touched: bool,
    /// Blocks that the zero's line is known from when it goes on after a contact.
    n_before: usize,
    /// Blocks in a row without a touch, and time since the zero was followed last, s.
    n_quiet: usize,
    away_s: f64,
    /// What touches has moved readings by more than zeros may have drifted since then.
    was_large: bool,
    /// What touched turned out to be drift in the last frame.
    pub(crate) was_drift: bool,
    pub(crate) state: DriftState,
    /// What is caught up with at once after a contact `[n_gauges]`.
    caught: Vec<f64>,
    beyond: Vec<f64>,
    /// What is asked whether drift explains it.
    seen: Vec<f64>,
    sorted: Vec<f64>,
}

impl Drift {
    pub(crate) fn new(n_gauges: usize, limits: DriftLimits, period_s: f64) -> Self {
        let zeros = || vec![0.0; n_gauges];
        Self {
            limits,
            period_s,
            block: (BLOCK_S / period_s).round().max(1.0) as usize,
            line: Line::new(n_gauges),
            n_frames: 0,
            sums: zeros(),
            counts: vec![0; n_gauges],
            offset: zeros(),
            rate: zeros(),
            held: Held::new(n_gauges),
            touched: [zeros(), zeros()],
            was_touched: false,
            n_before: LEAST_LINE,
            n_quiet: 0,
            away_s: 0.0,
            was_large: false,
            was_drift: false,
            state: DriftState::Still,
            caught: zeros(),
            beyond: zeros(),
            seen: zeros(),
            sorted: zeros(),
        }
    }

    /// The zero is that of a tare; where its slopes are surely not noise, it goes on at their rates.
    pub(crate) fn tare(&mut self, tare: &TareCheck, time_s: f64) {
        self.offset.fill(0.0);
        self.rate.fill(0.0);
        self.state = DriftState::Still;
        (self.was_touched, self.was_drift) = (false, false);
        (self.n_quiet, self.away_s, self.was_large) = (0, 0.0, false);
        self.held.start_over();
        self.start_block();
        self.line.start_over(0);
        let slopes = tare.slope.iter().zip(&tare.slope_sd);
        let chi2: f64 = slopes.map(|(slope, sd)| (slope / sd).powi(2)).sum();
        if tare.can_judge() && upper_tail(chi2, self.rate.len()) < MOVES_P {
            self.rate.copy_from_slice(&tare.slope);
            let rates = self.offset.iter_mut().zip(&tare.slope);
            rates.for_each(|(offset, slope)| *offset = 0.5 * time_s * slope);
            self.line.start_over(((time_s / self.block_s()) as usize).max(FRESH_LINE));
            self.state = DriftState::Followed;
        }
    }

    /// A frame passes.
    pub(crate) fn pass(&mut self) {
        if self.state == DriftState::Still {
            return;
        }
        for (offset, rate) in self.offset.iter_mut().zip(&self.rate) {
            *offset += rate * self.period_s;
        }
    }

    /// What of the running means `slow` is beyond a drift that began in the last `time_s`.
    pub(crate) fn beyond(&mut self, slow: &[f64], time_s: f64) -> &[f64] {
        self.limits.beyond(slow, time_s, &mut self.sorted, &mut self.beyond);
        &self.beyond
    }

    /// Takes what a frame leaves over the zero; by how much the zero was moved then, if it was `[n_gauges]`.
    /// `sd` is the noise of a frame.
    pub(crate) fn take(
        &mut self,
        left: &Conditioned,
        sd: &[f64],
        is_touched: bool,
    ) -> Option<&[f64]> {
        self.was_drift = false;
        if is_touched != self.was_touched {
            self.turn(is_touched, sd);
        }
        for gauge in 0..sd.len() {
            if left.live[gauge] {
                self.sums[gauge] += left.readings[gauge];
                self.counts[gauge] += 1;
            }
        }
        self.n_frames += 1;
        if self.n_frames < self.block {
            if self.state == DriftState::Unsure && self.n_frames.is_power_of_two() {
                self.look_early(sd);
            }
            return None;
        }
        for gauge in 0..sd.len() {
            let n = self.counts[gauge];
            // half a block of a gauge counts for none
            let is_enough = 2 * n > self.block;
            self.sums[gauge] = if is_enough { self.sums[gauge] / n as f64 } else { f64::NAN };
        }
        self.n_quiet = if is_touched { 0 } else { self.n_quiet + 1 };
        let is_away = self.n_quiet < N_QUIET;
        self.away_s = if is_away { self.away_s + self.block_s() } else { 0.0 };
        self.was_large &= is_away;
        if is_touched {
            self.watch(sd);
            self.go_on_if_drift(sd);
        } else {
            self.follow(sd, &left.baseline_sd);
        }
        self.start_block();
        (!is_touched).then_some(&self.beyond)
    }

    fn start_block(&mut self) {
        self.n_frames = 0;
        self.sums.fill(0.0);
        self.counts.fill(0);
    }

    fn block_s(&self) -> f64 {
        self.block as f64 * self.period_s
    }

    /// Something began or ceased to touch: the zero's line goes on where it was.
    fn turn(&mut self, is_touched: bool, sd: &[f64]) {
        self.was_touched = is_touched;
        self.start_block();
        if is_touched {
            self.touched.iter_mut().for_each(|line| line.fill(0.0));
            let is_followed = self.state != DriftState::Still;
            let of_rate = self.line.rate_variance() / self.block as f64 / self.block_s().powi(2);
            let most = self.limits.rate_variance();
            let variance = |sd: &f64| (of_rate * sd * sd).min(most);
            // one that stood still is taken to do so
            self.held.begin(sd.iter().map(|sd| if is_followed { variance(sd) } else { 0.0 }));
            let n_known = if is_followed { self.line.n } else { LEAST_LINE };
            self.n_before = n_known.clamp(FRESH_LINE, LEAST_LINE);
            self.line.start_over(0);
            if self.was_large {
                // what the last contact left has not been told yet
                self.state = DriftState::Unsure;
            }
        } else {
            // what it drifted meanwhile is known less well than before
            self.line.start_over(self.n_before);
            if matches!(self.state, DriftState::TooFast { .. } | DriftState::Unsure) {
                self.state = DriftState::Followed;
            }
        }
    }

    /// Moves the zero by what the block's mean leaves, within the limits.
    fn follow(&mut self, sd: &[f64], zero_sd: &[f64]) {
        let time_s = self.block_s();
        let n_block = self.block as f64;
        self.caught.fill(0.0);
        for (gauge, miss) in self.sums.iter_mut().enumerate() {
            let caught = self.held.learn(gauge, miss, sd[gauge].powi(2) / n_block);
            self.caught[gauge] = caught;
            self.offset[gauge] += caught;
        }
        let noise = |gauge: usize| (sd[gauge].powi(2) / n_block, zero_sd[gauge].powi(2));
        let is_missed = self.line.is_missed(&self.sums, noise);
        if is_missed {
            // once: again and again it would follow drift beyond the limits
            if self.state == DriftState::Still {
                self.catch_up();
            }
            self.line.start_over(FRESH_LINE);
            self.state = DriftState::Followed;
        } else if self.state == DriftState::Still {
            self.beyond.copy_from_slice(&self.caught);
            return;
        }
        let (of_value, of_rate) = self.line.gains();
        for gauge in 0..sd.len() {
            let miss = if self.sums[gauge].is_finite() { self.sums[gauge] } else { 0.0 };
            self.rate[gauge] += of_rate * miss / time_s;
            // the drift since the last block and what is caught up
            self.sums[gauge] = self.rate[gauge] * time_s + of_value * miss;
        }
        self.limits.beyond(&self.rate, 1.0, &mut self.sorted, &mut self.beyond);
        for (rate, beyond) in self.rate.iter_mut().zip(&self.beyond) {
            *rate -= beyond;
        }
        self.limits.beyond(&self.sums, CATCH_UP * time_s, &mut self.sorted, &mut self.beyond);
        for gauge in 0..sd.len() {
            let moved = self.sums[gauge] - self.beyond[gauge] - self.rate[gauge] * time_s;
            self.beyond[gauge] = moved + self.caught[gauge];
            self.offset[gauge] += moved;
        }
        self.stand(sd);
    }

    /// Moves the zero at once by what was missed before drift was seen: taken for its rate, it drove that to its limit,
    /// and a contact that came before it was right again left newtons when it went.
    fn catch_up(&mut self) {
        self.limits.beyond(&self.line.misses, DRIFT_S, &mut self.sorted, &mut self.beyond);
        for (gauge, miss) in self.sums.iter_mut().enumerate() {
            let moved = self.line.misses[gauge] - self.beyond[gauge];
            *miss -= moved;
            self.caught[gauge] += moved;
            self.offset[gauge] += moved;
        }
    }

    /// Ends following where the rates are no more than noise.
    fn stand(&mut self, sd: &[f64]) {
        if self.line.n < LEAST_LINE {
            return;
        }
        let scale = self.line.rate_variance() / self.block_s().powi(2);
        let each = self.rate.iter().zip(sd);
        let chi2: f64 =
            each.map(|(rate, sd)| (rate / sd).powi(2)).sum::<f64>() * self.block as f64 / scale;
        if upper_tail(chi2, sd.len()) > STANDS_P {
            self.rate.fill(0.0);
            self.state = DriftState::Still;
        }
    }

    /// After [`Drift::watch`]: takes what touches for drift, and follows it, where its line is that of zeros that began to drift while they
    /// were not followed: each gauge is where its rate, within the limits, brought it since then. A press that stands
    /// still has no rate, and one that creeps would have begun long before.
    fn go_on_if_drift(&mut self, sd: &[f64]) {
        let [_, rate] = &self.touched;
        let is_sure = self.line.n >= LEAST_LINE && self.rate_p(rate, sd) < MOVES_P;
        let is_within = self.rate_p(&self.beyond, sd) > STANDS_P;
        if !is_sure || !is_within || !self.is_since_away(sd) {
            self.doubt(sd);
            return;
        }
        for gauge in 0..sd.len() {
            self.offset[gauge] += self.touched[0][gauge];
            self.rate[gauge] += self.touched[1][gauge];
        }
        (self.was_touched, self.was_drift) = (false, true);
        self.state = DriftState::Followed;
        self.held.start_over();
        // its line goes on; its misses were those of another zero
        self.line.start_over(self.line.n);
    }

    /// Whether all gauges are where their rates brought them in one time since the zero was followed.
    fn is_since_away(&self, sd: &[f64]) -> bool {
        let [value, rate] = &self.touched;
        let n_block = self.block as f64;
        let of_value = self.line.value_variance() / n_block;
        let of_rate = self.line.rate_variance() / n_block / self.block_s().powi(2);
        let product = |a: &[f64], b: &[f64]| -> f64 {
            a.iter().zip(b).zip(sd).map(|((a, b), sd)| a * b / (sd * sd)).sum()
        };
        let time_s = product(value, rate) / product(rate, rate);
        let time_s = time_s.clamp(0.0, self.away_s + UNSEEN_S);
        let chi2: f64 = (0..sd.len())
            .map(|gauge| {
                let known = sd[gauge].powi(2) * (of_value + of_rate * time_s * time_s);
                let apart = APART * rate[gauge] * time_s;
                (value[gauge] - rate[gauge] * time_s).powi(2) / (known + apart * apart)
            })
            .sum();
        upper_tail(chi2, sd.len()) > STANDS_P
    }

    /// What is left after a contact is in doubt, while its line is short, where zeros may have drifted so far since they
    /// were followed.
    fn doubt(&mut self, sd: &[f64]) {
        self.seen.copy_from_slice(&self.touched[0]);
        let is_large = self.is_beyond_reach(sd, self.line.value_variance() / self.block as f64);
        self.was_large |= is_large;
        let is_open = self.line.n < SURE_LINE && !matches!(self.state, DriftState::TooFast { .. });
        if is_open && self.was_large && !is_large {
            self.state = DriftState::Unsure;
        }
    }

    /// Ends the doubt within a block, where its frames so far are more than drift: a press that came within a second of the
    /// last one was in doubt for 32 ms.
    fn look_early(&mut self, sd: &[f64]) {
        for (gauge, mean) in self.seen.iter_mut().enumerate() {
            let n = self.counts[gauge];
            *mean = if n > 0 { self.sums[gauge] / n as f64 } else { 0.0 };
        }
        if self.is_beyond_reach(sd, 1.0 / self.n_frames as f64) {
            let stands = self.rate.iter().all(|rate| *rate == 0.0);
            self.state = if stands { DriftState::Still } else { DriftState::Followed };
        }
    }

    /// Whether the readings `seen` are more than zeros may have drifted since they were followed, of a variance of so
    /// many times the noise's.
    fn is_beyond_reach(&mut self, sd: &[f64], variance: f64) -> bool {
        // the rate that the zero went on at may have been wrong by twice the limit
        let time_s = 2.0 * self.away_s + UNSEEN_S;
        self.limits.beyond(&self.seen, time_s, &mut self.sorted, &mut self.beyond);
        let chi2: f64 = self.beyond.iter().zip(sd).map(|(left, sd)| (left / sd).powi(2)).sum();
        upper_tail(chi2 / variance, sd.len()) < MOVES_P
    }

    /// The probability of such rates by noise alone.
    fn rate_p(&self, rate: &[f64], sd: &[f64]) -> f64 {
        let of_rate = self.line.rate_variance() / self.block as f64 / self.block_s().powi(2);
        let chi2: f64 = rate.iter().zip(sd).map(|(rate, sd)| (rate / sd).powi(2)).sum();
        upper_tail(chi2 / of_rate, sd.len())
    }

    /// Fits the line of readings that something touches, or that drift too fast.
    fn watch(&mut self, sd: &[f64]) {
        let time_s = self.block_s();
        let n_block = self.block as f64;
        self.held.pass(time_s, &self.rate);
        let [value, rate] = &mut self.touched;
        for gauge in 0..sd.len() {
            value[gauge] += rate[gauge] * time_s;
            self.sums[gauge] -= value[gauge];
        }
        if self.line.is_missed(&self.sums, |gauge| (sd[gauge].powi(2) / n_block, 0.0)) {
            self.line.start_over(0);
        }
        let (of_value, of_rate) = self.line.gains();
        for gauge in 0..sd.len() {
            if self.sums[gauge].is_finite() {
                value[gauge] += of_value * self.sums[gauge];
                rate[gauge] += of_rate * self.sums[gauge] / time_s;
            }
            // with that of the zero it is the drift of the raw readings
            self.sums[gauge] = rate[gauge] + self.rate[gauge];
        }
        self.limits.beyond(&self.sums, 1.0, &mut self.sorted, &mut self.beyond);
        let rate_sd = (self.line.rate_variance() / n_block).sqrt() / time_s;
        let beyond = |gauge: &usize| self.beyond[*gauge].abs() / (sd[*gauge] * rate_sd);
        let worst = (0..sd.len()).max_by(|a, b| beyond(a).total_cmp(&beyond(b)));
        let found = worst.filter(|gauge| self.line.n >= SURE_LINE && beyond(gauge) > 5.0);
        self.state = match found {
            Some(gauge) => DriftState::TooFast { gauge, rate: self.sums[gauge] },
            None if self.rate.iter().all(|rate| *rate == 0.0) => DriftState::Still,
            None => DriftState::Followed,
        };
    }
}
