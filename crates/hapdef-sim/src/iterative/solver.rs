//! The solver of a model, whichever it is.

use super::aggregate::Modes;
use super::pcg::{IterativeParams, Measure, Reached, WIDEST, solve_block};
use super::{CornerInterpolation, Multigrid, NearNull};
use crate::factor::cholesky::Factor;
use crate::system::assembly::BlockMatrix;
use crate::{SimError, SolveParams};

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

    /// How the error of a solution is measured, and what is asked of it.
    pub(crate) fn measure<'a>(&'a self, scaled_norm: f64, solve: &'a SolveParams) -> Measure<'a> {
        Measure { scale: &self.scale, scaled_norm, solve, iterative: &self.params }
    }

    /// Solves K x = b for `k` ≤ 8 columns; `x` `[n_equations, k]` holds b on entry.
    pub(crate) fn solve(&self, x: &mut [f64], k: usize, measure: &Measure<'_>) -> Vec<Reached> {
        solve_block(&self.multigrid, x, k, measure)
    }

    /// The most entries per equation that a solve works on.
    pub(crate) fn working_set() -> usize {
        N_VECTORS * WIDEST
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
