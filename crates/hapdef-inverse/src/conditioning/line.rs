//! The line on which zeros drift.

use crate::chi_square::upper_tail;

/// Blocks over which misses are averaged. A drift of 1 noise per second is seen after 0.2 s.
const N_MISSES: usize = 8;

/// Misses less probable than this start a line anew, and slopes of a tare less probable than this are followed:
/// noise alone hardly does in hours, and where it does, a rate of hundredths of the noise is followed for a second.
pub(super) const MOVES_P: f64 = 1e-6;

/// A line forgets what is older than this many blocks, 10 s: drift by temperature bends within minutes.
const LONGEST_LINE: usize = 312;

/// Value and rate of each gauge by a line through all blocks since it was started anew: the expanding-memory
/// polynomial filter of degree 1 (Morrison, Introduction to Sequential Smoothing and Prediction, 1969).
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// Blocks that it is known from.
    pub(super) n: usize,
    /// Means of the last misses `[n_gauges]`.
    pub(super) misses: Vec<f64>,
    n_misses: usize,
}

impl Line {
    pub(super) fn new(n_gauges: usize) -> Self {
        Self { n: 0, misses: vec![0.0; n_gauges], n_misses: 0 }
    }

    pub(super) fn start_over(&mut self, n: usize) {
        (self.n, self.n_misses) = (n, 0);
        self.misses.fill(0.0);
    }

    /// Shares of a miss that value and rate, per block, take.
    pub(super) fn gains(&mut self) -> (f64, f64) {
        self.n = (self.n + 1).min(LONGEST_LINE);
        let n = self.n as f64;
        // one block says nothing of a rate
        let of_rate = if self.n > 1 { 6.0 / (n * (n + 1.0)) } else { 0.0 };
        (self.value_variance(), of_rate)
    }

    /// Averages `misses`; whether they are beyond noise of `noise.0` each about zeros known to `noise.1`,
    /// variances.
    pub(super) fn is_missed(
        &mut self,
        misses: &[f64],
        noise: impl Fn(usize) -> (f64, f64),
    ) -> bool {
        self.n_misses = (self.n_misses + 1).min(N_MISSES);
        let gain = 1.0 / self.n_misses as f64;
        let share = if self.n_misses == N_MISSES { gain / (2.0 - gain) } else { gain };
        // what a short line knows is itself as noisy as a miss
        let known = 1.0 + 4.0 / self.n.max(1) as f64;
        let (mut chi2, mut n_dof) = (0.0, 0);
        for (gauge, &miss) in misses.iter().enumerate() {
            if miss.is_finite() {
                self.misses[gauge] += gain * (miss - self.misses[gauge]);
                let (each, zero) = noise(gauge);
                chi2 += self.misses[gauge].powi(2) / (each * share * known + zero);
                n_dof += 1;
            }
        }
        self.n_misses > 2 && upper_tail(chi2, n_dof) < MOVES_P
    }

    /// Variance of the value at the line's end, from blocks of variance 1.
    pub(super) fn value_variance(&self) -> f64 {
        let n = self.n.max(1) as f64;
        2.0 * (2.0 * n - 1.0) / (n * (n + 1.0))
    }

    /// Variance of the rate, per block, from blocks of variance 1.
    pub(super) fn rate_variance(&self) -> f64 {
        let n = self.n.max(2) as f64;
        12.0 / (n * (n * n - 1.0))
    }
}
