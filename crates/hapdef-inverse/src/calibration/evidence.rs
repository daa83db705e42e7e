//! The kernel of each gauge's residual, by evidence.

use crate::calibration::kernel::Kernel;
use crate::calibration::residual::log_evidence;
use crate::calibration::solution::{Problem, by_gauge};

/// Before any press is looked at.
pub(crate) const FIRST: Kernel = Kernel {
    length_m: 0.012,
    size: 0.2,
    floor: 0.03,
};

/// Sizes and floors that are tried.
const SIZES: [f64; 6] = [0.02, 0.05, 0.1, 0.2, 0.4, 0.8];
const FLOORS: [f64; 4] = [1e-3, 1e-2, 0.1, 1.0];

/// Rounds over the three parameters.
const N_ROUNDS: usize = 2;

/// The most probable kernel of each gauge on a grid, one parameter at a time.
pub(crate) fn choose_kernels(
    problem: &Problem<'_>,
    rows: &[usize],
    lengths_m: &[f64],
) -> Vec<Kernel> {
    by_gauge(problem.samples.n_gauges(), problem.n_threads, |gauge| {
        let mean_square = problem.mean_squares[gauge];
        let evidence = |kernel: &Kernel| {
            log_evidence(problem.samples, gauge, rows, kernel, mean_square)
                .unwrap_or(f64::NEG_INFINITY)
        };
        let mut best = (f64::NEG_INFINITY, FIRST);
        for _ in 0..N_ROUNDS {
            let before = best.0;
            let lengths = lengths_m
                .iter()
                .map(|&length_m| Kernel { length_m, ..best.1 });
            best = better(best, lengths.collect(), &evidence);
            let sizes = SIZES.iter().map(|&size| Kernel { size, ..best.1 });
            best = better(best, sizes.collect(), &evidence);
            let floors = FLOORS.iter().map(|&floor| Kernel { floor, ..best.1 });
            best = better(best, floors.collect(), &evidence);
            if best.0 <= before {
                break;
            }
        }
        best.1
    })
}

fn better(
    best: (f64, Kernel),
    tried: Vec<Kernel>,
    evidence: &impl Fn(&Kernel) -> f64,
) -> (f64, Kernel) {
    tried.into_iter().fold(best, |best, kernel| {
        let found = evidence(&kernel);
        if found > best.0 {
            (found, kernel)
        } else {
            best
        }
    })
}
