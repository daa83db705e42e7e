//! Samples per second of a training.

use std::time::Instant;

/// Counts samples per second.
pub(super) struct Clock {
    batch: f64,
    start: Instant,
    n_steps: u64,
    window_start: Instant,
    window_steps: u64,
    rate: f64,
}

impl Clock {
    pub(super) fn start(batch: usize) -> Self {
        let now = Instant::now();
        Self {
            batch: batch as f64,
            start: now,
            n_steps: 0,
            window_start: now,
            window_steps: 0,
            rate: 0.0,
        }
    }

    /// Counts a step, and returns the rate of the last second or so.
    pub(super) fn tick(&mut self) -> f64 {
        self.n_steps += 1;
        self.window_steps += 1;
        let window_s = self.window_start.elapsed().as_secs_f64();
        if window_s > 1.0 || self.rate == 0.0 {
            self.rate = self.window_steps as f64 * self.batch / window_s.max(1e-9);
        }
        if window_s > 1.0 {
            (self.window_start, self.window_steps) = (Instant::now(), 0);
        }
        self.rate
    }

    pub(super) fn mean_rate(&self) -> f64 {
        self.n_steps as f64 * self.batch / self.elapsed_s().max(1e-9)
    }

    pub(super) fn elapsed_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}
