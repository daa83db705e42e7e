//! The sparse supernodal Cholesky factor, scaled to a unit diagonal.
//!
//! faer makes the factor; the solves here walk its supernodes themselves, on right-hand sides stored
//! row by row, so that gathering a supernode's rows copies whole rows, and so that supernodes which
//! no right-hand side of a block reaches are skipped on the way down.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot;
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::prelude::default;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::{simplicial, supernodal};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Accum, MatMut, MatRef, Par};

use crate::SimError;
use crate::assembly::{BlockMatrix, BlockPattern};

/// Adjacent supernodes of up to the given width merge if less than the given share of the result
/// would be zeros. Wider than faer's default, for the sake of solves with many right-hand sides.
const RELAX: [(usize, f64); 4] = [(12, 0.8), (24, 0.4), (48, 0.2), (usize::MAX, 0.05)];

/// The structure of the factor of one pattern; shared by all matrices with that pattern.
#[derive(Debug)]
pub(crate) struct Analysis {
    supernodes: supernodal::SymbolicSupernodalCholesky<u32>,
    supernode_of_equation: Vec<u32>,
    /// Non-zeros of L, without the zeros that merged supernodes store.
    pub(crate) nnz_l: usize,
    /// Entries of L's lower trapezoids as stored, merged zeros included.
    pub(crate) nnz_l_stored: usize,
}

/// K = S⁻¹ L Lᵀ S⁻¹ with S the Jacobi scaling.
#[derive(Debug)]
pub(crate) struct Factor {
    analysis: Arc<Analysis>,
    values: Vec<f64>,
    scale: Vec<f64>,
}

impl Analysis {
    pub(crate) fn build(pattern: &BlockPattern) -> Result<Self, SimError> {
        let n = 3 * pattern.n_rows();
        let too_large = |reason: &str| SimError::TooLarge {
            n_equations: n,
            reason: reason.to_owned(),
        };
        let (col_ptr, row_idx) = upper_columns(pattern)
            .ok_or_else(|| too_large("more entries than 32-bit indices can name"))?;
        let a = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
        let scratch = supernodal::factorize_supernodal_symbolic_cholesky_scratch::<u32>(n).or(
            simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(n, row_idx.len()),
        );
        let mut memory =
            MemBuffer::try_new(scratch).map_err(|_| too_large("no memory for the analysis"))?;
        let stack = MemStack::new(&mut memory);
        let (mut tree, mut counts) = (vec![0_i32; n], vec![0_u32; n]);
        let tree = simplicial::prefactorize_symbolic_cholesky(&mut tree, &mut counts, a, stack);
        let params = SymbolicSupernodalParams {
            relax: Some(&RELAX),
        };
        let supernodes =
            supernodal::factorize_supernodal_symbolic_cholesky(a, tree, &counts, stack, params)
                .map_err(|error| too_large(&format!("{error:?}")))?;
        let nnz_l = counts.iter().map(|&count| count as usize).sum();
        Ok(Self {
            supernode_of_equation: supernode_of_equation(&supernodes),
            nnz_l_stored: stored_entries(&supernodes),
            nnz_l,
            supernodes,
        })
    }

    fn width(&self, s: usize) -> usize {
        (self.supernodes.supernode_end()[s] - self.supernodes.supernode_begin()[s]) as usize
    }
}

