//! Presses that contradict those around them.

use crate::calibration::kernel::Kernel;
use crate::calibration::output::{RejectReason, RejectedPress};
use crate::calibration::residual::Wanted;
use crate::calibration::solution::Problem;
use crate::chi_square::tail_point;
use crate::error::InverseError;

/// Presses looked at together: time goes with the cube of their number, and a press is judged by those
/// near it.
const CHUNK: usize = 600;

/// Rounds of rejecting the worst, one press of each neighbourhood in each.
const MAX_ROUNDS: usize = 8;

/// Residuals of good presses have heavier tails than a Gaussian's: χ² counts as if the variances
/// were this many times larger. With `reject_p` of 1e-9 a press on ten gauges goes beyond a χ² of 380.
const TAIL: f64 = 6.0;

/// Median of χ²₁, the squared 0.75 quantile of the normal distribution.
const MEDIAN_CHI2: f64 = 0.454_94;

/// A rejected press clears those within this many correlation lengths for one round: it was among what
/// they were predicted from, and may be all that is wrong with them.
const REACH: f64 = 2.0;

/// The good ones of `rows`, in order; the others go to `rejected`. Presses are judged by their
/// leave-one-out residuals among some hundred others, the worst of each neighbourhood first.
pub(crate) fn reject(
    problem: &Problem<'_>,
    rows: &[usize],
    kernels: &[Kernel],
    reject_p: f64,
    rejected: &mut Vec<RejectedPress>,
) -> Result<Vec<usize>, InverseError> {
    let m = problem.samples.n_gauges();
    let limit = TAIL * tail_point(reject_p, m);
    let n_chunks = rows.len().div_ceil(CHUNK).max(1);
    let mut good = Vec::new();
    for chunk in rows.chunks(rows.len().div_ceil(n_chunks)) {
        let mut chunk = chunk.to_vec();
        for _ in 0..MAX_ROUNDS {
            let chi2 = chi2(problem, &chunk, kernels)?;
            let bad = worst(problem, &chunk, &chi2, limit, kernels);
            if bad.is_empty() || chunk.len() - bad.len() < 3 {
                break;
            }
            for &i in &bad {
                let chi2 = chi2[i];
                rejected.push(RejectedPress {
                    press: problem.samples.index[chunk[i]],
                    reason: RejectReason::Outlier { chi2, limit },
                });
            }
            let kept = (0..chunk.len()).filter(|i| !bad.contains(i));
            chunk = kept.map(|i| chunk[i]).collect();
        }
        good.extend(chunk);
    }
    Ok(good)
}

/// χ² of every press left out, each gauge in units of its median.
fn chi2(
    problem: &Problem<'_>,
    rows: &[usize],
    kernels: &[Kernel],
) -> Result<Vec<f64>, InverseError> {
    let solution = problem.solve(rows, kernels, Wanted::default())?;
    let mut chi2 = vec![0.0; rows.len()];
    for gauge in 0..problem.samples.n_gauges() {
        let left_out = solution.left_out(gauge);
        let pairs = left_out.error.iter().zip(&left_out.variance);
        let z_2: Vec<f64> = pairs.map(|(e, v)| e * e / v).collect();
        let mut sorted = z_2.clone();
        sorted.sort_by(f64::total_cmp);
        let scale = (sorted[sorted.len() / 2] / MEDIAN_CHI2).max(1.0);
        chi2.iter_mut().zip(z_2).for_each(|(sum, z_2)| *sum += z_2 / scale);
    }
    Ok(chi2)
}

/// Those beyond the limit that are the worst within reach.
fn worst(
    problem: &Problem<'_>,
    rows: &[usize],
    chi2: &[f64],
    limit: f64,
    kernels: &[Kernel],
) -> Vec<usize> {
    let at = |i: usize| problem.samples.places.positions[rows[i]];
    let longest_m = kernels.iter().map(|k| k.length_m).fold(0.0, f64::max);
    let mut beyond: Vec<usize> = (0..rows.len()).filter(|&i| chi2[i] > limit).collect();
    beyond.sort_by(|&a, &b| chi2[b].total_cmp(&chi2[a]));
    let mut chosen: Vec<usize> = Vec::new();
    for i in beyond {
        if chosen.iter().all(|&j| (at(i) - at(j)).norm() > REACH * longest_m) {
            chosen.push(i);
        }
    }
    chosen
}
