//! The preconditioner of one matrix.

use std::time::Instant;

use super::aggregate::Modes;
use super::bsr::Bsr;
use super::hierarchy::{BadPivot, Coarser, Level, MultigridParams, Sizes, Solid, smoother};
use super::interpolation::CornerInterpolation;
use crate::SimError;
use crate::system::assembly::BlockMatrix;

/// The levels of a multigrid preconditioner.
#[derive(Clone, Debug, PartialEq)]
pub struct MultigridInfo {
    /// Equations of each level, finest first.
    pub n_equations: Vec<usize>,
    /// Stored blocks of all levels over those of the finest: the price of one cycle.
    pub operator_complexity: f64,
    /// Bytes of all levels, the finest matrix included.
    pub bytes: usize,
    /// Seconds.
    pub build_s: f64,
}

/// What a matrix does not tell about the displacements it resists least.
pub(crate) struct NearNull<'a> {
    /// Six modes at each block row `[n_rows]`.
    pub(crate) modes: &'a [[[f64; 6]; 3]],
    /// The corner nodes under the finest level, if its nodes are those of ten-node tetrahedra.
    pub(crate) corners: Option<&'a CornerInterpolation>,
}

/// A V-cycle as preconditioner, and the matrix it is for.
#[derive(Debug)]
pub(crate) struct Multigrid {
    finest: Solid,
    /// The block row of the caller's matrix at each place.
    sequence: Vec<u32>,
    info: MultigridInfo,
}

impl Multigrid {
    /// Builds the levels; call inside the thread pool.
    ///
    /// # Errors
    /// [`SimError::NotPositiveDefinite`] with the place and direction of a pivot that is not
    /// positive, [`SimError::Singular`] where it is mere rounding.
    pub(crate) fn build(
        matrix: &BlockMatrix,
        near_null: &NearNull<'_>,
        params: &MultigridParams,
    ) -> Result<Self, SimError> {
        let started = Instant::now();
        let sequence = local_sequence(matrix);
        let a = Bsr::from_symmetric(matrix, &sequence);
        let finest = levels(a, near_null, &sequence, params).map_err(|bad| name(&bad))?;
        let mut sizes = Sizes { n_equations: Vec::new(), n_blocks: Vec::new(), bytes: 0 };
        finest.count(&mut sizes);
        let all_blocks: usize = sizes.n_blocks.iter().sum();
        let info = MultigridInfo {
            operator_complexity: all_blocks as f64 / sizes.n_blocks[0] as f64,
            n_equations: sizes.n_equations,
            bytes: sizes.bytes,
            build_s: started.elapsed().as_secs_f64(),
        };
        Ok(Self { finest, sequence, info })
    }

    pub(crate) fn info(&self) -> &MultigridInfo {
        &self.info
    }

    /// z ← M r, in this order of rows.
    pub(super) fn apply<const K: usize>(&self, r: &[[f64; K]], z: &mut [[f64; K]]) {
        self.finest.apply(r, z);
    }

    /// K in this order of rows.
    pub(super) fn matrix(&self) -> &Bsr<3, 3> {
        self.finest.matrix()
    }

    pub(super) fn sequence(&self) -> &[u32] {
        &self.sequence
    }
}

fn levels(
    a: Bsr<3, 3>,
    near_null: &NearNull<'_>,
    sequence: &[u32],
    params: &MultigridParams,
) -> Result<Solid, BadPivot> {
    let modes_at = |rows: &[u32]| -> Vec<Modes<3>> {
        rows.iter().map(|&row| near_null.modes[row as usize]).collect()
    };
    let corners = near_null.corners.filter(|_| 3 * a.n_rows() > params.dense_below);
    let Some(corners) = corners else {
        return Solid::aggregated(a, &modes_at(sequence), sequence, params);
    };
    let (p, corner_rows) = corners.matrix(sequence);
    if corner_rows.is_empty() {
        return Solid::aggregated(a, &modes_at(sequence), sequence, params);
    }
    let smoother = smoother(&a, sequence, params.fine_degree, params.spread)?;
    let (level, coarse) = Level::build(a, smoother, p);
    let next = Solid::aggregated(coarse, &modes_at(&corner_rows), &corner_rows, params)?;
    Ok(Solid::Corners(Box::new(level), Box::new(next)))
}

fn name(bad: &BadPivot) -> SimError {
    if bad.pivot > 0.0 {
        return SimError::Singular { node: bad.row, direction: bad.direction, pivot: bad.pivot };
    }
    SimError::NotPositiveDefinite { node: bad.row, direction: bad.direction }
}

/// The block rows breadth first (Cuthill and McKee 1969), so that neighbours lie close in memory.
fn local_sequence(matrix: &BlockMatrix) -> Vec<u32> {
    let pattern = &matrix.pattern;
    let n = pattern.n_rows();
    let mut first = vec![0_usize; n + 1];
    for row in 0..n {
        for &column in &pattern.columns[pattern.row_ptr[row] + 1..pattern.row_ptr[row + 1]] {
            first[row + 1] += 1;
            first[column as usize + 1] += 1;
        }
    }
    for i in 0..n {
        first[i + 1] += first[i];
    }
    let mut next = first.clone();
    let mut neighbours = vec![0_u32; first[n]];
    for row in 0..n {
        for &column in &pattern.columns[pattern.row_ptr[row] + 1..pattern.row_ptr[row + 1]] {
            for (from, to) in [(row, column as usize), (column as usize, row)] {
                neighbours[next[from]] = to as u32;
                next[from] += 1;
            }
        }
    }
    let mut seen = vec![false; n];
    let mut sequence: Vec<u32> = Vec::with_capacity(n);
    let mut done = 0;
    for seed in 0..n {
        if !seen[seed] {
            seen[seed] = true;
            sequence.push(seed as u32);
        }
        while done < sequence.len() {
            let row = sequence[done] as usize;
            done += 1;
            for &other in &neighbours[first[row]..first[row + 1]] {
                if !seen[other as usize] {
                    seen[other as usize] = true;
                    sequence.push(other);
                }
            }
        }
    }
    sequence
}
