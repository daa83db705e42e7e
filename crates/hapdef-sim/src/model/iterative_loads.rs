//! Loads through the iterative solver, block by block.

use std::time::Instant;

use crate::factor::panel::Columns;
use crate::iterative::{Iterative, Measure, Reached, WIDEST};
use crate::model::solve_info::check_forward_error;
use crate::model::solved_block::{SolvedBlock, unknown_forces};
use crate::supports::unknowns::Unknowns;
use crate::{ElasticModel, NodalLoad, SimError, SolveInfo, SolveParams};

/// As `solve_all` in `solve.rs`, for loads that are checked.
pub(crate) fn solve_loads<T: Send>(
    model: &ElasticModel,
    iterative: &Iterative,
    loads: &[NodalLoad],
    params: &SolveParams,
    harvest: impl Fn(&SolvedBlock<'_>) -> T + Sync,
    mut sink: impl FnMut(&[usize], T),
) -> Result<SolveInfo, SimError> {
    let started = Instant::now();
    let unknowns = &model.structure.unknowns;
    let n = 3 * unknowns.n_places();
    let measure = iterative.measure(model.scaled_norm, params);
    let sequence: Vec<usize> = (0..loads.len()).collect();
    let mut info = SolveInfo::new(loads.len());
    for block in sequence.chunks(WIDEST) {
        let k = block.len();
        let mut x = vec![0.0; n * k];
        add_loads(&mut x, loads, block, unknowns);
        let (harvested, reached) = model.pool.install(|| {
            let reached = iterative.solve(&mut x, k, &measure);
            let solved = columns(&x, k);
            (harvest(&SolvedBlock::new(unknowns, block, &solved)), reached)
        });
        for (&load, reached) in block.iter().zip(&reached) {
            check(load, reached, &measure)?;
            take(&mut info, load, reached);
        }
        sink(block, harvested);
    }
    if !loads.is_empty() {
        info.condition = Some(model.condition());
        info.stiffness_rounding = model.rounding;
    }
    info.elapsed_s = started.elapsed().as_secs_f64();
    check_forward_error(&info, params)?;
    Ok(info)
}

fn check(load: usize, reached: &Reached, measure: &Measure<'_>) -> Result<(), SimError> {
    let (limit, energy_limit) =
        (measure.solve.fail_above, measure.iterative.energy_error_fail_above);
    if reached.backward_error <= limit && reached.energy_error <= energy_limit {
        return Ok(());
    }
    Err(SimError::NotConverged {
        load,
        n_iterations: reached.n_iterations,
        backward_error: reached.backward_error,
        limit,
        energy_error: reached.energy_error,
        energy_limit,
    })
}

fn take(info: &mut SolveInfo, load: usize, reached: &Reached) {
    info.n_refinements = info.n_refinements.max(reached.n_restarts);
    info.n_iterations = info.n_iterations.max(reached.n_iterations);
    info.worst_energy_error = info.worst_energy_error.max(reached.energy_error);
    info.worst_relative_residual = info.worst_relative_residual.max(reached.relative_residual);
    if reached.backward_error > info.worst_backward_error {
        (info.worst_backward_error, info.worst_load) = (reached.backward_error, load);
    }
}

/// Adds the loads of `block` to `x` `[n_equations, n_columns]`, row-major.
fn add_loads(x: &mut [f64], loads: &[NodalLoad], block: &[usize], unknowns: &Unknowns) {
    let k = block.len();
    for (column, &load) in block.iter().enumerate() {
        for (place, force) in unknown_forces(&loads[load], unknowns) {
            for (c, f) in force.iter().enumerate() {
                x[(3 * place + c) * k + column] += f;
            }
        }
    }
}

/// Row-major columns, padded.
fn columns(x: &[f64], k: usize) -> Columns {
    let mut columns = Columns::default();
    columns.reshape(x.len() / k, k);
    let stride = columns.stride();
    for (row, padded) in x.chunks_exact(k).zip(columns.values_mut().chunks_exact_mut(stride)) {
        padded[..k].copy_from_slice(row);
    }
    columns
}
