//! How near to singular a factored stiffness is.

use nalgebra::{SMatrix, SymmetricEigen};

use crate::ElasticModel;
use crate::factor::cholesky::Factor;
use crate::factor::panel::Columns;
use crate::iterative::{Iterative, Solver};

/// Vectors iterated together: what one padded row of right-hand sides holds.
const N_VECTORS: usize = 8;

/// Rounds of inverse iteration.
const N_ROUNDS: usize = 3;

impl ElasticModel {
    /// The condition number of the Jacobi-scaled stiffness K̂, estimated: ‖K̂‖∞, which is at least the
    /// largest eigenvalue, over the smallest eigenvalue that subspace iteration on K̂⁻¹ finds (B. N.
    /// Parlett, The Symmetric Eigenvalue Problem, chapter 14).
    ///
    /// The first call takes three solves of eight right-hand sides, to two digits on the iterative
    /// path; solves make it by themselves.
    #[must_use]
    pub fn condition(&self) -> f64 {
        *self.condition.get_or_init(|| {
            let scale = self.solver.scale();
            let largest = match &self.solver {
                Solver::Direct(factor) => {
                    let mut x = Columns::default();
                    let everywhere = vec![true; factor.analysis.n_supernodes()];
                    largest_inverse_eigenvalue(scale, |v| direct(factor, v, &mut x, &everywhere))
                }
                Solver::Iterative(iterative) => self.pool.install(|| {
                    largest_inverse_eigenvalue(scale, |v| roughly(iterative, v, self.scaled_norm))
                }),
            };
            self.scaled_norm * largest
        })
    }
}

/// The largest eigenvalue of K̂⁻¹ = S⁻¹ K⁻¹ S⁻¹, from below, with S the Jacobi scale; `solve` makes
/// K⁻¹ v of v.
fn largest_inverse_eigenvalue(scale: &[f64], mut solve: impl FnMut(&mut [Row])) -> f64 {
    let mut v = starting_vectors(scale.len());
    let mut largest = 0.0;
    for _ in 0..N_ROUNDS {
        orthonormalise(&mut v);
        let mut w = v.clone();
        unscale(&mut w, scale);
        solve(&mut w);
        unscale(&mut w, scale);
        largest = largest_ritz_value(&v, &w);
        v = w;
    }
    largest
}

type Row = [f64; N_VECTORS];

/// Vectors without pattern that are the same every time: multiples of irrational numbers, less
/// their whole parts.
fn starting_vectors(n: usize) -> Vec<Row> {
    (0..n)
        .map(|i| {
            std::array::from_fn(|k| {
                let irrational = ((k + 2) as f64).sqrt() + 1.0 / 3.0_f64.sqrt();
                ((i + 1) as f64 * irrational).fract() - 0.5
            })
        })
        .collect()
}

fn unscale(v: &mut [Row], scale: &[f64]) {
    for (row, s) in v.iter_mut().zip(scale) {
        *row = row.map(|v| v / s);
    }
}

fn direct(factor: &Factor, v: &mut [Row], x: &mut Columns, everywhere: &[bool]) {
    x.reshape(v.len(), N_VECTORS);
    let rows = x.values_mut().chunks_exact_mut(N_VECTORS);
    for (row, v) in rows.zip(&*v) {
        row.copy_from_slice(v);
    }
    factor.solve_in_place(x, everywhere, everywhere);
    for (v, row) in v.iter_mut().zip(x.values().chunks_exact(N_VECTORS)) {
        v.copy_from_slice(row);
    }
}

fn roughly(iterative: &Iterative, v: &mut [Row], scaled_norm: f64) {
    iterative.solve_roughly(v.as_flattened_mut(), N_VECTORS, scaled_norm);
}

/// Gram and Schmidt, column after column, twice over.
fn orthonormalise(v: &mut [Row]) {
    for k in 0..N_VECTORS {
        for _ in 0..2 {
            for j in 0..k {
                let dot: f64 = v.iter().map(|row| row[j] * row[k]).sum();
                v.iter_mut().for_each(|row| row[k] -= dot * row[j]);
            }
        }
        let norm = v.iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
        let factor = if norm > 0.0 { 1.0 / norm } else { 0.0 };
        v.iter_mut().for_each(|row| row[k] *= factor);
    }
}

/// The largest eigenvalue of Vᵀ W, symmetric but for rounding.
fn largest_ritz_value(v: &[Row], w: &[Row]) -> f64 {
    let mut h = SMatrix::<f64, N_VECTORS, N_VECTORS>::zeros();
    for (v, w) in v.iter().zip(w) {
        for i in 0..N_VECTORS {
            for j in 0..N_VECTORS {
                h[(i, j)] += v[i] * w[j];
            }
        }
    }
    let symmetric = (h + h.transpose()) * 0.5;
    SymmetricEigen::new(symmetric).eigenvalues.max()
}
