//! Device time to host time.
//!
//! A packet arrives some delay after its sample instant, never before. So the least of arrival −
//! device time over a second is the best point of it (Olson, "A passive solution to the sensor
//! synchronization problem", IROS 2010); a line through the least of the last 20 seconds follows the
//! drift of the device's oscillator. Seconds are those of arrivals: what waited while the program was held
//! up arrives at once and is in one second with what comes after it, so that each second has a fast packet.

use std::collections::VecDeque;
use std::sync::OnceLock;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// At 40 ppm of drift, times of arrival scatter by 1102 µs (standard deviation) and a running minimum
/// by 1.3 µs; the least of each second with a line over 20 s leaves 0.3 µs.
const WINDOW_S: f64 = 1.0;
const N_WINDOWS: usize = 20;
/// An arrival that much before its time says that one of the clocks has jumped.
const EARLY_S: f64 = 2e-3;
/// A least delay that much above the line, twice in a row, says the same.
const LATE_S: f64 = 5e-3;

/// No oscillator is that far off: a line this steep was put through points from before and after a leap, and its
/// times were seconds off.
const MAX_SLOPE: f64 = 0.02;
/// A device's time that leaps by more than the host's while nothing is known of the delays has jumped: packets of
/// a backlog are a period apart, or as many as were lost.
const LEAP_US: i64 = 100_000;
/// Packets of one time for so long, and the clock is called stuck: a coarse one has a few of one time.
const STUCK_US: i64 = 100_000;
/// A clock is not believed that passes less than a third, or more than three times, of the host's time from the
/// fastest packet of one stretch of arrivals of this length to that of the next, twice in a row. A program that
/// was held up finds the fastest packet as fast as before.
const STRETCH_US: i64 = 300_000;

/// What is wrong with a device's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum ClockFault {
    #[error("it stands still")]
    Stuck,
    #[error("it has jumped")]
    Jumped,
    #[error("it passes less than a third or more than three times of the host's time")]
    Rate,
}

/// The host's two clocks; tests bring their own.
pub trait HostClock: Send + Sync {
    /// Monotonic time, ns, from any origin. Nothing sets this clock.
    fn now_ns(&self) -> u64;
    /// Time since 1970 UTC, ns. It may jump.
    fn wall_ns(&self) -> u64;
}

/// The clocks of the operating system. All of one process have the same origin.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemClock;

static ORIGIN: OnceLock<Instant> = OnceLock::new();

/// Maps the time of one device to the host's monotonic time.
#[derive(Clone, Debug, Default)]
pub struct ClockMap {
    origin: Option<(u64, u64)>,
    /// Least (x, y) of each window: device time and arrival − device time, both from the origin, s.
    minima: VecDeque<[f64; 2]>,
    current: Option<[f64; 2]>,
    /// Arrival from the origin at which the present window ends, s.
    window_end_s: f64,
    /// `y = line[0] + line[1] x`.
    line: [f64; 2],
    n_late: u32,
    last_ns: u64,
    n_jumps: u64,
    fault: Option<ClockFault>,
    seen: Seen,
}

/// What is remembered of the packets before, whether their times are believed or not.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Device time, µs, and arrival, ns, of the last packet.
    last: Option<(u64, u64)>,
    /// The stretch before the present one, and that one.
    stretches: [Option<Stretch>; 2],
    /// Stretches one after the other that were too slow, as negative, or too fast.
    n_odd: i8,
    /// How long the clock has stood still, µs.
    stuck_us: i64,
}

/// Packets that arrived in a time of at least [`STRETCH_US`].
#[derive(Clone, Copy, Debug)]
struct Stretch {
    begin_us: i64,
    length_us: i64,
    /// Least arrival − device time, µs.
    least_us: i64,
}

