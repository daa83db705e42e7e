//! Which solver a model gets, and why.

use std::fmt;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::simplicial;

use super::IterativeParams;
use super::multigrid::MultigridInfo;
use crate::SimError;
use crate::system::assembly::BlockPattern;

/// How the systems of a model are solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SolverChoice {
    /// The direct factor if its estimated fill fits the budget, else the iterative path.
    Auto {
        /// Bytes that the stiffness and its factor may take together.
        memory_budget_bytes: usize,
    },
    /// The direct factor, whatever it takes.
    Direct,
    /// Conjugate gradients with multigrid.
    Iterative(IterativeParams),
}

/// The solver that a model has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverKind {
    /// A sparse Cholesky factor.
    Direct,
    /// Conjugate gradients with multigrid.
    Iterative,
}

/// Why a model has its solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChoiceReason {
    /// It was asked for.
    Asked,
    /// The estimated size of the direct factor against the budget.
    Estimated {
        /// Non-zeros of the factor, from its column counts.
        nnz_l: usize,
        /// Bytes that stiffness and factor would take.
        direct_bytes: usize,
        /// The budget.
        memory_budget_bytes: usize,
    },
}

/// The choice, its reason, and the levels if it fell on the iterative path.
#[derive(Clone, Debug, PartialEq)]
pub struct SolverInfo {
    /// The solver chosen.
    pub kind: SolverKind,
    /// Why.
    pub reason: ChoiceReason,
    /// The levels of the iterative path.
    pub multigrid: Option<MultigridInfo>,
}

/// Bytes of one stored upper block with its column.
const BYTES_PER_BLOCK: usize = 76;

/// Stored entries of the factor over its non-zeros (merged supernodes store zeros), at most.
const STORED_SHARE: f64 = 1.5;

/// While it is factored, the lower triangle of K is there once more, with its indices.
const BYTES_PER_LOWER_ENTRY: usize = 12;

impl Default for SolverChoice {
    /// Up to 8 GiB for the direct factor.
    fn default() -> Self {
        Self::Auto { memory_budget_bytes: 8 << 30 }
    }
}

impl fmt::Display for SolverInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match self.kind {
            SolverKind::Direct => "direct factor",
            SolverKind::Iterative => "conjugate gradients with multigrid",
        };
        let mib = |bytes: usize| bytes.div_ceil(1 << 20);
        match self.reason {
            ChoiceReason::Asked => write!(f, "{kind}, as asked"),
            ChoiceReason::Estimated { nnz_l, direct_bytes, memory_budget_bytes } => write!(
                f,
                "{kind}: a direct factor would have {nnz_l} non-zeros and take {} MiB of the {} \
                 allowed",
                mib(direct_bytes),
                mib(memory_budget_bytes)
            ),
        }?;
        let Some(multigrid) = &self.multigrid else {
            return Ok(());
        };
        write!(
            f,
            "; levels of {:?} equations, operator complexity {:.2}, {} MiB",
            multigrid.n_equations,
            multigrid.operator_complexity,
            mib(multigrid.bytes)
        )
    }
}

/// Decides by `choice` and the column counts of the factor of `pattern`, which is in elimination
/// order; the factor itself is not made.
///
/// # Errors
/// [`SimError::TooLarge`] if the counts find no memory.
pub(crate) fn choose(
    choice: SolverChoice,
    pattern: &BlockPattern,
) -> Result<(SolverKind, ChoiceReason, IterativeParams), SimError> {
    let params = IterativeParams::default();
    let memory_budget_bytes = match choice {
        SolverChoice::Direct => return Ok((SolverKind::Direct, ChoiceReason::Asked, params)),
        SolverChoice::Iterative(asked) => {
            return Ok((SolverKind::Iterative, ChoiceReason::Asked, asked));
        }
        SolverChoice::Auto { memory_budget_bytes } => memory_budget_bytes,
    };
    let nnz_l = factor_entries(pattern)?;
    let n_blocks = pattern.columns.len();
    let direct_bytes = BYTES_PER_BLOCK * n_blocks
        + 9 * BYTES_PER_LOWER_ENTRY * n_blocks
        + (8.0 * STORED_SHARE * nnz_l as f64) as usize;
    let fits = direct_bytes <= memory_budget_bytes && i32::try_from(9 * n_blocks).is_ok();
    let kind = if fits { SolverKind::Direct } else { SolverKind::Iterative };
    let reason = ChoiceReason::Estimated { nnz_l, direct_bytes, memory_budget_bytes };
    Ok((kind, reason, params))
}

/// Non-zeros of the Cholesky factor of a matrix with full 3 × 3 blocks in `pattern`, from the
/// column counts of the block graph (Gilbert, Ng and Peyton, SIAM J. Matrix Anal. Appl. 15, 1994).
fn factor_entries(pattern: &BlockPattern) -> Result<usize, SimError> {
    let n = pattern.n_rows();
    let too_large = |_| SimError::TooLarge {
        n_equations: 3 * n,
        reason: "no memory for the column counts".to_owned(),
    };
    let (col_ptr, row_idx) = upper_columns(pattern);
    let a = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
    let scratch = simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(n, row_idx.len());
    let mut memory = MemBuffer::try_new(scratch).map_err(too_large)?;
    let (mut tree, mut counts) = (vec![0_i32; n], vec![0_u32; n]);
    let stack = MemStack::new(&mut memory);
    simplicial::prefactorize_symbolic_cholesky(&mut tree, &mut counts, a, stack);
    Ok(counts.iter().map(|&count| 9 * count as usize - 3).sum())
}

/// The block graph's upper triangle by columns, rows ascending.
fn upper_columns(pattern: &BlockPattern) -> (Vec<u32>, Vec<u32>) {
    let n = pattern.n_rows();
    let mut first = vec![0_u32; n + 1];
    for &column in &pattern.columns {
        first[column as usize + 1] += 1;
    }
    for i in 0..n {
        first[i + 1] += first[i];
    }
    let mut next = first.clone();
    let mut rows = vec![0; pattern.columns.len()];
    for row in 0..n {
        for &column in &pattern.columns[pattern.row_ptr[row]..pattern.row_ptr[row + 1]] {
            rows[next[column as usize] as usize] = row as u32;
            next[column as usize] += 1;
        }
    }
    (first, rows)
}
