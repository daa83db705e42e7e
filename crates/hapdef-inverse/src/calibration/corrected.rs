//! A map corrected by some of the presses, and its error.

use nalgebra::Point3;

use crate::calibration::kernel::{Amplitude, Around, Kernel};
use crate::calibration::params::CalibrationParams;
use crate::calibration::samples::{Basis, Places, Samples};
use crate::calibration::solution::{Problem, Solution, by_gauge};
use crate::calibration::spread::Spread;
use crate::error::InverseError;
use crate::response::ResponseMap;

/// What a correction starts from.
pub(crate) struct Given<'a> {
    pub(crate) basis: &'a Basis<'a>,
    pub(crate) problem: &'a Problem<'a>,
    /// Where the map has values, and the map around those `[n_values, n_gauges]`.
    pub(crate) values: &'a (Vec<Point3<f64>>, Vec<Around>),
    /// Scan sites, where the error is reported.
    pub(crate) at_sites: &'a Places,
    pub(crate) params: &'a CalibrationParams,
}

/// A corrected map.
pub(crate) struct Corrected {
    pub(crate) solution: Solution,
    pub(crate) map: ResponseMap,
    pub(crate) spread: Spread,
    /// Covariance of its error at each site `[n_sites, n_gauges, n_gauges]`.
    pub(crate) per_site: Vec<f64>,
}

impl Given<'_> {
    /// The map corrected by the presses `rows` of the samples; errors of later presses are predicted for the
    /// first `cuts` of them.
    pub(crate) fn correct(
        &self,
        rows: &[usize],
        kernels: &[Kernel],
        cuts: &[usize],
    ) -> Result<Corrected, InverseError> {
        let (basis, samples) = (self.basis, self.problem.samples);
        let solution = self.problem.solve(rows, kernels, Some(self.at_sites), cuts)?;
        let residual = self.nodal_residual(&solution, kernels);
        let map = basis.map.plus(&basis.terms(&solution.modes.theta), &residual);
        let extra = interpolation_errors(&map, samples, &solution);
        let spread = Spread::new(&map, samples, &solution, &extra);
        let per_site = spread.covariances(samples, &solution, self.at_sites);
        Ok(Corrected { solution, map, spread, per_site })
    }

    /// The process's mean where the map has values `[n_values, n_gauges]`.
    fn nodal_residual(&self, solution: &Solution, kernels: &[Kernel]) -> Vec<f64> {
        let (nodes, around) = self.values;
        let (m, samples) = (self.basis.map.n_gauges(), self.problem.samples);
        let by_gauge = by_gauge(m, self.params.n_threads, |gauge| {
            let (kernel, mean_square) = (&kernels[gauge], self.problem.mean_squares[gauge]);
            let alpha = solution.alpha(gauge);
            let rows = solution.rows.iter();
            let sizes =
                rows.map(|&i| kernel.amplitude(samples.places.around(i, gauge), mean_square));
            let sizes: Vec<Amplitude> = sizes.collect();
            let at = |(node, x): (usize, &Point3<f64>)| {
                let size = kernel.amplitude(around[node * m + gauge], mean_square);
                let correction = |(place, &i): (usize, &usize)| {
                    let distance_2 = (x - samples.places.positions[i]).norm_squared();
                    alpha[place] * kernel.covariance(size, sizes[place], distance_2)
                };
                solution.rows.iter().enumerate().map(correction).sum::<f64>()
            };
            nodes.iter().enumerate().map(at).collect::<Vec<f64>>()
        });
        let n_nodes = nodes.len();
        (0..n_nodes * m).map(|i| by_gauge[i % m][i / m]).collect()
    }
}

/// The process's mean at the presses less the interpolated map `[n, n_gauges]`.
fn interpolation_errors(map: &ResponseMap, samples: &Samples, solution: &Solution) -> Vec<f64> {
    let m = samples.n_gauges();
    let alphas: Vec<Vec<f64>> = (0..m).map(|gauge| solution.alpha(gauge)).collect();
    let mut extra = Vec::with_capacity(solution.rows.len() * m);
    for (place, &i) in solution.rows.iter().enumerate() {
        let found = map.normal(&samples.places.points[i]);
        for gauge in 0..m {
            let noise = samples.noise[i * m + gauge] * alphas[gauge][place];
            extra.push(samples.response[i * m + gauge] - noise - found[gauge]);
        }
    }
    extra
}