impl HostClock for SystemClock {
    fn now_ns(&self) -> u64 {
        let origin = ORIGIN.get_or_init(Instant::now);
        u64::try_from(origin.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    fn wall_ns(&self) -> u64 {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        since.map_or(0, |d| u64::try_from(d.as_nanos()).unwrap_or(u64::MAX))
    }
}

impl ClockMap {
    /// A map that knows nothing yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a packet's device time, µs, and its arrival, ns; returns the host time of that device
    /// time, ns. It never goes back, whatever the clocks do; where the device's clock is not believed
    /// it is the arrival, and [`Self::fault`] says why.
    pub fn map(&mut self, device_us: u64, arrival_ns: u64) -> u64 {
        self.fault = self.seen.judge(self.fault, self.minima.len() > 2, device_us, arrival_ns);
        match self.fault {
            Some(ClockFault::Stuck | ClockFault::Rate) => return self.forward(arrival_ns),
            Some(ClockFault::Jumped) => self.jumped(),
            None => {}
        }
        let (device_0, host_0) = *self.origin.get_or_insert((device_us, arrival_ns));
        let x = device_us.wrapping_sub(device_0).cast_signed() as f64 * 1e-6;
        let since = arrival_ns.wrapping_sub(host_0).cast_signed() as f64 * 1e-9;
        self.observe(x, since - x);
        if self.origin.is_none() {
            self.fault = Some(ClockFault::Jumped);
            self.start(device_us, arrival_ns);
            return self.forward(arrival_ns);
        }
        let mapped_s = x + self.line[0] + self.line[1] * x;
        let mapped = host_0.saturating_add_signed((mapped_s * 1e9).round() as i64);
        // A sample is never younger than its arrival.
        self.forward(mapped.min(arrival_ns))
    }

    /// The device started anew: its time begins again, the host's goes on.
    pub fn restart(&mut self) {
        *self = Self { last_ns: self.last_ns, n_jumps: self.n_jumps, ..Self::default() };
    }

    /// How much faster the device's clock runs than the host's, parts per million, as far as it is
    /// known.
    #[must_use]
    pub fn drift_ppm(&self) -> Option<f64> {
        (self.minima.len() > 2).then_some(-1e6 * self.line[1])
    }

    /// How far the least delays are from the line, root mean square with two degrees of freedom taken
    /// by the line, µs; as far as it is known.
    #[must_use]
    pub fn residual_us(&self) -> Option<f64> {
        let n_free = self.minima.len().checked_sub(2).filter(|n| *n > 0)?;
        let above = |p: &[f64; 2]| p[1] - self.line[0] - self.line[1] * p[0];
        let square: f64 = self.minima.iter().map(|p| above(p).powi(2)).sum();
        Some(1e6 * (square / n_free as f64).sqrt())
    }

    /// The last host time that it gave, ns.
    pub(crate) fn last_ns(&self) -> u64 {
        self.last_ns
    }

    /// Why the last packet's time was not believed, if it was not.
    #[must_use]
    pub fn fault(&self) -> Option<ClockFault> {
        self.fault
    }

    /// True where the clock has stood still for longer than a coarse one does between two of its steps.
    #[must_use]
    pub fn is_stuck(&self) -> bool {
        self.seen.stuck_us >= STUCK_US
    }

    /// How often one of the clocks jumped.
    #[must_use]
    pub fn n_jumps(&self) -> u64 {
        self.n_jumps
    }

    fn forward(&mut self, mapped_ns: u64) -> u64 {
        self.last_ns = self.last_ns.max(mapped_ns);
        self.last_ns
    }

    fn start(&mut self, device_us: u64, arrival_ns: u64) {
        self.origin = Some((device_us, arrival_ns));
        self.current = Some([0.0, 0.0]);
        self.window_end_s = WINDOW_S;
    }

    /// Takes a point; forgets everything, origin and all, if a clock has jumped.
    fn observe(&mut self, x: f64, y: f64) {
        let above = |line: [f64; 2], x: f64, y: f64| y - line[0] - line[1] * x;
        let is_first = self.current.is_none() && self.minima.is_empty();
        if is_first {
            (self.window_end_s, self.line) = (x + y + WINDOW_S, [y, 0.0]);
        }
        let height = above(self.line, x, y);
        let known = self.minima.len() > 2;
        if known && height < -EARLY_S {
            return self.jumped();
        }
        if x + y >= self.window_end_s {
            self.close_window(x + y);
            if self.n_late >= 2 || self.line[1].abs() > MAX_SLOPE {
                return self.jumped();
            }
        }
        let lower = |[cx, cy]: [f64; 2]| height < above(self.line, cx, cy);
        if self.current.is_none_or(lower) {
            self.current = Some([x, y]);
            if !known {
                self.line = [self.line[0] + height.min(0.0), self.line[1]];
            }
        }
    }

    fn close_window(&mut self, arrival_s: f64) {
        self.window_end_s = arrival_s + WINDOW_S;
        let Some([x, y]) = self.current.take() else {
            return;
        };
        let late = self.minima.len() > 2 && y - self.line[0] - self.line[1] * x > LATE_S;
        self.n_late = if late { self.n_late + 1 } else { 0 };
        if late {
            return;
        }
        self.minima.push_back([x, y]);
        if self.minima.len() > N_WINDOWS {
            self.minima.pop_front();
        }
        self.fit();
    }

    /// Least squares through the minima.
    fn fit(&mut self) {
        let n = self.minima.len() as f64;
        let mean = |k: usize| self.minima.iter().map(|p| p[k]).sum::<f64>() / n;
        let [mx, my] = [mean(0), mean(1)];
        let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
            self.minima.iter().map(|p| f(p[0] - mx, p[1] - my)).sum()
        };
        let sxx = sum(&|x, _| x * x);
        let slope = if sxx > 0.0 { sum(&|x, y| x * y) / sxx } else { 0.0 };
        self.line = [my - slope * mx, slope];
    }

    fn jumped(&mut self) {
        let (n_jumps, fault, seen) = (self.n_jumps + 1, self.fault, self.seen);
        self.restart();
        (self.n_jumps, self.fault, self.seen) = (n_jumps, fault, seen);
    }
}

impl Seen {
    /// What is wrong with a packet's time, going by those before it. `fault` is what was wrong with the last;
    /// where delays are known, a leap is seen by them.
    fn judge(
        &mut self,
        fault: Option<ClockFault>,
        are_delays_known: bool,
        device_us: u64,
        arrival_ns: u64,
    ) -> Option<ClockFault> {
        let arrival_us = (arrival_ns / 1000).cast_signed();
        self.weigh(arrival_us, arrival_us.wrapping_sub(device_us.cast_signed()));
        let (last_device_us, last_ns) = self.last.replace((device_us, arrival_ns))?;
        let step = device_us.wrapping_sub(last_device_us).cast_signed();
        let passed = arrival_ns.wrapping_sub(last_ns).cast_signed() / 1000;
        if step == 0 {
            self.stuck_us = self.stuck_us.saturating_add(passed);
            return Some(ClockFault::Stuck);
        }
        let was_stuck = std::mem::take(&mut self.stuck_us) >= STUCK_US;
        if self.n_odd.abs() >= 2 {
            return Some(ClockFault::Rate);
        }
        let leaps = !are_delays_known && step > passed.saturating_add(LEAP_US);
        let is_back = was_stuck || fault == Some(ClockFault::Rate);
        (step < 0 || leaps || is_back).then_some(ClockFault::Jumped)
    }

