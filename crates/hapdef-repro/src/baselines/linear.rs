//! Linear regression with an intercept, from a stream of rows.
//!
//! Ŷ = ȳ + Wᵀ (x − x̄)/s with W minimising Σ‖y − ŷ‖² + n·ridge·‖W‖². The normal equations of the
//! standardised inputs, (C + ridge·I) W = s⁻¹·cov(x, y) with C the correlation matrix of the
//! inputs, need one pass and never hold Y. Virtual gauges are nearly collinear, so C is inverted
//! through its eigenvalues; directions with λ below a tolerance are left out. That is the
//! minimum-norm solution which a singular-value least-squares solver (LAPACK gelsd, behind
//! scikit-learn's `LinearRegression`) gives for the standardised inputs with the cut-off
//! √tolerance on singular values.

#![allow(non_snake_case)] // C, B and W as in the formulas above

mod solve;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use hapdef_report::check_len;
use rayon::prelude::*;

use self::solve::{normal_residual, pseudo_solve};
use crate::error::{ReproError, check_finite, check_finite_from, check_parameter, whole_rows};

/// Columns of Y that one task accumulates; fixed, so that results do not depend on threads.
const COLUMN_TILE: usize = 256;
/// Rows that one task predicts.
const ROW_TILE: usize = 256;

/// Parameters of [`LinearAccumulator::solve`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearParams {
    /// Added to each eigenvalue of the inputs' correlation matrix; dimensionless, 0 for none.
    pub ridge: f64,
    /// Directions whose eigenvalue is at most this fraction of the largest are left out.
    pub relative_tolerance: f64,
}

impl Default for LinearParams {
    /// No ridge. Tolerance 1e-12 (1e-6 on singular values): far above the rounding of a sum in
    /// f64 (1e-15), near the relative rounding of inputs stored as f32 (6e-8 on singular values).
    fn default() -> Self {
        Self { ridge: 0.0, relative_tolerance: 1e-12 }
    }
}

/// What [`LinearAccumulator::solve`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearInfo {
    /// Samples accumulated.
    pub n_samples: usize,
    /// Directions of the inputs kept.
    pub rank: usize,
    /// Inputs that never varied; their coefficients are zero.
    pub n_constant_inputs: usize,
    /// ‖(C + ridge) W − B‖ / ‖B‖ in the Frobenius norm: the part of the covariance with the
    /// outputs that lies in directions left out, plus rounding.
    pub normal_residual: f64,
}

/// Running sums Σ(x−a), Σ(y−b), Σ(x−a)(x−a)ᵀ and Σ(x−a)(y−b)ᵀ in f64.
///
/// The shifts a, b are the means of the first block, which keeps the later centring free of
/// cancellation. Adding more rows after a solution is allowed, so nested training sets
/// (I, I–II, …) cost one pass.
#[derive(Clone, Debug)]
pub struct LinearAccumulator {
    n_samples: usize,
    x_shift: Vec<f64>,
    y_shift: Vec<f64>,
    x_sum: Vec<f64>,
    y_sum: Vec<f64>,
    xx: Mat<f64>,
    /// `[n_inputs, n_outputs]` in tiles of columns.
    xy: Vec<Mat<f64>>,
}

impl LinearAccumulator {
    /// Empty sums for rows of `n_inputs` and `n_outputs` values.
    pub fn new(n_inputs: usize, n_outputs: usize) -> Self {
        Self {
            n_samples: 0,
            x_shift: vec![0.0; n_inputs],
            y_shift: vec![0.0; n_outputs],
            x_sum: vec![0.0; n_inputs],
            y_sum: vec![0.0; n_outputs],
            xx: Mat::zeros(n_inputs, n_inputs),
            xy: (0..n_outputs)
                .step_by(COLUMN_TILE)
                .map(|first| Mat::zeros(n_inputs, COLUMN_TILE.min(n_outputs - first)))
                .collect(),
        }
    }

    /// Samples added so far.
    #[cfg(test)]
    pub fn n_samples(&self) -> usize {
        self.n_samples
    }

