//! The sparse supernodal Cholesky factor, computed front by front.
//!
//! Subtrees of the elimination tree are factored side by side, the crown above them one supernode
//! after the other with its tiles side by side. Every sum has a fixed order: the result is the same
//! bit for bit on any number of threads.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::SimError;
pub(crate) use crate::factor::analysis::Analysis;
use crate::factor::front::{Front, Update};
use crate::system::assembly::BlockMatrix;

/// K = L Lᵀ.
///
/// The matrix that is factored is K scaled by powers of two to a diagonal near 1, which costs no
/// rounding, and L is scaled back.
#[derive(Debug)]
pub(crate) struct Factor {
    pub(crate) analysis: Arc<Analysis>,
    /// Per supernode of w nodes, node by node of its rows: 3 values per column, −L as
    /// `[column][direction]`; rows of its own nodes end with their own columns, where 1/L stands on
    /// the diagonal. Columns are 3w.
    pub(crate) values: Vec<f64>,
    scale: Vec<f64>,
}

/// What one thread needs to factor supernodes.
struct Worker<'a> {
    matrix: &'a BlockMatrix,
    analysis: &'a Analysis,
    /// A power of two per equation.
    scale: &'a [f64],
    front: Front,
    /// The front's node for each node of the matrix; meaningful only for nodes of the front.
    local: Vec<u32>,
}

impl Factor {
    /// Factors `matrix`; call inside the thread pool.
    pub(crate) fn build(matrix: &BlockMatrix, analysis: Arc<Analysis>) -> Result<Self, SimError> {
        let scale = matrix.jacobi_scale();
        let powers: Vec<f64> = scale.iter().map(|s| s.log2().round().exp2()).collect();
        let mut values = vec![0.0; analysis.n_values()];
        let worker = |parallel| Worker {
            matrix,
            analysis: &analysis,
            scale: &powers,
            front: Front::new(parallel),
            local: vec![0; analysis.n_nodes()],
        };
        let (mut in_subtrees, mut in_crown) = split_values(&analysis, &mut values);
        let done: Vec<Result<Update, usize>> = analysis
            .subtrees
            .par_iter()
            .zip(&mut in_subtrees)
            .map_init(|| worker(false), |worker, (range, values)| worker.subtree(range, values))
            .collect();
        let mut updates = vec![Update::new(); analysis.n_supernodes()];
        for (range, update) in analysis.subtrees.iter().zip(done) {
            updates[range.end - 1] = update.map_err(bad_pivot)?;
        }
        let mut crown = worker(true);
        for (&s, values) in analysis.crown.iter().zip(&mut in_crown) {
            updates[s] = crown.supernode(s, &mut updates, 0, values).map_err(bad_pivot)?;
        }
        Ok(Self { analysis, values, scale })
    }

    /// The Jacobi scaling 1/√Kᵢᵢ of each equation.
    pub(crate) fn scale(&self) -> &[f64] {
        &self.scale
    }
}

fn bad_pivot(equation: usize) -> SimError {
    SimError::NotPositiveDefinite { node: equation / 3, direction: equation % 3 }
}

/// The values of each subtree, and of each supernode of the crown.
fn split_values<'a>(
    analysis: &Analysis,
    values: &'a mut [f64],
) -> (Vec<&'a mut [f64]>, Vec<&'a mut [f64]>) {
    let subtrees = analysis.subtrees.iter().map(|range| (range.clone(), true));
    let crown = analysis.crown.iter().map(|&s| (s..s + 1, false));
    let mut parts: Vec<(Range<usize>, bool)> = subtrees.chain(crown).collect();
    parts.sort_by_key(|(range, _)| range.start);
    let (mut of_subtrees, mut of_crown, mut rest) = (Vec::new(), Vec::new(), values);
    for (range, is_subtree) in parts {
        let (part, later) = rest.split_at_mut(analysis.values_of(&range).len());
        rest = later;
        if is_subtree {
            of_subtrees.push(part);
        } else {
            of_crown.push(part);
        }
    }
    (of_subtrees, of_crown)
}

impl Worker<'_> {
    /// Factors the supernodes of `range`, a subtree, and returns what it leaves for its parent.
    fn subtree(&mut self, range: &Range<usize>, values: &mut [f64]) -> Result<Update, usize> {
        let mut updates = vec![Update::new(); range.len()];
        let mut rest = values;
        for s in range.clone() {
            let (own, later) = rest.split_at_mut(self.analysis.values(s).len());
            rest = later;
            updates[s - range.start] = self.supernode(s, &mut updates, range.start, own)?;
        }
        Ok(updates.pop().unwrap_or_default())
    }

    /// Factors supernode `s`; `updates` begins with that of supernode `first`. The error is the
    /// equation with a bad pivot.
    fn supernode(
        &mut self,
        s: usize,
        updates: &mut [Update],
        first: usize,
        values: &mut [f64],
    ) -> Result<Update, usize> {
        let (nodes, below) = (self.analysis.nodes(s), self.analysis.below(s));
        let width = nodes.len();
        for (i, node) in nodes.clone().enumerate() {
            self.local[node] = i as u32;
        }
        for (i, &node) in below.iter().enumerate() {
            self.local[node as usize] = (width + i) as u32;
        }
        self.front.start(3 * (width + below.len()));
        self.add_matrix(nodes.clone());
        for &child in self.analysis.children(s) {
            let update = std::mem::take(&mut updates[child as usize - first]);
            let below = self.analysis.below(child as usize).iter();
            let local: Vec<u32> = below.map(|&node| self.local[node as usize]).collect();
            self.front.add(&update, &local);
        }
        let eliminated = self.front.eliminate(3 * width);
        eliminated.map_err(|column| 3 * nodes.start + column)?;
        self.store(nodes, below, values);
        Ok(self.front.update(3 * width))
    }

    /// Adds the matrix's columns of `nodes`: rows of its upper triangle.
    fn add_matrix(&mut self, nodes: Range<usize>) {
        let pattern = &self.matrix.pattern;
        for (i, node) in nodes.enumerate() {
            for slot in pattern.row_ptr[node]..pattern.row_ptr[node + 1] {
                let other = pattern.columns[slot] as usize;
                let (row, block) = (3 * self.local[other] as usize, &self.matrix.blocks[slot]);
                for c in 0..3 {
                    let column = self.front.column_mut(3 * i + c);
                    let scale = self.scale[3 * node + c];
                    for r in 0..3 {
                        column[row + r] += block[3 * c + r] * (scale * self.scale[3 * other + r]);
                    }
                }
            }
        }
    }

    /// Copies the eliminated columns in the order that solves read them.
    fn store(&self, nodes: Range<usize>, below: &[u32], values: &mut [f64]) {
        let width = nodes.len();
        let rows = nodes.clone().chain(below.iter().map(|&node| node as usize));
        let mut values = values.chunks_exact_mut(3);
        for (i, node) in rows.enumerate() {
            let back: [f64; 3] = std::array::from_fn(|r| 1.0 / self.scale[3 * node + r]);
            for (j, three) in (0..3 * width.min(i + 1)).zip(&mut values) {
                let column = &self.front.column(j)[3 * i..3 * i + 3];
                for r in 0..3 {
                    three[r] = -column[r] * back[r];
                }
                if j >= 3 * i {
                    three[j - 3 * i] = -1.0 / three[j - 3 * i];
                }
            }
        }
    }
}
