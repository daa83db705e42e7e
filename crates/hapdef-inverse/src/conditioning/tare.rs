//! Whether the readings of a tare stand still.

use crate::conditioning::conditioned::{MoveKind, TareMove};
use crate::conditioning::limits::DriftLimits;

/// Parts whose means are compared.
const N_PARTS: usize = 8;

/// Frames without which movement can't be told from noise: a tare of fewer is taken as it comes.
const LEAST_FRAMES: usize = 32;

/// Standard deviations of a part's mean, or of the slope: one tare in 20,000 of ten gauges by chance. It also
/// has to move by more than one frame's noise, since converters and mains hum make parts differ by less.
const SURE_SDS: f64 = 5.0;

/// A gauge that never changes its value has this share of its assumed noise at least.
const LEAST_SHARE: f64 = 0.3;

/// Means and variances of a tare's parts.
#[derive(Clone, Debug)]
pub(crate) struct TareCheck {
    n_wanted: usize,
    period_s: f64,
    n: usize,
    /// Mean of each part `[N_PARTS][n_gauges]`, and mean squares about it `[n_gauges]`.
    means: Vec<f64>,
    counts: [usize; N_PARTS],
    squares: Vec<f64>,
    /// Of the whole `[n_gauges]`: mean, slope per s, standard deviation of the slope.
    pub(crate) mean: Vec<f64>,
    pub(crate) slope: Vec<f64>,
    pub(crate) slope_sd: Vec<f64>,
}

impl TareCheck {
    pub(crate) fn new(n_gauges: usize, n_wanted: usize, period_s: f64) -> Self {
        let zeros = || vec![0.0; n_gauges];
        Self {
            n_wanted,
            period_s,
            n: 0,
            means: vec![0.0; N_PARTS * n_gauges],
            counts: [0; N_PARTS],
            squares: zeros(),
            mean: zeros(),
            slope: zeros(),
            slope_sd: zeros(),
        }
    }

    pub(crate) fn start_over(&mut self) {
        self.n = 0;
        self.counts = [0; N_PARTS];
        for sums in [&mut self.means, &mut self.squares, &mut self.mean] {
            sums.fill(0.0);
        }
    }

    /// Takes a frame of finite readings; true with the last.
    pub(crate) fn take(&mut self, raw: &[f64]) -> bool {
        let part = (self.n * N_PARTS / self.n_wanted).min(N_PARTS - 1);
        (self.n, self.counts[part]) = (self.n + 1, self.counts[part] + 1);
        let n_gauges = raw.len();
        let means = &mut self.means[part * n_gauges..(part + 1) * n_gauges];
        for (gauge, raw) in raw.iter().enumerate() {
            let off = raw - means[gauge];
            means[gauge] += off / self.counts[part] as f64;
            self.squares[gauge] += off * (raw - means[gauge]);
            self.mean[gauge] += raw / self.n_wanted as f64;
        }
        self.n == self.n_wanted
    }

    /// Mean of the first part, and of the last `[n_gauges]`.
    pub(crate) fn ends(&self) -> [&[f64]; 2] {
        let n = self.mean.len();
        [&self.means[..n], &self.means[(N_PARTS - 1) * n..]]
    }

    pub(crate) fn can_judge(&self) -> bool {
        self.n_wanted >= LEAST_FRAMES
    }

    /// How the readings of a whole tare moved beyond noise and drift, if they did; fits the lines.
    pub(crate) fn judge(&mut self, gauge_sd: &[f64], limits: DriftLimits) -> Option<TareMove> {
        let n_gauges = self.mean.len();
        if !self.can_judge() {
            return None;
        }
        let time_s = self.n as f64 * self.period_s;
        let middles: [f64; N_PARTS] =
            std::array::from_fn(|k| ((k as f64 + 0.5) / N_PARTS as f64 - 0.5) * time_s);
        let spread: f64 = middles.iter().map(|t| t * t).sum();
        let mut worst: Option<(f64, TareMove)> = None;
        let mut keep = |excess: f64, found: TareMove| {
            if worst.is_none_or(|(before, _)| excess > before) {
                worst = Some((excess, found));
            }
        };
        for gauge in 0..n_gauges {
            let part = |k: usize| self.means[k * n_gauges + gauge];
            let n_free = (self.n - N_PARTS) as f64;
            let sd = (self.squares[gauge] / n_free).sqrt().max(LEAST_SHARE * gauge_sd[gauge]);
            let part_sd = sd / (self.n as f64 / N_PARTS as f64).sqrt();
            self.slope[gauge] = (0..N_PARTS).map(|k| middles[k] * part(k)).sum::<f64>() / spread;
            self.slope_sd[gauge] = part_sd / spread.sqrt();
            for (k, middle) in middles.iter().enumerate() {
                let by = part(k) - self.mean[gauge] - self.slope[gauge] * middle;
                if by.abs() > (SURE_SDS * part_sd).max(gauge_sd[gauge]) {
                    keep(by.abs(), TareMove { gauge, by, how: MoveKind::Jump });
                }
            }
        }
        let (mut sorted, mut beyond) = (vec![0.0; n_gauges], vec![0.0; n_gauges]);
        limits.beyond(&self.slope, 1.0, &mut sorted, &mut beyond);
        for gauge in 0..n_gauges {
            let (excess, by) = (beyond[gauge].abs(), self.slope[gauge] * time_s);
            if excess > SURE_SDS * self.slope_sd[gauge] && excess * time_s > gauge_sd[gauge] {
                keep(excess * time_s, TareMove { gauge, by, how: MoveKind::Trend });
            }
        }
        worst.map(|(_, found)| found)
    }
}
