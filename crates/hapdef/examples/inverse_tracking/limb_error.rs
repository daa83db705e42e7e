//! How the limb differs from its map: smoothly over the skin, as the noise model says.

use hapdef_inverse::{ResponseMap, SkinPoint};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Waves of a random field.
const N_WAVES: usize = 24;

/// Correlation length of the error, m.
const LENGTH_M: f64 = 0.015;

/// Random fields (Rahimi and Recht 2007), two for each gauge, of unit variance.
pub(crate) struct LimbError {
    relative: f64,
    scale_2: Vec<f64>,
    fields: Vec<Vec<(Vector3<f64>, f64)>>,
}

impl LimbError {
    pub(crate) fn draw(map: &ResponseMap, points: &[SkinPoint], relative: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut waves = Vec::new();
        for _ in 0..2 * map.n_gauges() * N_WAVES {
            waves.push(Vector3::new(normal(), normal(), normal()) / LENGTH_M);
        }
        let mut phase = || rng.random_range(0.0..std::f64::consts::TAU);
        let fields = waves
            .chunks(N_WAVES)
            .map(|waves| waves.iter().map(|w| (*w, phase())).collect())
            .collect();
        let mut scale_2 = vec![0.0; map.n_gauges()];
        for point in points {
            for (s, g) in scale_2.iter_mut().zip(map.normal(point)) {
                *s += g * g / points.len() as f64;
            }
        }
        Self { relative, scale_2, fields }
    }

    /// Readings per newton of the limb at `point`.
    pub(crate) fn response(&self, map: &ResponseMap, point: &SkinPoint) -> Vec<f64> {
        let mut response = map.normal(point);
        if self.relative == 0.0 {
            return response;
        }
        let x = map.skin().position(point);
        let field = |i: usize| -> f64 {
            let waves = self.fields[i].iter();
            let sum: f64 = waves.map(|(w, phase)| (w.dot(&x.coords) + phase).cos()).sum();
            sum * (2.0 / N_WAVES as f64).sqrt()
        };
        let n = response.len();
        let shares = response.iter().zip(&self.scale_2).map(|(g, s)| g * g / s);
        let q = shares.sum::<f64>() / n as f64;
        for (gauge, g) in response.iter_mut().enumerate() {
            let everywhere = (self.scale_2[gauge] * q).sqrt();
            let error = *g * field(2 * gauge) + everywhere * field(2 * gauge + 1);
            *g += self.relative * error / 2_f64.sqrt();
        }
        response
    }
}