/// The upper triangle's equations by column (rows ascending), or nothing on 32-bit overflow.
fn upper_columns(pattern: &BlockPattern) -> Option<(Vec<u32>, Vec<u32>)> {
    let n = pattern.n_rows();
    i32::try_from(9 * pattern.columns.len()).ok()?;
    let mut first = vec![0_usize; n + 1];
    for &column in &pattern.columns {
        first[column as usize + 1] += 1;
    }
    for i in 0..n {
        first[i + 1] += first[i];
    }
    let mut next = first.clone();
    let mut rows = vec![0_u32; pattern.columns.len()];
    for row in 0..n {
        for &column in &pattern.columns[pattern.row_ptr[row]..pattern.row_ptr[row + 1]] {
            rows[next[column as usize]] = row as u32;
            next[column as usize] += 1;
        }
    }
    let mut col_ptr = vec![0_u32];
    let mut row_idx = Vec::with_capacity(9 * rows.len());
    for place in 0..n {
        for direction in 0..3 {
            let equation = (3 * place + direction) as u32;
            let above = rows[first[place]..first[place + 1]].iter();
            row_idx.extend(
                above
                    .flat_map(|&row| (0..3).map(move |c| 3 * row + c))
                    .take_while(|&i| i <= equation),
            );
            col_ptr.push(row_idx.len() as u32);
        }
    }
    Some((col_ptr, row_idx))
}

fn supernode_of_equation(supernodes: &supernodal::SymbolicSupernodalCholesky<u32>) -> Vec<u32> {
    let mut of = vec![0; supernodes.nrows()];
    for (s, (&begin, &end)) in supernodes
        .supernode_begin()
        .iter()
        .zip(supernodes.supernode_end())
        .enumerate()
    {
        of[begin as usize..end as usize].fill(s as u32);
    }
    of
}

fn stored_entries(supernodes: &supernodal::SymbolicSupernodalCholesky<u32>) -> usize {
    (0..supernodes.n_supernodes())
        .map(|s| {
            let width = (supernodes.supernode_end()[s] - supernodes.supernode_begin()[s]) as usize;
            width * (width + 1) / 2 + width * supernodes.supernode(s).pattern().len()
        })
        .sum()
}

impl Factor {
    /// Factors `matrix`. One thread, so that the result never depends on the machine's load.
    pub(crate) fn build(matrix: &BlockMatrix, analysis: Arc<Analysis>) -> Result<Self, SimError> {
        let scale = matrix.jacobi_scale();
        let n_equations = scale.len();
        let too_large = |reason: &str| SimError::TooLarge {
            n_equations,
            reason: reason.to_owned(),
        };
        let (col_ptr, row_idx, scaled) = lower_columns(matrix, &scale);
        let a = SparseColMatRef::new(
            SymbolicSparseColMatRef::new_unsorted_checked(
                n_equations,
                n_equations,
                &col_ptr,
                None,
                &row_idx,
            ),
            &scaled,
        );
        let scratch = supernodal::factorize_supernodal_numeric_llt_scratch::<u32, f64>(
            &analysis.supernodes,
            Par::Seq,
            default(),
        );
        let mut memory = MemBuffer::try_new(scratch)
            .map_err(|_| too_large("no memory for the factorisation"))?;
        let mut values = vec![0.0; analysis.supernodes.len_val()];
        supernodal::factorize_supernodal_numeric_llt(
            &mut values,
            a,
            LltRegularization::default(),
            &analysis.supernodes,
            Par::Seq,
            MemStack::new(&mut memory),
            default(),
        )
        .map_err(|NonPositivePivot { index }| SimError::NotPositiveDefinite {
            node: index / 3,
            direction: index % 3,
        })?;
        Ok(Self {
            analysis,
            values,
            scale,
        })
    }

    /// The Jacobi scaling 1/√Kᵢᵢ of each equation.
    pub(crate) fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// Solves K x = b in place for `k` columns; `x` `[n_equations, k]`, row-major.
    ///
    /// Only equations in `touched` may be non-zero on entry.
    pub(crate) fn solve_in_place(
        &self,
        x: &mut [f64],
        k: usize,
        touched: impl Iterator<Item = usize>,
        gathered: &mut Vec<f64>,
    ) {
        let reached = self.reached(touched);
        scale_rows(x, k, &self.scale);
        self.forward(x, k, &reached, gathered);
        self.backward(x, k, gathered);
        scale_rows(x, k, &self.scale);
    }

