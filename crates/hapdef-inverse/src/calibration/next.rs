//! Where further presses help most.

use crate::calibration::output::NextPress;
use crate::calibration::samples::Places;
use crate::calibration::solution::{Problem, Solution};
use crate::calibration::spread::variance_at;

/// Sites of the greatest variance, summed over the gauges relative to their typical response, each
/// once the presses before it are made (pivoted Cholesky of the posterior covariance).
pub(crate) fn next_presses(
    problem: &Problem<'_>,
    solution: &Solution,
    sites: &Places,
    scales: &[f64],
    n_next: usize,
) -> Vec<NextPress> {
    if n_next == 0 {
        return Vec::new();
    }
    let n = sites.points.len();
    let m = scales.len();
    let mut covariance = vec![0.0; n * n];
    for (gauge, fit) in solution.fits.iter().enumerate() {
        let Some(at) = &fit.at_sites else {
            continue;
        };
        let weight = scales[gauge] / (problem.mean_squares[gauge] * m as f64);
        for s in 0..n {
            for r in 0..s {
                covariance[s * n + r] += weight * at.covariance[s * n + r];
            }
            covariance[s * n + s] += weight * variance_at(solution, gauge, s);
        }
    }
    let mut left: Vec<f64> = (0..n).map(|s| covariance[s * n + s]).collect();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut next = Vec::new();
    while next.len() < n_next.min(n) {
        let Some(site) = (0..n).max_by(|&a, &b| left[a].total_cmp(&left[b]).then(b.cmp(&a))) else {
            break;
        };
        let variance = left[site];
        if variance <= 0.0 {
            break;
        }
        next.push(NextPress {
            point: sites.points[site],
            position_m: sites.positions[site],
            relative_sd: variance.sqrt(),
        });
        let column: Vec<f64> = (0..n)
            .map(|s| {
                let known: f64 = columns.iter().map(|c| c[s] * c[site]).sum();
                (covariance[s.max(site) * n + s.min(site)] - known) / variance.sqrt()
            })
            .collect();
        left.iter_mut().zip(&column).for_each(|(v, c)| *v -= c * c);
        left[site] = 0.0;
        columns.push(column);
    }
    next
}
