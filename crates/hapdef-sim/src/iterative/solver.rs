//! The solver of a model, whichever it is, and the loads' way through the iterative one.

use std::time::Instant;

use super::pcg::{IterativeParams, Measure, Reached, WIDEST, solve_block};
use super::{CornerInterpolation, Multigrid, NearNull, rigid_modes};
use crate::assembly::BlockMatrix;
use crate::factor::Factor;
use crate::solve::{SolvedBlock, add_loads};
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
    pub(crate) multigrid: Multigrid,
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
}

impl Iterative {
    /// Call inside the thread pool; `positions` are those of the block rows.
    pub(crate) fn build(
        matrix: &BlockMatrix,
        positions: &[nalgebra::Point3<f64>],
        corners: &CornerInterpolation,
        params: IterativeParams,
    ) -> Result<Self, SimError> {
        let near_null = NearNull {
            modes: &rigid_modes(positions),
            corners: Some(corners),
        };
        Ok(Self {
            multigrid: Multigrid::build(matrix, &near_null, &params.multigrid)?,
            scale: matrix.jacobi_scale(),
            params,
        })
    }
}

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
    let order = &model.structure.order;
    let n = 3 * order.nodes().len();
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
        add_loads(&mut x, loads, block, order);
        let (harvested, reached) = model.pool.install(|| {
            let reached = solve_block(&iterative.multigrid, &mut x, k, &measure);
            (harvest(&SolvedBlock::new(order, block, &x)), reached)
        });
        for (&load, reached) in block.iter().zip(&reached) {
            check(load, reached, &measure)?;
            take(&mut info, load, reached);
        }
        sink(block, harvested);
    }
    info.elapsed_s = started.elapsed().as_secs_f64();
    Ok(info)
}

fn check(load: usize, reached: &Reached, measure: &Measure<'_>) -> Result<(), SimError> {
    let (limit, energy_limit) = (
        measure.solve.fail_above,
        measure.iterative.energy_error_fail_above,
    );
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
