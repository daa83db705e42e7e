//! The noise of the gauges, measured while they are tared.

/// A measured standard deviation is larger than assumed if it exceeds that by so many times
/// its own standard deviation, 1/√(2(n − 1)) of it: one gauge in 740 by chance.
const SURE_SDS: f64 = 3.0;

/// Mean squares of the readings of a tare (Welford, Technometrics 4(3), 1962).
pub(super) struct TareNoise {
    /// Frames of a tare.
    n_wanted: usize,
    /// Assumed standard deviation `[n_gauges]`, µε.
    assumed_ue: Vec<f64>,
    n: usize,
    mean_ue: Vec<f64>,
    square_ue2: Vec<f64>,
    larger_ue: Vec<f64>,
}

impl TareNoise {
    pub(super) fn new(assumed_ue: Vec<f64>, n_wanted: usize) -> Self {
        let zeros = vec![0.0; assumed_ue.len()];
        Self {
            n_wanted,
            assumed_ue,
            n: 0,
            mean_ue: zeros.clone(),
            square_ue2: zeros.clone(),
            larger_ue: zeros,
        }
    }

    /// A new tare begins.
    pub(super) fn start_over(&mut self) {
        self.n = 0;
        self.mean_ue.fill(0.0);
        self.square_ue2.fill(0.0);
    }

    /// Takes a frame of a tare.
    pub(super) fn take(&mut self, raw_ue: &[f64]) {
        if self.n >= self.n_wanted || raw_ue.iter().any(|raw| !raw.is_finite()) {
            return;
        }
        self.n += 1;
        for (gauge, raw) in raw_ue.iter().enumerate() {
            let off = raw - self.mean_ue[gauge];
            self.mean_ue[gauge] += off / self.n as f64;
            self.square_ue2[gauge] += off * (raw - self.mean_ue[gauge]);
        }
    }

    /// Standard deviation of each gauge where it is surely larger than assumed, else 0 `[n_gauges]`, µε.
    pub(super) fn larger_ue(&mut self) -> &[f64] {
        let n_free = self.n.saturating_sub(1) as f64;
        let factor = 1.0 + SURE_SDS / (2.0 * n_free).sqrt();
        for (gauge, larger) in self.larger_ue.iter_mut().enumerate() {
            let sd = (self.square_ue2[gauge] / n_free).sqrt();
            let is_larger = n_free > 0.0 && sd > self.assumed_ue[gauge] * factor;
            *larger = if is_larger { sd } else { 0.0 };
        }
        &self.larger_ue
    }

    /// The smaller of `noise_ue`, the noise without the converter, and what the tare measured, of each
    /// gauge, µε.
    pub(super) fn least_ue(&self, noise_ue: f64) -> impl Iterator<Item = f64> + '_ {
        let n_free = self.n.saturating_sub(1).max(1) as f64;
        self.square_ue2.iter().map(move |square| (square / n_free).sqrt().min(noise_ue))
    }

    /// The larger of the assumed noise and `larger_ue` `[n_gauges]`, µε.
    pub(super) fn to_use_ue(&self) -> Vec<f64> {
        let pairs = self.assumed_ue.iter().zip(&self.larger_ue);
        pairs.map(|(assumed, larger)| assumed.max(*larger)).collect()
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn only_noise_that_is_surely_larger_is_taken() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut noise = TareNoise::new(vec![1.0, 1.0, 1.0], 400);
        for tare in 0..2 {
            noise.start_over();
            for i in 0..400 {
                let mut draw = |sd: f64| -> f64 {
                    let z: f64 = StandardNormal.sample(&mut rng);
                    300.0 + sd * z
                };
                let louder = if tare == 0 { 4.0 } else { 1.0 };
                let raw = [draw(1.0), draw(louder), draw(0.3)];
                noise.take(&[1.0, f64::NAN, 0.0]);
                noise.take(&raw);
                assert_eq!(noise.n, i + 1);
            }
            let larger = noise.larger_ue().to_vec();
            assert_eq!((larger[0], larger[2]), (0.0, 0.0));
            if tare == 0 {
                assert!((larger[1] - 4.0).abs() < 0.5, "{larger:?}");
                assert_eq!(noise.to_use_ue(), [1.0, larger[1], 1.0]);
            } else {
                assert_eq!(noise.to_use_ue(), [1.0; 3]);
            }
        }
    }
}
