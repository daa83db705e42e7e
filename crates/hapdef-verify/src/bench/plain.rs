//! faer's own sparse Cholesky on the equations, and its dense product.

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::SolveCore;
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Accum, Conj, Mat, Par, Side};

use super::clock::{Took, timed};
use super::system::System;
use crate::VerifyError;

/// Right-hand sides per call.
const BLOCK: usize = 64;

/// What the plain call took for factor (ordering included) and solves.
pub(crate) struct Plain {
    pub(crate) factor: Took,
    pub(crate) solve: Took,
}

/// Solves `system` with `sp_cholesky`.
pub(crate) fn plain(system: &System) -> Result<Plain, VerifyError> {
    let matrix = &system.matrix;
    let n = system.n();
    let pattern = SymbolicSparseColMat::new_checked(
        n,
        n,
        matrix.col_ptr.clone(),
        None,
        matrix.row_idx.clone(),
    );
    let a = SparseColMat::new(pattern, matrix.values.clone());
    let (factor, factor_took) = timed(|| a.as_ref().sp_cholesky(Side::Lower));
    let factor = factor.map_err(|error| VerifyError::not_run(format!("faer: {error:?}")))?;
    let mut solve = Took::default();
    let mut x = Mat::zeros(n, BLOCK);
    for block in system.loads.chunks(BLOCK) {
        x.fill(0.0);
        for (column, load) in block.iter().enumerate() {
            for &(row, value) in load {
                x[(row as usize, column)] += value;
            }
        }
        let columns = x.subcols_mut(0, block.len());
        let ((), took) = timed(|| factor.solve_in_place_with_conj(Conj::No, columns));
        solve.wall_s += took.wall_s;
        solve.processor_s += took.processor_s;
    }
    Ok(Plain { factor: factor_took, solve })
}

/// Floating-point operations per second of a dense product on one thread: the best of ten.
pub(crate) fn dense_flops() -> f64 {
    const N: usize = 1024;
    let a = Mat::from_fn(N, N, |i, j| ((i * 7 + j * 3) % 11) as f64);
    let mut c = Mat::zeros(N, N);
    let best = (0..10)
        .map(|_| {
            let product = || matmul(c.as_mut(), Accum::Replace, &a, &a, 1.0, Par::Seq);
            timed(product).1.wall_s
        })
        .fold(f64::INFINITY, f64::min);
    2.0 * (N as f64).powi(3) / best
}
