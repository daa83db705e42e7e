//! One factor for the map's error, from where left-out presses would have been found.

use nalgebra::{Matrix3, Vector3};

use crate::calibration::samples::Samples;
use crate::calibration::solution::Solution;
use crate::dense::{cholesky, solve_lower};
use crate::estimator::CHI2_95;
use crate::response::ResponseMap;

/// Share of the regions that are to hold the truth.
pub(crate) const SHARE: f64 = 0.95;

/// Factors that are tried, and halvings of the interval of their logarithm.
const FACTORS: [f64; 2] = [0.25, 64.0];
const N_HALVINGS: usize = 30;

/// A press as a contact that is looked for near its place on a map without it; all per newton.
pub(crate) struct LeftOutPress {
    /// Slopes of the response along the two tangents, per mm, and the response `[3][m]`.
    pub(crate) jacobian: [Vec<f64>; 3],
    /// Measured response less the map's `[m]`.
    pub(crate) error: Vec<f64>,
    /// Variance of the press's noise `[m]`.
    pub(crate) noise: Vec<f64>,
    /// Covariance of the map's error `[m, m]`.
    pub(crate) map_error: Vec<f64>,
}

impl LeftOutPress {
    /// The press at `place` of a solution, on the corrected map.
    pub(crate) fn new(
        map: &ResponseMap,
        samples: &Samples,
        solution: &Solution,
        place: usize,
        error: Vec<f64>,
        map_error: Vec<f64>,
    ) -> Self {
        let (i, m) = (solution.rows[place], samples.n_gauges());
        let point = &samples.places.points[i];
        let [along, across] = map.normal_gradient(point);
        let per_mm = |slope: Vec<f64>| slope.iter().map(|s| s * 1e-3).collect();
        Self {
            jacobian: [per_mm(along), per_mm(across), map.normal(point)],
            error,
            noise: samples.noise[i * m..(i + 1) * m].to_vec(),
            map_error,
        }
    }

    /// Squared distance of the place found from the true one in its own standard deviations, to
    /// first order, if the map's error were `factor` times as reported; none where the place is open.
    fn distance_2(&self, factor: f64) -> Option<f64> {
        let m = self.error.len();
        let mut s: Vec<f64> = self.map_error.iter().map(|c| factor * c).collect();
        (0..m).for_each(|i| s[i * m + i] += self.noise[i]);
        if !cholesky(&mut s, m, 0.0) {
            return None;
        }
        let whitened = |row: &Vec<f64>| {
            let mut row = row.clone();
            solve_lower(&s, m, &mut row);
            row
        };
        let rows = self.jacobian.each_ref().map(whitened);
        let error = whitened(&self.error);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let information = Matrix3::from_fn(|p, q| product(&rows[p], &rows[q]));
        let slope = Vector3::from_fn(|p, _| product(&rows[p], &error));
        let covariance = information.try_inverse()?;
        let off = (covariance * slope).fixed_rows::<2>(0).into_owned();
        let inverse = covariance.fixed_view::<2, 2>(0, 0).try_inverse()?;
        Some((off.transpose() * inverse * off)[(0, 0)])
    }
}

/// The least factor of the map's error with which 95 % of the presses would lie in the 95 % regions
/// of where they would have been found.
pub(crate) fn region_factor(presses: &[LeftOutPress]) -> f64 {
    let holds = |factor: f64| {
        let distances = presses.iter().filter_map(|press| press.distance_2(factor));
        let (inside, all) = distances
            .fold((0, 0), |(inside, all), d| (inside + usize::from(d <= CHI2_95), all + 1));
        f64::from(inside as u32) >= SHARE * f64::from(all)
    };
    let [mut low, mut high] = FACTORS.map(f64::ln);
    for _ in 0..N_HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle.exp()) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high.exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Presses whose errors are three times as large as reported: the factor is nine.
    #[test]
    fn a_variance_too_small_is_found() {
        let m = 6;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut normals = |sd: f64| -> Vec<f64> {
            let each = (0..m).map(|_| -> f64 { StandardNormal.sample(&mut rng) });
            each.map(|n| sd * n).collect()
        };
        let mut map_error = vec![0.0; m * m];
        (0..m).for_each(|g| map_error[g * m + g] = 1e-4);
        let presses: Vec<_> = (0..4000)
            .map(|_| LeftOutPress {
                jacobian: [normals(1.0), normals(1.0), normals(1.0)],
                error: normals(3e-2),
                noise: vec![1e-9; m],
                map_error: map_error.clone(),
            })
            .collect();
        let factor = region_factor(&presses);
        assert!((8.0..10.2).contains(&factor), "{factor}");
    }
}
