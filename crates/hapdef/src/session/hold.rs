//! Whether a press is held still, and what the gauges read then.

/// When a press counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldParams {
    /// Frames after the first touch that don't count.
    pub settle_frames: usize,
    /// Frames whose mean is the reading.
    pub hold_frames: usize,
    /// Change of the readings from the first half to the second, relative to the readings, at which
    /// the press is not held still.
    pub steady: f64,
}

impl HoldParams {
    /// At `rate_hz`: 0.2 s to settle, 0.3 s held still to 2 %.
    #[must_use]
    pub fn at_rate(rate_hz: f64) -> Self {
        let frames = |seconds: f64| (seconds * rate_hz).round().max(2.0) as usize;
        Self { settle_frames: frames(0.2), hold_frames: frames(0.3), steady: 0.02 }
    }
}

/// The last frames of a press.
#[derive(Clone, Debug)]
pub(super) struct Hold {
    params: HoldParams,
    noise_ue: f64,
    n_gauges: usize,
    n_seen: usize,
    /// `[hold_frames, n_gauges]`, µε; the oldest is overwritten.
    ring: Vec<f64>,
}

impl Hold {
    pub(super) fn new(params: HoldParams, noise_ue: f64, n_gauges: usize) -> Self {
        Self {
            ring: vec![0.0; params.hold_frames.max(2) * n_gauges],
            params,
            noise_ue,
            n_gauges,
            n_seen: 0,
        }
    }

    pub(super) fn begin(&mut self) {
        self.n_seen = 0;
    }

    /// Takes a frame; the mean reading `[n_gauges]` once the press is held still.
    pub(super) fn take(&mut self, readings_ue: &[f64]) -> Option<Vec<f64>> {
        let n_held = self.ring.len() / self.n_gauges;
        let at = self.n_seen % n_held * self.n_gauges;
        self.ring[at..at + self.n_gauges].copy_from_slice(readings_ue);
        self.n_seen += 1;
        if self.n_seen < self.params.settle_frames + n_held {
            return None;
        }
        let half = n_held / 2;
        let oldest = self.n_seen % n_held;
        let mean = |from: usize, n: usize| -> Vec<f64> {
            let mut sum = vec![0.0; self.n_gauges];
            for k in from..from + n {
                let at = (oldest + k) % n_held * self.n_gauges;
                let row = &self.ring[at..at + self.n_gauges];
                sum.iter_mut().zip(row).for_each(|(s, r)| *s += r / n as f64);
            }
            sum
        };
        let (first, second) = (mean(0, half), mean(n_held - half, half));
        let changes = first.iter().zip(&second).map(|(a, b)| b - a);
        let whole = mean(0, n_held);
        // Noise alone changes a gauge's mean of n frames by σ √(2/n) from one half to the other.
        let by_noise = self.noise_ue * (2.0 * self.n_gauges as f64 / half as f64).sqrt();
        let limit = 3.0 * by_noise + self.params.steady * norm(whole.iter().copied());
        (norm(changes) <= limit).then_some(whole)
    }
}

pub(super) fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params() -> HoldParams {
        HoldParams { settle_frames: 10, hold_frames: 20, steady: 0.02 }
    }

    #[test]
    fn a_press_counts_when_it_has_settled_and_is_still() {
        let mut hold = Hold::new(params(), 0.1, 2);
        for i in 0..29 {
            assert_eq!(hold.take(&[100.0, -50.0]), None, "frame {i}");
        }
        let held = hold.take(&[100.0, -50.0]).unwrap();
        assert!((held[0] - 100.0).abs() < 1e-9 && (held[1] + 50.0).abs() < 1e-9);
    }

    #[test]
    fn a_press_that_grows_does_not_count_until_it_is_still() {
        let mut hold = Hold::new(params(), 0.1, 1);
        for i in 0..200 {
            assert_eq!(hold.take(&[100.0 + f64::from(i)]), None, "frame {i}");
        }
        let n_still = (1..40).find(|_| hold.take(&[300.0]).is_some());
        assert!(n_still.is_some_and(|n| n >= 10), "{n_still:?}");
    }
}
