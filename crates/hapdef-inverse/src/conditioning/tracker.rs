//! One gauge's baseline, temperature coefficient and creep as states of a Kalman filter.

/// States: baseline, per K of temperature, part of the reading that creeps per ln(1 + t/τ).
const N: usize = 3;

/// y = b + c (T − T₀) + k h + n (Kalman filter with a scalar measurement; Särkkä, Bayesian Filtering
/// and Smoothing, 2013, theorem 4.2).
#[derive(Clone, Debug)]
pub(crate) struct Tracker {
    state: [f64; N],
    covariance: [[f64; N]; N],
    noise: f64,
}

impl Tracker {
    pub(crate) fn new(sd: f64, temperature_sd: f64, creep_sd: f64) -> Self {
        let mut covariance = [[0.0; N]; N];
        covariance[1][1] = temperature_sd * temperature_sd;
        covariance[2][2] = creep_sd * creep_sd;
        Self { state: [0.0; N], covariance, noise: sd * sd }
    }

    /// The baseline is `mean` of `n` frames; what is known of temperature and creep stays.
    pub(crate) fn tare(&mut self, mean: f64, n: usize) {
        self.state[0] = mean;
        for i in 0..N {
            self.covariance[0][i] = 0.0;
            self.covariance[i][0] = 0.0;
        }
        self.covariance[0][0] = self.noise / n as f64;
    }

    /// The baseline is another.
    pub(crate) fn shift(&mut self, by: f64) {
        self.state[0] += by;
    }

    pub(crate) fn set_noise(&mut self, sd: f64) {
        self.noise = sd * sd;
    }

    /// Time passes: the baseline walks.
    pub(crate) fn drift(&mut self, variance: f64) {
        self.covariance[0][0] += variance;
    }

    /// What the gauge reads untouched at temperature `warmer_k` above the tare's with creep `creep`
    /// to come.
    pub(crate) fn expected(&self, warmer_k: f64, creep: f64) -> f64 {
        self.state[0] + self.state[1] * warmer_k + self.state[2] * creep
    }

    /// Variance of [`Tracker::expected`].
    pub(crate) fn variance(&self, warmer_k: f64, creep: f64) -> f64 {
        let h = [1.0, warmer_k, creep];
        let mut sum = 0.0;
        for i in 0..N {
            for j in 0..N {
                sum += h[i] * h[j] * self.covariance[i][j];
            }
        }
        sum
    }

    /// Learns from an untouched reading.
    pub(crate) fn learn(&mut self, reading: f64, warmer_k: f64, creep: f64) {
        let h = [1.0, warmer_k, creep];
        let s = self.variance(warmer_k, creep) + self.noise;
        let ph: [f64; N] =
            std::array::from_fn(|i| (0..N).map(|j| self.covariance[i][j] * h[j]).sum());
        let miss = reading - self.expected(warmer_k, creep);
        for i in 0..N {
            self.state[i] += ph[i] / s * miss;
            for j in 0..N {
                self.covariance[i][j] -= ph[i] * ph[j] / s;
            }
        }
    }

    /// What is left of a recovery becomes baseline.
    pub(crate) fn absorb(&mut self, creep: f64) {
        self.state[0] += self.state[2] * creep;
        self.covariance[0][0] += self.covariance[2][2] * creep * creep;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_learned_as_the_mean() {
        let mut tracker = Tracker::new(2.0, 0.0, 0.0);
        tracker.tare(1.0, 1);
        for y in [3.0, 5.0, 7.0] {
            tracker.learn(y, 0.0, 0.0);
        }
        assert!((tracker.expected(0.0, 0.0) - 4.0).abs() < 1e-12);
        assert!((tracker.variance(0.0, 0.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_slope_over_temperature_is_learned() {
        let mut tracker = Tracker::new(0.1, 10.0, 0.0);
        tracker.tare(0.0, 100);
        for i in 0..200 {
            let warmer_k = f64::from(i) * 0.02;
            tracker.learn(3.0 * warmer_k, warmer_k, 0.0);
        }
        let found = tracker.expected(10.0, 0.0);
        assert!((found - 30.0).abs() < 0.05, "{found}");
    }
}
