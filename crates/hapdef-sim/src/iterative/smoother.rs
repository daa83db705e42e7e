//! The smoother: a Chebyshev polynomial in D⁻¹A, D the diagonal blocks.
//!
//! Adams, Brezina, Hu and Tuminaro, "Parallel multigrid smoothing: polynomial versus Gauss–Seidel",
//! J. Comput. Phys. 188 (2003). Symmetric in A's inner product whatever the threads do, which
//! Gauss–Seidel is not.

use nalgebra::SMatrix;
use rayon::prelude::*;

use super::bsr::{Block, Bsr};
use super::ritz::extreme_ritz_values;
use super::vectors::{add_scaled, dot, scale_and_add};

/// Steps of the Lanczos process that estimates the largest eigenvalue of D⁻¹A.
const LANCZOS_STEPS: usize = 16;

/// The Lanczos value is a lower bound; the polynomial's interval ends this much above it.
const SAFETY: f64 = 1.1;

/// Entries that one task handles.
const ROWS: usize = 1024;

#[derive(Debug)]
pub(super) struct Smoother<const B: usize> {
    inverse: Vec<Block<B, B>>,
    /// The estimate of the largest eigenvalue of D⁻¹A, safety included.
    pub(super) largest: f64,
    degree: usize,
    /// Largest over smallest eigenvalue that the polynomial is made for.
    spread: f64,
}

impl<const B: usize> Smoother<B> {
    /// Inverts the diagonal blocks, or returns the first block row and direction whose pivot is not
    /// positive.
    pub(super) fn build(a: &Bsr<B, B>, degree: usize, spread: f64) -> Result<Self, [usize; 2]> {
        let inverse = (0..a.n_rows())
            .map(|row| {
                let own = a.row(row).find(|(column, _)| *column == row);
                let (_, block) = own.ok_or([row, 0])?;
                invert(block).map_err(|direction| [row, direction])
            })
            .collect::<Result<Vec<_>, _>>()?;
        let mut smoother = Self { inverse, largest: 1.0, degree, spread };
        smoother.largest = SAFETY * smoother.largest_eigenvalue(a);
        Ok(smoother)
    }

    /// D⁻¹ at block row `row`.
    pub(super) fn inverse(&self, row: usize) -> &Block<B, B> {
        &self.inverse[row]
    }

    /// x ← x + q(D⁻¹A) D⁻¹ r and r ← b − A x, where `r` is b − A x on entry.
    pub(super) fn smooth<const K: usize>(
        &self,
        a: &Bsr<B, B>,
        x: &mut [[f64; K]],
        r: &mut [[f64; K]],
    ) {
        let step = self.polynomial(a, x, r);
        a.subtract(&step, r);
    }

    /// As [`Self::smooth`], but leaves `r` one step behind, for the last use of it.
    pub(super) fn finish<const K: usize>(
        &self,
        a: &Bsr<B, B>,
        x: &mut [[f64; K]],
        r: &mut [[f64; K]],
    ) {
        self.polynomial(a, x, r);
    }

    /// The three-term recurrence; returns the last step, which `r` does not know of yet.
    fn polynomial<const K: usize>(
        &self,
        a: &Bsr<B, B>,
        x: &mut [[f64; K]],
        r: &mut [[f64; K]],
    ) -> Vec<[f64; K]> {
        let smallest = self.largest / self.spread;
        let centre = 0.5 * (self.largest + smallest);
        let half = 0.5 * (self.largest - smallest);
        let sigma = centre / half;
        let mut rho = 1.0 / sigma;
        let mut step = vec![[0.0; K]; x.len()];
        self.precondition(1.0 / centre, r, 0.0, &mut step);
        add_scaled(&[1.0; K], &step, x);
        for _ in 1..self.degree {
            a.subtract(&step, r);
            let next = 1.0 / (2.0 * sigma - rho);
            self.precondition(2.0 * next / half, r, next * rho, &mut step);
            rho = next;
            add_scaled(&[1.0; K], &step, x);
        }
        step
    }

    /// y ← keep · y + factor · D⁻¹ r.
    fn precondition<const K: usize>(
        &self,
        factor: f64,
        r: &[[f64; K]],
        keep: f64,
        y: &mut [[f64; K]],
    ) {
        y.par_chunks_mut(ROWS * B)
            .zip(r.par_chunks(ROWS * B))
            .zip(self.inverse.par_chunks(ROWS))
            .for_each(|((y, r), inverse)| {
                let rows = y.chunks_exact_mut(B).zip(r.chunks_exact(B));
                for ((y, r), inverse) in rows.zip(inverse) {
                    for i in 0..B {
                        let mut sum = [0.0; K];
                        for j in 0..B {
                            for l in 0..K {
                                sum[l] += inverse[i][j] * r[j][l];
                            }
                        }
                        for l in 0..K {
                            y[i][l] = keep * y[i][l] + factor * sum[l];
                        }
                    }
                }
            });
    }

    /// The largest Ritz value of D⁻¹A: the conjugate-gradient form of the Lanczos process (Golub and
    /// Van Loan, Matrix Computations, 4th ed., section 11.3.5).
    fn largest_eigenvalue(&self, a: &Bsr<B, B>) -> f64 {
        let mut r: Vec<[f64; 1]> = (0..a.n_rows() * B).map(|i| [start_value(i)]).collect();
        let mut z = vec![[0.0]; r.len()];
        let mut q = z.clone();
        self.precondition(1.0, &r, 0.0, &mut z);
        let mut p = z.clone();
        let mut rz = dot(&r, &z)[0];
        let mut coefficients = Vec::new();
        for _ in 0..LANCZOS_STEPS.min(r.len()) {
            a.multiply(&p, &mut q);
            let alpha = rz / dot(&p, &q)[0];
            if !(alpha.is_finite() && alpha > 0.0) {
                break;
            }
            add_scaled(&[-alpha], &q, &mut r);
            self.precondition(1.0, &r, 0.0, &mut z);
            let next = dot(&r, &z)[0];
            coefficients.push((alpha, next / rz));
            if next.is_nan() || next <= 1e-28 * rz {
                break;
            }
            scale_and_add(&[next / rz], &z, &mut p);
            rz = next;
        }
        extreme_ritz_values(&coefficients).map_or(1.0, |(_, largest)| largest)
    }
}

/// Values without structure, the same every time (a Weyl sequence).
fn start_value(i: usize) -> f64 {
    (0.618_033_988_749_894_9 * (i + 1) as f64).fract() - 0.5
}

/// The inverse of a symmetric positive definite block, or the direction of the failing pivot.
fn invert<const B: usize>(block: &Block<B, B>) -> Result<Block<B, B>, usize> {
    let bad = (0..B).find(|&i| !(block[i][i].is_finite() && block[i][i] > 0.0));
    if let Some(direction) = bad {
        return Err(direction);
    }
    let a = SMatrix::<f64, B, B>::from_fn(|i, j| 0.5 * (block[i][j] + block[j][i]));
    let inverse = a.cholesky().ok_or(B - 1)?.inverse();
    Ok(std::array::from_fn(|i| std::array::from_fn(|j| inverse[(i, j)])))
}