    /// The supernodes on the paths from `touched` to the root of the elimination tree.
    fn reached(&self, touched: impl Iterator<Item = usize>) -> Vec<bool> {
        let supernodes = &self.analysis.supernodes;
        let mut reached = vec![false; supernodes.n_supernodes()];
        for equation in touched {
            reached[self.analysis.supernode_of_equation[equation] as usize] = true;
        }
        for s in 0..reached.len() {
            if reached[s]
                && let Some(&row) = supernodes.supernode(s).pattern().first()
            {
                reached[self.analysis.supernode_of_equation[row as usize] as usize] = true;
            }
        }
        reached
    }

    /// x ← L⁻¹ x.
    fn forward(&self, x: &mut [f64], k: usize, reached: &[bool], gathered: &mut Vec<f64>) {
        let l = supernodal::SupernodalLltRef::new(&self.analysis.supernodes, &self.values);
        for s in (0..reached.len()).filter(|&s| reached[s]) {
            let (node, width) = (l.supernode(s), self.analysis.width(s));
            let (top, below) = node.val().split_at_row(width);
            let own = &mut x[node.start() * k..(node.start() + width) * k];
            let mut own = MatMut::from_row_major_slice_mut(own, width, k);
            solve_lower_triangular_in_place(top, own.as_mut(), Par::Seq);
            let m = node.pattern().len();
            gathered.resize(m * k, 0.0);
            let update = MatMut::from_row_major_slice_mut(gathered, m, k);
            matmul(update, Accum::Replace, below, own.as_ref(), 1.0, Par::Seq);
            for (row, update) in node.pattern().iter().zip(gathered.chunks_exact(k)) {
                let row = *row as usize * k;
                for (x, u) in x[row..row + k].iter_mut().zip(update) {
                    *x -= u;
                }
            }
        }
    }

    /// x ← L⁻ᵀ x.
    fn backward(&self, x: &mut [f64], k: usize, gathered: &mut Vec<f64>) {
        let l = supernodal::SupernodalLltRef::new(&self.analysis.supernodes, &self.values);
        for s in (0..self.analysis.supernodes.n_supernodes()).rev() {
            let (node, width) = (l.supernode(s), self.analysis.width(s));
            let (top, below) = node.val().split_at_row(width);
            gathered.clear();
            for &row in node.pattern() {
                gathered.extend_from_slice(&x[row as usize * k..(row as usize + 1) * k]);
            }
            let known = MatRef::from_row_major_slice(gathered, node.pattern().len(), k);
            let own = &mut x[node.start() * k..(node.start() + width) * k];
            let mut own = MatMut::from_row_major_slice_mut(own, width, k);
            matmul(
                own.as_mut(),
                Accum::Add,
                below.transpose(),
                known,
                -1.0,
                Par::Seq,
            );
            solve_upper_triangular_in_place(top.transpose(), own, Par::Seq);
        }
    }
}

fn scale_rows(x: &mut [f64], k: usize, scale: &[f64]) {
    for (row, s) in x.chunks_exact_mut(k).zip(scale) {
        for value in row {
            *value *= s;
        }
    }
}

/// The scaled lower triangle by columns: rows of stored upper blocks are columns of the lower.
fn lower_columns(matrix: &BlockMatrix, scale: &[f64]) -> (Vec<u32>, Vec<u32>, Vec<f64>) {
    let pattern = &matrix.pattern;
    let capacity = 9 * pattern.columns.len();
    let (mut row_idx, mut values) = (Vec::with_capacity(capacity), Vec::with_capacity(capacity));
    let mut col_ptr = vec![0_u32];
    for place in 0..pattern.n_rows() {
        for c in 0..3 {
            let equation = 3 * place + c;
            for slot in pattern.row_ptr[place]..pattern.row_ptr[place + 1] {
                let other = 3 * pattern.columns[slot] as usize;
                for r in 0..3 {
                    if other + r >= equation {
                        row_idx.push((other + r) as u32);
                        let value = matrix.blocks[slot][3 * c + r];
                        values.push(value * scale[equation] * scale[other + r]);
                    }
                }
            }
            col_ptr.push(row_idx.len() as u32);
        }
    }
    (col_ptr, row_idx, values)
}
