//! Operations and bytes of what the stages do, and the time they take on a machine.

use hapdef_inverse::Calibrated;
use hapdef_nets::{Activation, MlpSpec};
use hapdef_sim::FactorEstimate;

use super::Machine;
use crate::profile::Schedule;

/// What a step takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cost {
    /// Floating-point operations.
    pub(super) flops: f64,
    /// Bytes.
    pub(super) bytes: f64,
    /// Seconds, where a rule is known.
    pub(super) seconds: Option<f64>,
}

/// Looks at the validation set during a training, and samples of each.
const VALIDATED: f64 = 20.0 * 1000.0;

/// Layers up to so many parameters are too narrow to fill the processor.
const NARROW: usize = 2_000_000;

/// Right-hand sides that the first solve on a factor takes for itself, for its condition number.
pub(super) const CONDITION_LOADS: usize = 24;

/// Assembly, factor and the first `n_loads` solves, given together or few at a time, on a structure that
/// was ordered in `order_s` seconds.
pub(super) fn elastic(
    estimate: &FactorEstimate,
    n_loads: usize,
    order_s: f64,
    machine: &Machine,
) -> Cost {
    let seconds = order_s
        + estimate.n_elements as f64 / machine.elements_per_s
        + estimate.factor_flops / machine.factor_flops_per_s;
    let factored = Cost {
        flops: estimate.factor_flops,
        bytes: 8.0 * estimate.nnz_l as f64,
        seconds: (estimate.nnz_l > 0).then_some(seconds),
    };
    if n_loads == 0 {
        return factored;
    }
    let condition = solves(estimate, CONDITION_LOADS, machine);
    factored.plus(condition).plus(solves(estimate, n_loads, machine))
}

/// `n_loads` solves on a factor whose condition number is known. A solve passes L twice with two
/// operations an entry.
pub(super) fn solves(estimate: &FactorEstimate, n_loads: usize, machine: &Machine) -> Cost {
    let flops = 4.0 * estimate.nnz_l as f64 * n_loads as f64;
    let rate = if n_loads < Machine::MANY_LOADS {
        machine.few_solves_flops_per_s
    } else {
        machine.solve_flops_per_s
    };
    Cost { flops, bytes: 0.0, seconds: (estimate.nnz_l > 0).then_some(flops / rate) }
}

/// What a tip at each of `n_nodes` nodes of a skin averages over.
pub(super) fn tips(n_nodes: usize, machine: &Machine) -> Cost {
    Cost { flops: 0.0, bytes: 0.0, seconds: Some(n_nodes as f64 / machine.frame.tips_per_s) }
}

/// `n` samples of `n_contacts` at `n_nodes` nodes: three components of each contact's row are added,
/// and a magnitude taken.
pub(super) fn superposed(n: usize, n_contacts: usize, n_nodes: usize, machine: &Machine) -> Cost {
    let values = n as f64 * n_nodes as f64;
    let flops = values * (6.0 * n_contacts as f64 + 7.0);
    let seconds = flops / machine.superpose_flops_per_s;
    Cost { flops, bytes: 0.0, seconds: Some(seconds) }
}

/// Maps of `n` samples at `n_nodes` nodes told in `n_modes` modes: a product in 32 bits.
pub(super) fn projected(n: usize, n_nodes: usize, n_modes: usize, machine: &Machine) -> Cost {
    let flops = 2.0 * n as f64 * (n_nodes * n_modes) as f64;
    Cost { flops, bytes: 0.0, seconds: Some(flops / machine.train_flops_per_s) }
}

/// Training of a net: two operations a parameter and sample forward, four backward, and the looks at
/// the validation set.
pub(super) fn training(net: &MlpSpec, schedule: &Schedule, machine: &Machine) -> Cost {
    let p = net.n_parameters() as f64;
    let steps = 6.0 * p * (schedule.batch * schedule.steps) as f64;
    let looks = 2.0 * p * VALIDATED;
    let rate = if net.n_parameters() < NARROW {
        match net.activation {
            Activation::Tanh => machine.train_narrow_tanh_flops_per_s,
            Activation::Relu => machine.train_narrow_relu_flops_per_s,
        }
    } else {
        machine.train_flops_per_s
    };
    Cost { flops: steps + looks, bytes: 4.0 * p, seconds: Some((steps + looks) / rate) }
}

impl Cost {
    /// With so many more bytes written.
    pub(super) fn writing(self, bytes: f64, machine: &Machine) -> Self {
        Self {
            bytes: self.bytes + bytes,
            seconds: self.seconds.map(|s| s + bytes / machine.write_bytes_per_s),
            ..self
        }
    }

    /// One after the other.
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            flops: self.flops + other.flops,
            bytes: self.bytes + other.bytes,
            seconds: self.seconds.zip(other.seconds).map(|(a, b)| a + b),
        }
    }
}

/// Operations of the χ² test of a frame: whitening twice, and a sum of squares.
pub(super) fn test_flops(n_gauges: usize) -> f64 {
    (2 * n_gauges * n_gauges + 2 * n_gauges) as f64
}

/// Operations of the scan for one contact: a product of each site's row with the frame.
pub(super) fn scan_flops(n_gauges: usize, n_sites: usize) -> f64 {
    (2 * n_gauges * n_sites) as f64
}

/// Operations of the scan of all pairs of sites, ten for each.
pub(super) fn pairs_flops(n_sites: usize) -> f64 {
    (5 * n_sites * n_sites.saturating_sub(1)) as f64
}

/// Operations of `steps` of refinement: three rows of each contact, each put together from ten rows
/// of the map and whitened.
pub(super) fn refine_flops(n_gauges: usize, n_contacts: usize, steps: f64) -> f64 {
    let row = n_gauges * n_gauges + 20 * n_gauges;
    steps * (3 * n_contacts * row) as f64
}

/// Operations of a frame in which contacts are followed: one step for each of them.
pub(super) fn follow_flops(n_gauges: usize, n_contacts: usize) -> f64 {
    refine_flops(n_gauges, n_contacts, 1.0)
}

/// Presses at most that a kernel is chosen on, and that are fitted.
const MOST_FOR_KERNEL: usize = 600;
const MOST_FITTED: usize = 4000;

/// Kernels tried for each gauge, over all rounds.
const N_KERNELS: f64 = 60.0;

/// Operations of a calibration's fit to `n_presses` with `n_columns` modes: for every gauge the
/// kernels tried, each a factorisation; presses judged among some hundred others; the last solution
/// with the inverse's diagonal and what is known at the scan sites, and once more for every part of the
/// presses that is held out.
pub(super) fn fit_flops(
    n_presses: usize,
    n_gauges: usize,
    n_columns: usize,
    n_sites: usize,
) -> f64 {
    let n = n_presses.min(MOST_FITTED) as f64;
    let few = n.min(MOST_FOR_KERNEL as f64);
    let (columns, sites) = (n_columns as f64 + 1.0, n_sites as f64);
    let kernels = N_KERNELS * (few.powi(3) / 3.0 + few * few * columns);
    let judged = 2.0 * n * few * (few + columns);
    let solved = n.powi(3) + n * n * (columns + sites) + n * sites * sites;
    let n_solved = 1 + Calibrated::n_refits(n_presses.min(MOST_FITTED));
    n_gauges as f64 * (kernels + judged + n_solved as f64 * solved)
}
