//! The structure of the Cholesky factor: supernodes of whole nodes and the tree they form.

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::{simplicial, supernodal};

use crate::SimError;
use crate::system::assembly::BlockPattern;

/// Adjacent supernodes of up to the given width, in nodes, merge if less than the given share of
/// the result would be zeros. Wider than faer's default, for the sake of solves with many
/// right-hand sides.
const RELAX: [(usize, f64); 4] = [(4, 0.5), (8, 0.25), (16, 0.1), (usize::MAX, 0.03)];

/// A subtree that is factored by one thread has at most this share of the work. Fixed, and the
/// result does not depend on it.
const SUBTREES: f64 = 16.0;

/// The structure of the factor of one pattern; shared by all matrices with that pattern.
///
/// Equations come three per node, and supernodes are made of whole nodes.
#[derive(Debug)]
pub(crate) struct Analysis {
    /// The first node of each supernode, and the number of nodes.
    first: Vec<u32>,
    /// Where each supernode's rows below its own begin in `below`.
    below_ptr: Vec<usize>,
    below: Vec<u32>,
    /// Where each supernode's values begin.
    value_ptr: Vec<usize>,
    supernode_of: Vec<u32>,
    /// Disjoint subtrees of supernodes, ascending; what is in none of them comes after them.
    pub(crate) subtrees: Vec<Range<usize>>,
    /// The supernodes in no subtree, ascending.
    pub(crate) crown: Vec<usize>,
    /// Where each column of the matrix's strict upper triangle begins in `column_entries`.
    column_ptr: Vec<usize>,
    /// Row and slot of its blocks, rows ascending.
    column_entries: Vec<(u32, u32)>,
    /// Children of each supernode, ascending.
    children: Vec<Vec<u32>>,
    /// Non-zeros of L, without the zeros that merged supernodes store.
    pub(crate) nnz_l: usize,
    /// Entries of L's lower trapezoids as stored, merged zeros included.
    pub(crate) nnz_l_stored: usize,
}

impl Analysis {
    pub(crate) fn build(pattern: &BlockPattern) -> Result<Self, SimError> {
        let n = pattern.n_rows();
        let too_large =
            |reason: &str| SimError::TooLarge { n_equations: 3 * n, reason: reason.to_owned() };
        i32::try_from(pattern.columns.len())
            .map_err(|_| too_large("more entries than 32-bit indices can name"))?;
        let (col_ptr, row_idx) = upper_columns(pattern);
        let a = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
        let scratch = supernodal::factorize_supernodal_symbolic_cholesky_scratch::<u32>(n)
            .or(simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(n, row_idx.len()));
        let mut memory =
            MemBuffer::try_new(scratch).map_err(|_| too_large("no memory for the analysis"))?;
        let stack = MemStack::new(&mut memory);
        let (mut tree, mut counts) = (vec![0_i32; n], vec![0_u32; n]);
        let tree = simplicial::prefactorize_symbolic_cholesky(&mut tree, &mut counts, a, stack);
        let params = SymbolicSupernodalParams { relax: Some(&RELAX) };
        let supernodes =
            supernodal::factorize_supernodal_symbolic_cholesky(a, tree, &counts, stack, params)
                .map_err(|error| too_large(&format!("{error:?}")))?;
        // a node's column of c nodes holds 3c + (3c − 1) + (3c − 2) entries
        let nnz_l = counts.iter().map(|&c| 9 * c as usize - 3).sum();
        let mut analysis = Self::of(&supernodes, nnz_l);
        (analysis.column_ptr, analysis.column_entries) = strict_columns(pattern);
        Ok(analysis)
    }

    fn of(supernodes: &supernodal::SymbolicSupernodalCholesky<u32>, nnz_l: usize) -> Self {
        let n_supernodes = supernodes.n_supernodes();
        let mut analysis = Self {
            first: supernodes.supernode_begin().to_vec(),
            below_ptr: vec![0],
            below: Vec::new(),
            value_ptr: vec![0],
            supernode_of: vec![0; supernodes.nrows()],
            subtrees: Vec::new(),
            crown: Vec::new(),
            column_ptr: Vec::new(),
            column_entries: Vec::new(),
            children: vec![Vec::new(); n_supernodes],
            nnz_l,
            nnz_l_stored: 0,
        };
        analysis.first.truncate(n_supernodes);
        analysis.first.push(supernodes.nrows() as u32);
        for s in 0..n_supernodes {
            let below = supernodes.supernode(s).pattern();
            analysis.below.extend_from_slice(below);
            analysis.below_ptr.push(analysis.below.len());
            let (width, nodes) = (analysis.width(s), analysis.nodes(s));
            analysis.supernode_of[nodes].fill(s as u32);
            let values = 9 * (width * (width + 1) / 2 + width * below.len());
            analysis.nnz_l_stored += values - 3 * width;
            analysis.value_ptr.push(analysis.value_ptr[s] + values);
        }
        for s in 0..n_supernodes {
            if let Some(parent) = analysis.parent(s) {
                analysis.children[parent].push(s as u32);
            }
        }
        analysis.cut();
        analysis
    }

