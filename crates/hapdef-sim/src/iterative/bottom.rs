//! The coarsest level: a dense Cholesky factor.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

use super::bsr::Bsr;

/// A pivot of the matrix scaled to a unit diagonal below this is rounding: the matrix is singular.
const SINGULAR_BELOW: f64 = 1e-13;

#[derive(Debug)]
pub(super) struct Bottom {
    factor: Llt<f64>,
    scale: Vec<f64>,
}

impl Bottom {
    /// Factors `a`, or returns the block row, direction and scaled pivot at which it is singular.
    pub(super) fn build<const B: usize>(a: &Bsr<B, B>) -> Result<Self, (usize, usize, f64)> {
        let n = a.n_rows() * B;
        let mut dense = Mat::<f64>::zeros(n, n);
        for row in 0..a.n_rows() {
            for (column, block) in a.row(row) {
                for r in 0..B {
                    for c in 0..B {
                        dense[(row * B + r, column * B + c)] = block[r][c];
                    }
                }
            }
        }
        let scale: Vec<f64> = (0..n).map(|i| 1.0 / dense[(i, i)].sqrt()).collect();
        if let Some(i) = scale.iter().position(|s| !s.is_finite()) {
            return Err((i / B, i % B, dense[(i, i)]));
        }
        let scaled = Mat::from_fn(n, n, |i, j| dense[(i, j)] * scale[i] * scale[j]);
        let factor = scaled.llt(Side::Lower).map_err(
            |faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot { index }| {
                (index / B, index % B, 0.0)
            },
        )?;
        let l = factor.L();
        let pivot = |i: usize| l[(i, i)] * l[(i, i)];
        match (0..n).find(|&i| pivot(i).is_nan() || pivot(i) <= SINGULAR_BELOW) {
            Some(i) => Err((i / B, i % B, pivot(i))),
            None => Ok(Self { factor, scale }),
        }
    }

    pub(super) fn n_equations(&self) -> usize {
        self.scale.len()
    }

    /// x ← A⁻¹ b.
    pub(super) fn solve<const K: usize>(&self, b: &[[f64; K]], x: &mut [[f64; K]]) {
        // one column at a time, so that a column never depends on its neighbours
        for l in 0..K {
            let mut column = Mat::from_fn(b.len(), 1, |i, _| b[i][l] * self.scale[i]);
            self.factor.solve_in_place(column.as_mut());
            for (i, x) in x.iter_mut().enumerate() {
                x[l] = column[(i, 0)] * self.scale[i];
            }
        }
    }
}
