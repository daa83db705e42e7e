//! The map's error at the scan sites, rescaled on left-out presses.

use nalgebra::Point3;

use crate::calibration::mode_fit::quadratic_form;
use crate::calibration::regions::{LeftOutPress, region_factor};
use crate::calibration::samples::{Places, Samples};
use crate::calibration::solution::{LeftOut, Solution};
use crate::response::ResponseMap;

/// Presses around a site whose errors count there: the process's own variance is the same everywhere but
/// for the map's size, and the error is not.
const N_AROUND: usize = 24;

/// Weight of the gauge's overall scale among them, half of theirs: the mean square of 24 errors alone
/// scatters by 29 %, which would make the map look sure in places by chance.
const N_OVERALL: f64 = 12.0;

/// Left-out errors with what scales their variances.
pub(crate) struct Spread {
    /// By gauge; errors of the interpolated map.
    pub(crate) left_out: Vec<LeftOut>,
    /// Factor of each gauge's variance `[n_gauges]`.
    pub(crate) scales: Vec<f64>,
    /// Mean square of the standardised error over the gauges, after that `[n]`.
    pub(crate) mean_square_z: Vec<f64>,
    /// Correlation of the standardised errors `[n_gauges, n_gauges]`.
    correlation: Vec<f64>,
}

impl Spread {
    /// `map` is the corrected one; `extra` `[n, n_gauges]` is what interpolation between its nodes
    /// adds to the errors.
    pub(crate) fn new(
        map: &ResponseMap,
        samples: &Samples,
        solution: &Solution,
        extra: &[f64],
    ) -> Self {
        let (n, m) = (solution.rows.len(), samples.n_gauges());
        let mut left_out: Vec<LeftOut> = (0..m).map(|g| solution.left_out(g)).collect();
        let mut scales = Vec::with_capacity(m);
        let mut z = vec![0.0; n * m];
        for (gauge, out) in left_out.iter_mut().enumerate() {
            for (i, error) in out.error.iter_mut().enumerate() {
                *error += extra[i * m + gauge];
            }
            let noise: Vec<f64> =
                solution.rows.iter().map(|&i| samples.noise[i * m + gauge]).collect();
            let scale = unit_scale(out, &noise);
            for i in 0..n {
                z[i * m + gauge] = out.error[i] / scaled(out.variance[i], noise[i], scale).sqrt();
            }
            scales.push(scale);
        }
        let square = |row: &[f64]| row.iter().map(|z| z * z).sum::<f64>() / m as f64;
        let mut spread = Self {
            mean_square_z: z.chunks_exact(m).map(square).collect(),
            correlation: correlation(&z, m),
            left_out,
            scales,
        };
        let factor = region_factor(&spread.presses(map, samples, solution));
        spread.scales.iter_mut().for_each(|scale| *scale *= factor);
        spread
    }

    fn presses(
        &self,
        map: &ResponseMap,
        samples: &Samples,
        solution: &Solution,
    ) -> Vec<LeftOutPress> {
        let m = samples.n_gauges();
        let press = |place: usize| {
            let i = solution.rows[place];
            let x = &samples.places.positions[i];
            let local = self.local_scale(samples, solution, x, Some(place));
            let sd: Vec<f64> = (0..m)
                .map(|gauge| {
                    let variance = self.left_out[gauge].variance[place];
                    let noise = samples.noise[i * m + gauge];
                    (local * self.scales[gauge] * without_noise(variance, noise)).sqrt()
                })
                .collect();
            let error = self.left_out.iter().map(|out| out.error[place]).collect();
            let map_error = self.covariance(&sd);
            LeftOutPress::new(map, samples, solution, place, error, map_error)
        };
        (0..solution.rows.len()).map(press).collect()
    }

    /// Covariance of standard deviations `sd` `[n_gauges]`.
    fn covariance(&self, sd: &[f64]) -> Vec<f64> {
        let m = sd.len();
        let entry = |k: usize| self.correlation[k] * sd[k / m] * sd[k % m];
        (0..m * m).map(entry).collect()
    }

    /// Covariance of the map's error at each site `[n_sites, n_gauges, n_gauges]`.
    pub(crate) fn covariances(
        &self,
        samples: &Samples,
        solution: &Solution,
        sites: &Places,
    ) -> Vec<f64> {
        let m = samples.n_gauges();
        let mut all = vec![0.0; sites.points.len() * m * m];
        for (site, out) in all.chunks_exact_mut(m * m).enumerate() {
            let local = self.local_scale(samples, solution, &sites.positions[site], None);
            let sd: Vec<f64> = (0..m)
                .map(|gauge| {
                    (self.scales[gauge] * local * variance_at(solution, gauge, site)).sqrt()
                })
                .collect();
            out.copy_from_slice(&self.covariance(&sd));
        }
        all
    }

    /// How much larger squared errors are around `x` than their variances say, the press at place
    /// `without` not looked at.
    fn local_scale(
        &self,
        samples: &Samples,
        solution: &Solution,
        x: &Point3<f64>,
        without: Option<usize>,
    ) -> f64 {
        let others = solution.rows.iter().enumerate();
        let mut near: Vec<(f64, usize)> = others
            .filter(|(i, _)| Some(*i) != without)
            .map(|(i, &row)| ((samples.places.positions[row] - x).norm_squared(), i))
            .collect();
        let n = N_AROUND.min(near.len());
        near.select_nth_unstable_by(n - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near[..n].sort_by_key(|a| a.1);
        let sum: f64 = near[..n].iter().map(|&(_, i)| self.mean_square_z[i]).sum();
        (N_OVERALL + sum) / (N_OVERALL + n as f64)
    }
}

/// Variance of the process and of the modes' coefficients at a site.
pub(crate) fn variance_at(solution: &Solution, gauge: usize, site: usize) -> f64 {
    let n_columns = solution.fits[gauge].rhs.len();
    solution.fits[gauge].at_sites.as_ref().map_or(0.0, |at| {
        let u = &at.columns[site * n_columns..(site + 1) * n_columns];
        at.variance[site] + quadratic_form(&solution.modes.covariance[gauge], u)
    })
}

/// The factor s with which Σ e² / (s v + noise) is the number of presses, by bisection.
fn unit_scale(out: &LeftOut, noise: &[f64]) -> f64 {
    let mean = |scale: f64| {
        let ratio = |i: usize| out.error[i].powi(2) / scaled(out.variance[i], noise[i], scale);
        (0..noise.len()).map(ratio).sum::<f64>() / noise.len() as f64
    };
    let (mut low, mut high) = (1e-3_f64.ln(), 1e4_f64.ln());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if mean(middle.exp()) > 1.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high.exp()
}

fn scaled(variance: f64, noise: f64, scale: f64) -> f64 {
    scale * without_noise(variance, noise) + noise
}

fn without_noise(variance: f64, noise: f64) -> f64 {
    (variance - noise).max(1e-6 * variance)
}

/// Correlation of the columns of `z` `[n, m]`, drawn a tenth towards none.
fn correlation(z: &[f64], m: usize) -> Vec<f64> {
    let mut sums = vec![0.0; m * m];
    for row in z.chunks_exact(m) {
        for i in 0..m {
            for j in 0..m {
                sums[i * m + j] += row[i] * row[j];
            }
        }
    }
    let mut out = vec![0.0; m * m];
    for i in 0..m {
        for j in 0..m {
            let size = (sums[i * m + i] * sums[j * m + j]).sqrt();
            let value = if size > 0.0 { 0.9 * sums[i * m + j] / size } else { 0.0 };
            out[i * m + j] = if i == j { 1.0 } else { value };
        }
    }
    out
}
