//! The kernel of each gauge's residual, by evidence.

use crate::calibration::kernel::Kernel;
use crate::calibration::params::CalibrationParams;
use crate::calibration::residual::log_evidence;
use crate::calibration::solution::{Problem, by_gauge};

/// Before any press is looked at.
pub(crate) const FIRST: Kernel =
    Kernel { length_m: 0.012, size: 0.2, floor: 0.03, steep_length_m: 0.005, steep_size: 0.05 };

/// Sizes and floors that are tried, of the map's own size: from half a percent to nearly all of it by
/// factors of two or so.
const SIZES: [f64; 8] = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8];
const FLOORS: [f64; 5] = [1e-4, 1e-3, 1e-2, 0.1, 1.0];
const STEEP_SIZES: [f64; 8] = [0.0, 0.01, 0.025, 0.05, 0.1, 0.2, 0.4, 0.8];

/// Rounds over the parameters.
const N_ROUNDS: usize = 2;

/// The most probable kernel of each gauge on a grid, one parameter at a time.
pub(crate) fn choose_kernels(
    problem: &Problem<'_>,
    rows: &[usize],
    params: &CalibrationParams,
) -> Vec<Kernel> {
    by_gauge(problem.samples.n_gauges(), problem.n_threads, |gauge| {
        let mean_square = problem.mean_squares[gauge];
        let rows = &informative(problem, gauge, rows, params.n_evidence);
        let evidence = |kernel: &Kernel| {
            log_evidence(problem.samples, gauge, rows, kernel, mean_square)
                .unwrap_or(f64::NEG_INFINITY)
        };
        let mut best = (f64::NEG_INFINITY, FIRST);
        for _ in 0..N_ROUNDS {
            let before = best.0;
            for (values, change) in steps(params) {
                let tried = values.iter().map(|value| change(best.1, *value));
                best = better(best, tried.collect(), &evidence);
            }
            if best.0 <= before {
                break;
            }
        }
        best.1
    })
}

/// Values that are tried, and the kernel with one.
type Step<'a> = (&'a [f64], fn(Kernel, f64) -> Kernel);

fn steps(params: &CalibrationParams) -> [Step<'_>; 5] {
    [
        (&params.lengths_m, |k, length_m| Kernel { length_m, ..k }),
        (&SIZES, |k, size| Kernel { size, ..k }),
        (&FLOORS, |k, floor| Kernel { floor, ..k }),
        (&STEEP_SIZES, |k, steep_size| Kernel { steep_size, ..k }),
        (&params.steep_lengths_m, |k, steep_length_m| Kernel { steep_length_m, ..k }),
    ]
}

/// `n` of the presses `rows` at most: half of them are the first ones, and half those where the gauge's
/// map varies most.
fn informative(problem: &Problem<'_>, gauge: usize, rows: &[usize], n: usize) -> Vec<usize> {
    let (first, others) = rows.split_at((n / 2).min(rows.len()));
    let mut others = others.to_vec();
    let variance = |row: &usize| problem.samples.places.around(*row, gauge).variance;
    others.sort_by(|a, b| variance(b).total_cmp(&variance(a)));
    others.truncate(n - n / 2);
    first.iter().copied().chain(others).collect()
}

fn better(
    best: (f64, Kernel),
    tried: Vec<Kernel>,
    evidence: &impl Fn(&Kernel) -> f64,
) -> (f64, Kernel) {
    tried.into_iter().fold(best, |best, kernel| {
        let found = evidence(&kernel);
        if found > best.0 { (found, kernel) } else { best }
    })
}
