//! A smooth random field in space.

use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::params::VariationParams;

/// Waves summed; enough for the field to look Gaussian at any one place.
const N_WAVES: usize = 64;

/// A stationary random field with a Gaussian correlation, as a sum of random Fourier features
/// (Rahimi & Recht, "Random Features for Large-Scale Kernel Machines", NIPS 2007, algorithm 1).
#[derive(Clone, Debug)]
pub struct SmoothField {
    waves: Vec<(Vector3<f64>, f64)>,
}

impl SmoothField {
    /// Draws the field of the given correlation length from `seed`.
    #[must_use]
    pub fn new(correlation_length_m: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut wave = || {
            let k = Vector3::from_fn(|_, _| normal(&mut rng)) / correlation_length_m;
            (k, rng.random_range(0.0..std::f64::consts::TAU))
        };
        Self { waves: (0..N_WAVES).map(|_| wave()).collect() }
    }

    /// The field's value at `x`, of about unit variance.
    #[must_use]
    pub fn at(&self, x: &Point3<f64>) -> f64 {
        let sum: f64 = self.waves.iter().map(|(k, phase)| (k.dot(&x.coords) + phase).cos()).sum();
        sum * (2.0 / N_WAVES as f64).sqrt()
    }

    /// Values at `points` `[n]`, scaled so that the largest magnitude among them is
    /// `params.fraction`.
    #[must_use]
    pub fn scaled(params: &VariationParams, points: &[Point3<f64>]) -> Vec<f64> {
        let field = Self::new(params.correlation_length_m, params.seed);
        let raw: Vec<f64> = points.iter().map(|x| field.at(x)).collect();
        let largest = raw.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if largest == 0.0 {
            return raw;
        }
        raw.iter().map(|v| v / largest * params.fraction).collect()
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<Point3<f64>> {
        (0..400).map(|i| Point3::new(f64::from(i) * 1e-3, 0.02, -0.01)).collect()
    }

    #[test]
    fn the_largest_value_is_the_fraction() {
        let params = VariationParams { fraction: 0.1, correlation_length_m: 0.03, seed: 3 };
        let values = SmoothField::scaled(&params, &points());
        let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!((largest - 0.1).abs() < 1e-15, "largest {largest}");
    }

    #[test]
    fn neighbours_agree_and_distant_points_do_not() {
        let params = VariationParams { fraction: 1.0, correlation_length_m: 0.03, seed: 4 };
        let values = SmoothField::scaled(&params, &points());
        let step = values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        assert!(step < 0.1, "1 mm apart the field jumps by {step}");
        let low = values.iter().fold(f64::MAX, |m, v| m.min(*v));
        assert!(low < 0.0, "the field has one sign: lowest {low}");
    }

    #[test]
    fn seeds_decide_the_field() {
        let at = |seed| SmoothField::new(0.02, seed).at(&Point3::new(0.01, 0.02, 0.03));
        assert_eq!(at(1).to_bits(), at(1).to_bits());
        assert!((at(1) - at(2)).abs() > 1e-6);
    }
}