    /// Cuts the tree into subtrees of little work each and the crown above them.
    fn cut(&mut self) {
        let n = self.n_supernodes();
        let (mut work, mut start) = (vec![0.0; n], (0..n).collect::<Vec<_>>());
        for s in 0..n {
            let (width, below) = (self.width(s) as f64, self.below(s).len() as f64);
            work[s] += width * (width + below).powi(2);
            if let Some(parent) = self.parent(s) {
                work[parent] += work[s];
                start[parent] = start[parent].min(start[s]);
            }
        }
        let roots = (0..n).filter(|&s| self.parent(s).is_none());
        let limit = roots.map(|s| work[s]).sum::<f64>() / SUBTREES;
        for s in 0..n {
            if work[s] > limit {
                self.crown.push(s);
            } else if self.parent(s).is_none_or(|parent| work[parent] > limit) {
                self.subtrees.push(start[s]..s + 1);
            }
        }
    }

    /// Σ c² over the columns of L as stored, c being a column's entries.
    pub(crate) fn factor_flops(&self) -> f64 {
        let column = |entries: usize| (entries as f64).powi(2);
        let of_supernode = |s: usize| -> f64 {
            let (width, below) = (3 * self.width(s), 3 * self.below(s).len());
            (1..=width).map(|own| column(own + below)).sum()
        };
        (0..self.n_supernodes()).map(of_supernode).sum()
    }

    /// Row and slot of the matrix's blocks above the diagonal in the column of `node`.
    pub(crate) fn column(&self, node: usize) -> &[(u32, u32)] {
        &self.column_entries[self.column_ptr[node]..self.column_ptr[node + 1]]
    }

    pub(crate) fn n_nodes(&self) -> usize {
        self.supernode_of.len()
    }

    pub(crate) fn n_supernodes(&self) -> usize {
        self.children.len()
    }

    /// The nodes of supernode `s`.
    pub(crate) fn nodes(&self, s: usize) -> Range<usize> {
        self.first[s] as usize..self.first[s + 1] as usize
    }

    /// The number of nodes of supernode `s`.
    pub(crate) fn width(&self, s: usize) -> usize {
        self.nodes(s).len()
    }

    /// The nodes whose rows are non-zero below supernode `s`, ascending.
    pub(crate) fn below(&self, s: usize) -> &[u32] {
        &self.below[self.below_ptr[s]..self.below_ptr[s + 1]]
    }

    /// Where the values of supernode `s` stand.
    pub(crate) fn values(&self, s: usize) -> Range<usize> {
        self.value_ptr[s]..self.value_ptr[s + 1]
    }

    /// Where the values of the supernodes `range` stand.
    pub(crate) fn values_of(&self, range: &Range<usize>) -> Range<usize> {
        self.value_ptr[range.start]..self.value_ptr[range.end]
    }

    pub(crate) fn n_values(&self) -> usize {
        self.value_ptr[self.n_supernodes()]
    }

    pub(crate) fn children(&self, s: usize) -> &[u32] {
        &self.children[s]
    }

    pub(crate) fn supernode_of(&self, node: usize) -> usize {
        self.supernode_of[node] as usize
    }

    pub(crate) fn parent(&self, s: usize) -> Option<usize> {
        self.below(s).first().map(|&node| self.supernode_of(node as usize))
    }
}

/// The upper triangle by columns, rows ascending.
fn upper_columns(pattern: &BlockPattern) -> (Vec<u32>, Vec<u32>) {
    let (ptr, entries) = strict_columns(pattern);
    let mut col_ptr = vec![0];
    let mut row_idx = Vec::with_capacity(pattern.columns.len());
    for node in 0..pattern.n_rows() {
        let above = &entries[ptr[node]..ptr[node + 1]];
        row_idx.extend(above.iter().map(|&(row, _)| row));
        row_idx.push(node as u32);
        col_ptr.push(row_idx.len() as u32);
    }
    (col_ptr, row_idx)
}

/// Row and slot of the blocks above the diagonal, by columns, rows ascending.
fn strict_columns(pattern: &BlockPattern) -> (Vec<usize>, Vec<(u32, u32)>) {
    let n = pattern.n_rows();
    let mut ptr = vec![0; n + 1];
    let blocks = || {
        (0..n).flat_map(|row| {
            let slots = pattern.row_ptr[row]..pattern.row_ptr[row + 1];
            slots
                .map(move |slot| (row, pattern.columns[slot] as usize, slot))
                .filter(|(row, column, _)| row < column)
        })
    };
    for (_, column, _) in blocks() {
        ptr[column + 1] += 1;
    }
    for i in 0..n {
        ptr[i + 1] += ptr[i];
    }
    let mut next = ptr.clone();
    let mut entries = vec![(0, 0); ptr[n]];
    for (row, column, slot) in blocks() {
        entries[next[column]] = (row as u32, slot as u32);
        next[column] += 1;
    }
    (ptr, entries)
}
