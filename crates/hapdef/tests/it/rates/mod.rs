//! A machine for plans of which no test looks at the times.

use hapdef::plan::{FrameRates, Machine};

/// Rates that no test looks at.
pub const MACHINE: Machine = Machine {
    threads: 2,
    elements_per_s: 1e5,
    factor_flops_per_s: 1e10,
    solve_flops_per_s: 1e10,
    few_solves_flops_per_s: 1e9,
    train_flops_per_s: 1e10,
    train_narrow_tanh_flops_per_s: 1e10,
    train_narrow_relu_flops_per_s: 1e10,
    superpose_flops_per_s: 1e9,
    pass_flops_per_s: 1e9,
    kmax_nodes_per_s: 1e7,
    write_bytes_per_s: 1e8,
    read_bytes_per_s: 1e8,
    frame: FrameRates {
        test_flops_per_s: 1e9,
        scan_flops_per_s: 1e9,
        pairs_flops_per_s: 1e9,
        single_flops_per_s: 1e9,
        pair_flops_per_s: 1e9,
        single_steps: 200.0,
        pair_steps: 2000.0,
        follow_flops_per_s: 1e9,
        fit_flops_per_s: 1e9,
        tips_per_s: 1e4,
    },
};