    /// Adds a block: `x` is `[rows, n_inputs]`, `y` is `[rows, n_outputs]`, both row-major.
    ///
    /// Memory while adding: the block in f64. Blocks of about 512 rows are fast.
    pub fn add_block(&mut self, x: &[f32], y: &[f32]) -> Result<(), ReproError> {
        let (p, q) = (self.x_shift.len(), self.y_shift.len());
        let n = whole_rows("linear regression inputs", p, x.len())?;
        check_len("linear regression outputs", n * q, y.len())?;
        check_finite_from("linear regression inputs", p, self.n_samples, x)?;
        check_finite_from("linear regression outputs", q, self.n_samples, y)?;
        if n == 0 {
            return Ok(());
        }
        if self.n_samples == 0 {
            self.x_shift = column_means(x, p);
            self.y_shift = column_means(y, q);
        }
        let xs = shifted(x, &self.x_shift, 0..p);
        add_column_sums(xs.as_ref(), &mut self.x_sum);
        matmul(self.xx.as_mut(), Accum::Add, xs.transpose(), xs.as_ref(), 1.0, Par::Seq);
        self.add_outputs(xs.as_ref(), y);
        self.n_samples += n;
        Ok(())
    }

    fn add_outputs(&mut self, xs: MatRef<'_, f64>, y: &[f32]) {
        let y_shift = &self.y_shift;
        let tiles = self.xy.par_iter_mut().zip(self.y_sum.par_chunks_mut(COLUMN_TILE));
        tiles.enumerate().for_each(|(tile, (xy, y_sum))| {
            let first = tile * COLUMN_TILE;
            let ys = shifted(y, y_shift, first..first + y_sum.len());
            add_column_sums(ys.as_ref(), y_sum);
            matmul(xy.as_mut(), Accum::Add, xs.transpose(), ys.as_ref(), 1.0, Par::Seq);
        });
    }

    /// The regression that minimises the squared error over all rows added so far.
    pub fn solve(
        &self,
        params: &LinearParams,
    ) -> Result<(LinearRegression, LinearInfo), ReproError> {
        params.check()?;
        if self.n_samples < 2 {
            return Err(ReproError::TooFewSamples {
                what: "linear regression",
                needed: 2,
                found: self.n_samples,
            });
        }
        let n = self.n_samples as f64;
        let x_off: Vec<f64> = self.x_sum.iter().map(|s| s / n).collect();
        let y_off: Vec<f64> = self.y_sum.iter().map(|s| s / n).collect();
        let (p, q) = (x_off.len(), y_off.len());
        let mut C = Mat::from_fn(p, p, |i, j| self.xx[(i, j)] / n - x_off[i] * x_off[j]);
        let scale = scales(&C, &self.x_shift, &x_off);
        C = Mat::from_fn(p, p, |i, j| 0.5 * (C[(i, j)] + C[(j, i)]) * scale[i] * scale[j]);
        let B = Mat::from_fn(p, q, |i, j| {
            (self.xy[j / COLUMN_TILE][(i, j % COLUMN_TILE)] / n - x_off[i] * y_off[j]) * scale[i]
        });
        let (W, rank) = pseudo_solve(&C, &B, params, self.n_samples)?;
        let info = LinearInfo {
            n_samples: self.n_samples,
            rank,
            n_constant_inputs: scale.iter().filter(|s| **s == 0.0).count(),
            normal_residual: normal_residual(&C, &W, &B, params.ridge),
        };
        let x_mean = self.x_shift.iter().zip(&x_off).map(|(a, d)| a + d).collect();
        let y_mean = self.y_shift.iter().zip(&y_off).map(|(b, d)| b + d).collect();
        Ok((LinearRegression { x_mean, x_inv_std: scale, y_mean, weights: W }, info))
    }
}

