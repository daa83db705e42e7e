//! A map corrected by some of the presses, and its error.

use nalgebra::Point3;

use crate::calibration::kernel::{Amplitude, Around, Kernel};
use crate::calibration::params::CalibrationParams;
use crate::calibration::samples::{Basis, Places, Samples};
use crate::calibration::solution::{Problem, Solution, by_gauge};
use crate::calibration::spread::Spread;
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
    /// The map corrected by a solution, and its error.
    pub(crate) fn correct(&self, solution: Solution, kernels: &[Kernel]) -> Corrected {
        let residual = self.residuals(std::slice::from_ref(&solution), kernels);
        self.corrected(solution, &residual.concat())
    }

    /// The same for each of several solutions, whose maps are made at once.
    pub(crate) fn correct_each(
        &self,
        solutions: Vec<Solution>,
        kernels: &[Kernel],
    ) -> impl Iterator<Item = Corrected> {
        let residuals = self.residuals(&solutions, kernels);
        solutions.into_iter().zip(residuals).map(|(s, residual)| self.corrected(s, &residual))
    }

    fn corrected(&self, solution: Solution, residual: &[f64]) -> Corrected {
        let (basis, samples) = (self.basis, self.problem.samples);
        let map = basis.map.plus(&basis.terms(&solution.modes.theta), residual);
        let extra = interpolation_errors(&map, samples, &solution);
        let spread = Spread::new(&map, samples, &solution, &extra);
        let per_site = spread.covariances(samples, &solution, self.at_sites);
        Corrected { solution, map, spread, per_site }
    }

    /// Each solution's mean of the process where the map has values `[n_solutions][n_values, n_gauges]`. The
    /// covariances with the presses, which take longest, are the same for all solutions.
    fn residuals(&self, solutions: &[Solution], kernels: &[Kernel]) -> Vec<Vec<f64>> {
        let (nodes, around) = self.values;
        let (m, samples) = (self.basis.map.n_gauges(), self.problem.samples);
        let mut rows: Vec<usize> = solutions.iter().flat_map(|s| s.rows.iter().copied()).collect();
        rows.sort_unstable();
        rows.dedup();
        let places: Vec<Vec<usize>> = solutions
            .iter()
            .map(|s| s.rows.iter().map(|row| rows.partition_point(|other| other < row)).collect())
            .collect();
        let by_gauge = by_gauge(m, self.params.n_threads, |gauge| {
            let (kernel, mean_square) = (&kernels[gauge], self.problem.mean_squares[gauge]);
            let alphas: Vec<Vec<f64>> = solutions.iter().map(|s| s.alpha(gauge)).collect();
            let size = |&i: &usize| kernel.amplitude(samples.places.around(i, gauge), mean_square);
            let sizes: Vec<Amplitude> = rows.iter().map(size).collect();
            let mut covariances = vec![0.0; rows.len()];
            let mut means = Vec::with_capacity(nodes.len() * solutions.len());
            for (node, x) in nodes.iter().enumerate() {
                let size = kernel.amplitude(around[node * m + gauge], mean_square);
                for (place, &i) in rows.iter().enumerate() {
                    let distance_2 = (x - samples.places.positions[i]).norm_squared();
                    covariances[place] = kernel.covariance(size, sizes[place], distance_2);
                }
                means.extend(places.iter().zip(&alphas).map(|(places, alpha)| {
                    let terms = places.iter().zip(alpha).map(|(&p, alpha)| alpha * covariances[p]);
                    terms.sum::<f64>()
                }));
            }
            means
        });
        let of_solution = |k: usize| -> Vec<f64> {
            let value = |i: usize| by_gauge[i % m][i / m * solutions.len() + k];
            (0..nodes.len() * m).map(value).collect()
        };
        (0..solutions.len()).map(of_solution).collect()
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
