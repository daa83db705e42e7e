//! Maps by their first modes: proper orthogonal decomposition from snapshots (L. Sirovich,
//! "Turbulence and the dynamics of coherent structures", Quart. Appl. Math. 45, 1987).

use anyhow::{Context, Result, ensure};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};
use hapdef_data::{Standardiser, StandardiserFit};
use rayon::prelude::*;

/// Maps that one task turns into coefficients or back.
const ROWS: usize = 64;

/// Modes whose eigenvalue is at most this share of the largest are rounding.
const SMALLEST: f64 = 1e-10;

/// The first modes of standardised maps.
pub(super) struct Modes {
    standardiser: Standardiser,
    /// `[n, width]`, row-major, orthonormal.
    modes: Vec<f32>,
    /// Share of the snapshots' variance, standardised, that the modes leave out.
    pub(super) left_out: f64,
}

impl Modes {
    /// At most `n` modes of snapshots `[n_snapshots, width]`, raw units.
    pub(super) fn of(snapshots: &[f32], width: usize, n: usize) -> Result<Self> {
        let mut fit = StandardiserFit::new(width);
        fit.push(snapshots)?;
        let (standardiser, _) = fit.finish()?;
        let mut rows = snapshots.to_vec();
        standardiser.apply(&mut rows)?;
        let n_snapshots = rows.len() / width;
        let x = Mat::from_fn(n_snapshots, width, |i, j| f64::from(rows[i * width + j]));
        let mut gram = Mat::<f64>::zeros(n_snapshots, n_snapshots);
        let (a, b) = (x.as_ref(), x.transpose());
        matmul(gram.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
        let eigen = gram
            .self_adjoint_eigen(Side::Lower)
            .map_err(|error| anyhow::anyhow!("modes of {n_snapshots} maps: {error:?}"))?;
        let values = eigen.S().column_vector();
        let mut order: Vec<usize> = (0..n_snapshots).collect();
        order.sort_by(|i, j| values[*j].total_cmp(&values[*i]));
        let largest = order.first().map(|i| values[*i]).context("no snapshots")?;
        ensure!(largest > 0.0, "maps that never vary have no modes");
        let total: f64 = order.iter().map(|i| values[*i].max(0.0)).sum();
        order.truncate(n);
        order.retain(|i| values[*i] > SMALLEST * largest);
        let kept: f64 = order.iter().map(|i| values[*i]).sum();
        let weights = Mat::from_fn(order.len(), n_snapshots, |k, i| {
            eigen.U()[(i, order[k])] / values[order[k]].sqrt()
        });
        let mut modes = Mat::<f64>::zeros(order.len(), width);
        let (a, b) = (weights.as_ref(), x.as_ref());
        matmul(modes.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
        let row = |k: usize| (0..width).map(move |j| (k, j));
        let modes = (0..order.len()).flat_map(row).map(|at| modes[at] as f32);
        Ok(Self { standardiser, modes: modes.collect(), left_out: 1.0 - kept / total })
    }

    /// Numbers of a map.
    pub(super) fn width(&self) -> usize {
        self.standardiser.width()
    }

    /// Modes there are.
    pub(super) fn n(&self) -> usize {
        self.modes.len() / self.width()
    }

    /// Coefficients `[n, modes]` of maps `[n, width]`, raw units.
    pub(super) fn encode(&self, mut maps: Vec<f32>) -> Result<Vec<f32>> {
        self.standardiser.apply(&mut maps)?;
        let (width, n) = (self.width(), self.n());
        let modes = MatRef::from_row_major_slice(&self.modes, n, width).transpose();
        let mut out = vec![0.0; maps.len() / width * n];
        let blocks = out.par_chunks_mut(ROWS * n);
        blocks.zip(maps.par_chunks(ROWS * width)).for_each(|(out, maps)| product(maps, modes, out));
        Ok(out)
    }

    /// Maps `[n, width]`, raw units, of coefficients `[n, modes]`.
    pub(super) fn decode(&self, coefficients: &[f32]) -> Result<Vec<f32>> {
        let (width, n) = (self.width(), self.n());
        let modes = MatRef::from_row_major_slice(&self.modes, n, width);
        let mut maps = vec![0.0; coefficients.len() / n * width];
        let blocks = maps.par_chunks_mut(ROWS * width);
        blocks.zip(coefficients.par_chunks(ROWS * n)).for_each(|(maps, c)| product(c, modes, maps));
        self.standardiser.invert(&mut maps)?;
        Ok(maps)
    }
}

/// `out = a b`, all rows whole, row-major.
fn product(a: &[f32], b: MatRef<'_, f32>, out: &mut [f32]) {
    let n = out.len() / b.ncols();
    let a = MatRef::from_row_major_slice(a, n, b.nrows());
    let out = MatMut::from_row_major_slice_mut(out, n, b.ncols());
    matmul(out, Accum::Replace, a, b, 1.0, Par::Seq);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Maps of three patterns and a column that never varies.
    fn maps(n: usize) -> Vec<f32> {
        let row = |i: usize| {
            let [a, b, c] = [1.0, 1.7, 2.9].map(|f| (f * i as f64).sin() * 20.0);
            (0..40).map(move |j| {
                let x = j as f64 / 40.0;
                match j {
                    7 => 3.5,
                    _ => (5.0 + a * x + b * (9.0 * x).cos() + c * x * x * x) as f32,
                }
            })
        };
        (0..n).flat_map(row).collect()
    }

    #[test]
    fn as_many_modes_as_patterns_give_every_map_back() {
        let modes = Modes::of(&maps(50), 40, 10).unwrap();
        assert_eq!(modes.n(), 3, "the maps have three patterns");
        assert!(modes.left_out < 1e-9, "{}", modes.left_out);
        let others = maps(80);
        let back = modes.decode(&modes.encode(others.clone()).unwrap()).unwrap();
        for (back, map) in back.iter().zip(&others) {
            assert!((back - map).abs() < 1e-3, "{back} {map}");
        }
        assert!(back.iter().skip(7).step_by(40).all(|v| *v == 3.5));
    }

    #[test]
    fn fewer_modes_leave_out_what_they_say() {
        let modes = Modes::of(&maps(50), 40, 2).unwrap();
        let mut truth = maps(50);
        let mut back = modes.decode(&modes.encode(truth.clone()).unwrap()).unwrap();
        modes.standardiser.apply(&mut truth).unwrap();
        modes.standardiser.apply(&mut back).unwrap();
        let squares = |v: &[f32]| v.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
        let apart: Vec<f32> = truth.iter().zip(&back).map(|(a, b)| a - b).collect();
        let left_out = squares(&apart) / squares(&truth);
        assert!(modes.left_out > 1e-3);
        assert!((left_out / modes.left_out - 1.0).abs() < 1e-3, "{left_out}");
    }
}