impl LinearParams {
    fn check(&self) -> Result<(), ReproError> {
        let Self { ridge, relative_tolerance: tolerance } = *self;
        let is_fine = ridge >= 0.0 && ridge.is_finite();
        check_parameter("ridge", ridge, "finite and at least 0", is_fine)?;
        let is_fine = (0.0..1.0).contains(&tolerance);
        check_parameter("relative_tolerance", tolerance, "in [0, 1)", is_fine)
    }
}

/// A solved linear regression; input and output units are those of the training rows.
#[derive(Clone, Debug)]
pub struct LinearRegression {
    x_mean: Vec<f64>,
    /// 1/standard deviation, 0 for an input that never varied.
    x_inv_std: Vec<f64>,
    y_mean: Vec<f64>,
    /// `[n_inputs, n_outputs]`, for standardised inputs.
    weights: Mat<f64>,
}

impl LinearRegression {
    /// Values in one input row.
    pub fn n_inputs(&self) -> usize {
        self.x_mean.len()
    }

    /// Values in one output row.
    pub fn n_outputs(&self) -> usize {
        self.y_mean.len()
    }

    /// The coefficient ∂y/∂x of input `input` and output `output`, in the rows' own units.
    #[cfg(test)]
    pub fn coefficient(&self, input: usize, output: usize) -> f64 {
        self.weights[(input, output)] * self.x_inv_std[input]
    }

    /// Predicts `out` `[rows, n_outputs]` from `x` `[rows, n_inputs]`, both row-major.
    pub fn predict(&self, x: &[f32], out: &mut [f32]) -> Result<(), ReproError> {
        let (p, q) = (self.n_inputs(), self.n_outputs());
        let n = whole_rows("linear regression inputs", p, x.len())?;
        check_len("linear regression predictions", n * q, out.len())?;
        check_finite("linear regression inputs", p, x)?;
        if q == 0 {
            return Ok(());
        }
        out.par_chunks_mut(ROW_TILE * q).zip(x.par_chunks(ROW_TILE * p)).for_each(|(out, x)| {
            let n = x.len() / p;
            let xs = Mat::from_fn(n, p, |i, j| {
                (f64::from(x[i * p + j]) - self.x_mean[j]) * self.x_inv_std[j]
            });
            let mut y = Mat::<f64>::zeros(n, q);
            matmul(y.as_mut(), Accum::Replace, xs.as_ref(), self.weights.as_ref(), 1.0, Par::Seq);
            for i in 0..n {
                for j in 0..q {
                    out[i * q + j] = (y[(i, j)] + self.y_mean[j]) as f32;
                }
            }
        });
        Ok(())
    }
}

fn column_means(rows: &[f32], width: usize) -> Vec<f64> {
    let n = (rows.len() / width.max(1)) as f64;
    let mut sums = vec![0.0; width];
    for row in rows.chunks_exact(width.max(1)) {
        for (sum, &v) in sums.iter_mut().zip(row) {
            *sum += f64::from(v);
        }
    }
    sums.into_iter().map(|s| s / n).collect()
}

/// Columns `columns` of the row-major `rows`, minus their shifts, as a column-major matrix.
fn shifted(rows: &[f32], shift: &[f64], columns: std::ops::Range<usize>) -> Mat<f64> {
    let width = shift.len();
    Mat::from_fn(rows.len() / width, columns.len(), |i, j| {
        let column = columns.start + j;
        f64::from(rows[i * width + column]) - shift[column]
    })
}

fn add_column_sums(block: MatRef<'_, f64>, sums: &mut [f64]) {
    for (j, sum) in sums.iter_mut().enumerate() {
        *sum += block.col(j).iter().sum::<f64>();
    }
}

/// 1/standard deviation of each input; 0 where the spread is mere rounding of the mean.
fn scales(cov: &Mat<f64>, shift: &[f64], offset: &[f64]) -> Vec<f64> {
    (0..offset.len())
        .map(|i| {
            let std = cov[(i, i)].max(0.0).sqrt();
            let mean = (shift[i] + offset[i]).abs();
            if std > 1e-12 * mean { 1.0 / std } else { 0.0 }
        })
        .collect()
}

#[cfg(test)]
mod tests;
