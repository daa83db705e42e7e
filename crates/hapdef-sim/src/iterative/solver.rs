//! The solver of a model, whichever it is, and the loads' way through the iterative one.

use std::time::Instant;

use super::aggregate::Modes;
use super::pcg::{IterativeParams, Measure, Reached, WIDEST, solve_block};
use super::{CornerInterpolation, Multigrid, NearNull};
use crate::assembly::BlockMatrix;
use crate::factor::Factor;
use crate::panel::Columns;
use crate::solve::{BLOCK, SolvedBlock, unknown_forces};
use crate::solve_info::check_forward_error;
use crate::unknowns::Unknowns;
use crate::{ElasticModel, NodalLoad, SimError, SolveInfo, SolveParams};

/// What solves a model's systems.
#[derive(Debug)]
pub(crate) enum Solver {
    Direct(Factor),
    Iterative(Box<Iterative>),
}

/// The iterative solver of one matrix.
#[derive(Debug)]
pub(crate) struct Iterative {
    pub(super) multigrid: Multigrid,
    scale: Vec<f64>,
    params: IterativeParams,
}

impl Solver {
    /// The Jacobi scaling 1/√Kᵢᵢ of each equation.
    pub(crate) fn scale(&self) -> &[f64] {
        match self {
            Self::Direct(factor) => factor.scale(),
            Self::Iterative(iterative) => &iterative.scale,
        }
    }

    /// The most entries per equation that a solve works on.
    pub(crate) fn working_set(&self, n_threads: usize) -> usize {
        match self {
            Self::Direct(_) => 2 * BLOCK * n_threads,
            Self::Iterative(_) => N_VECTORS * WIDEST,
        }
    }
}

impl Iterative {
    /// Call inside the thread pool; `modes` are the rigid modes of the block rows.
    pub(crate) fn build(
        matrix: &BlockMatrix,
        modes: &[Modes<3>],
        corners: Option<&CornerInterpolation>,
        params: IterativeParams,
    ) -> Result<Self, SimError> {
        let near_null = NearNull { modes, corners };
        Ok(Self {
            multigrid: Multigrid::build(matrix, &near_null, &params.multigrid)?,
            scale: matrix.jacobi_scale(),
            params,
        })
    }

    /// Solves K x = b for `k` ≤ 8 columns to an error in energy of about a hundredth; `x`
    /// `[n_equations, k]` holds b on entry. What does not get there stays as far as it came.
    pub(crate) fn solve_roughly(&self, x: &mut [f64], k: usize, scaled_norm: f64) {
        let measure = Measure {
            scale: &self.scale,
            scaled_norm,
            solve: &SolveParams {
                refine_above: f64::INFINITY,
                max_refinements: 0,
                ..SolveParams::default()
            },
            iterative: &IterativeParams {
                energy_error_below: ROUGH_ENERGY_ERROR,
                max_iterations: self.params.max_iterations.min(ROUGH_ITERATIONS),
                ..self.params
            },
        };
        solve_block(&self.multigrid, x, k, &measure);
    }
}

const ROUGH_ENERGY_ERROR: f64 = 1e-2;

const ROUGH_ITERATIONS: usize = 200;

/// Vectors of an iteration and of the V-cycle in it: b, x, r, z, p, q, the caller's x, and three on
/// the finest level.
const N_VECTORS: usize = 10;

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
    let measure = Measure {
        scale: &iterative.scale,
        scaled_norm: model.scaled_norm,
        solve: params,
        iterative: &iterative.params,
    };
    let sequence: Vec<usize> = (0..loads.len()).collect();
    let mut info = SolveInfo::new(loads.len());
    for block in sequence.chunks(WIDEST) {
        let k = block.len();
        let mut x = vec![0.0; n * k];
        add_loads(&mut x, loads, block, unknowns);
        let (harvested, reached) = model.pool.install(|| {
            let reached = solve_block(&iterative.multigrid, &mut x, k, &measure);
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