    /// Adds a packet to the present stretch, or ends that and compares it with the one before.
    fn weigh(&mut self, arrival_us: i64, delay_us: i64) {
        let [before, current] = &mut self.stretches;
        if let Some(current) = current {
            current.length_us = arrival_us.wrapping_sub(current.begin_us);
            if current.length_us < STRETCH_US {
                current.least_us = current.least_us.min(delay_us);
                return;
            }
            if let Some(before) = before {
                let rise_us = current.least_us.wrapping_sub(before.least_us);
                let length_us = current.length_us.max(before.length_us);
                let odd =
                    i8::from(rise_us / 2 < -length_us) - i8::from(rise_us / 2 > length_us / 3);
                let goes_on = self.n_odd.signum() == odd;
                self.n_odd = if goes_on { self.n_odd.saturating_add(odd) } else { odd };
            }
        }
        *before = *current;
        *current = Some(Stretch { begin_us: arrival_us, length_us: 0, least_us: delay_us });
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;

    /// Delay of a packet: 150 µs and an exponential part of 1 ms.
    fn delay_ns(rng: &mut ChaCha8Rng) -> f64 {
        let u = ((rng.next_u64() >> 11) as f64 + 0.5) * 0.5f64.powi(53);
        150e3 - 1e6 * u.ln()
    }

    /// Errors of the mapped time at 1 kHz from `from_s` to `to_s`, ns.
    fn errors(drift_ppm: f64, from_s: u64, to_s: u64, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut map = ClockMap::new();
        let mut last = 0;
        let mut errors = Vec::new();
        let mut last_arrival = 0.0f64;
        for i in 0..to_s * 1000 {
            let true_ns = 1e12 + i as f64 * 1e6;
            let device_us = 5_000_000 + (i as f64 * 1e3 * (1.0 + drift_ppm * 1e-6)).round() as u64;
            last_arrival = last_arrival.max(true_ns + delay_ns(&mut rng));
            let mapped = map.map(device_us, last_arrival as u64);
            assert!(mapped >= last, "{mapped} after {last}");
            last = mapped;
            if i >= from_s * 1000 {
                errors.push(mapped as f64 - true_ns);
            }
        }
        let residual_us = map.residual_us().unwrap();
        // Once every window is from after the drift was known: the least of 1,000 exponential delays
        // of 1 ms is exponential with 1 µs, and times are whole µs.
        if to_s > 30 {
            assert!((0.4..4.0).contains(&residual_us), "{residual_us} µs");
        }
        let found = map.drift_ppm().unwrap();
        assert!((found - drift_ppm).abs() < 5.0, "{found} for {drift_ppm}");
        errors
    }

    fn mean_and_sd(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        (mean, (square / n).sqrt())
    }

    #[test]
    fn twenty_microseconds_after_five_seconds() {
        for (drift_ppm, seed) in [(100.0, 1), (-100.0, 2), (40.0, 3), (0.0, 4)] {
            for (from_s, to_s) in [(5, 10), (5, 60), (40, 60)] {
                let (mean, sd) = mean_and_sd(&errors(drift_ppm, from_s, to_s, seed));
                println!("{drift_ppm} ppm, {from_s} to {to_s} s: mean {mean:.0} sd {sd:.0} ns");
                assert!(sd <= 20e3, "{sd} ns");
                // The shortest delay stays in.
                assert!((mean - 150e3).abs() < 50e3, "{mean} ns");
            }
        }
    }

    #[test]
    fn clocks_that_jump_are_noticed_and_time_never_goes_back() {
        for jump_us in [3_600_000_000i64, -3_600_000_000, 20_000, -20_000] {
            let mut rng = ChaCha8Rng::seed_from_u64(9);
            let mut map = ClockMap::new();
            let (mut last, mut worst) = (0, 0.0f64);
            for i in 0..60_000u64 {
                let jump = if i > 20_000 { jump_us } else { 0 };
                let device_us = (10_000_000_000 + i * 1000).saturating_add_signed(jump);
                let true_ns = (i * 1_000_000) as f64;
                let mapped = map.map(device_us, (true_ns + delay_ns(&mut rng)) as u64);
                assert!(mapped >= last);
                last = mapped;
                if i > 30_000 {
                    worst = worst.max((mapped as f64 - true_ns - 150e3).abs());
                }
            }
            assert_eq!(map.n_jumps(), 1, "{jump_us}");
            assert!(worst < 300e3, "{jump_us}: {worst} ns");
        }
    }

    #[test]
    fn the_systems_clocks_run() {
        let clock = SystemClock;
        let before = clock.now_ns();
        assert!(clock.now_ns() >= before && clock.wall_ns() > 1_700_000_000_000_000_000);
    }
}
