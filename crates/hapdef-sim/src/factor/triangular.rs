//! Solves with the factor, for a block of right-hand sides at once.

use pulp::{Arch, Simd, WithSimd};

use crate::factor::cholesky::{Analysis, Factor};
use crate::factor::panel::{Columns, Three, Wide as _, add_row, for_vectors, load, store};

/// Nodes of a supernode solved before their rows are used: 48 rows of 64 columns fit the first
/// cache.
const PANEL: usize = 16;

/// Nodes whose rows are used for all columns of a panel in turn: their rows fit the second cache.
const ROWS: usize = 64;

impl Factor {
    /// The supernodes on the paths from the nodes `touched` to the root of the elimination tree.
    pub(crate) fn reached(&self, touched: impl Iterator<Item = usize>) -> Vec<bool> {
        let mut reached = vec![false; self.analysis.n_supernodes()];
        for node in touched {
            reached[self.analysis.supernode_of(node)] = true;
        }
        for s in 0..reached.len() {
            if reached[s]
                && let Some(parent) = self.analysis.parent(s)
            {
                reached[parent] = true;
            }
        }
        reached
    }

    /// Sets the rows of all `reached` supernodes to zero.
    pub(crate) fn clear(&self, x: &mut Columns, reached: &[bool]) {
        for s in (0..reached.len()).filter(|&s| reached[s]) {
            let nodes = self.analysis.nodes(s);
            x.rows_mut(3 * nodes.start..3 * nodes.end).fill(0.0);
        }
    }

    /// Entries of L in the given supernodes, as stored.
    pub(crate) fn n_entries(&self, supernodes: &[bool]) -> usize {
        let given = (0..supernodes.len()).filter(|&s| supernodes[s]);
        given.map(|s| self.analysis.values(s).len()).sum()
    }

    /// Solves K x = b in place. Rows of supernodes that are not `reached` hold no right-hand side,
    /// whatever stands there; only rows of the `wanted` supernodes hold the solution afterwards.
    /// Both are closed towards the root: a row of Lᵀ x = y needs its ancestors, and nothing else.
    pub(crate) fn solve_in_place(&self, x: &mut Columns, reached: &[bool], wanted: &[bool]) {
        let stride = x.stride();
        Arch::new().dispatch(Solve { factor: self, x: x.values_mut(), stride, reached, wanted });
    }
}

struct Solve<'a> {
    factor: &'a Factor,
    x: &'a mut [f64],
    stride: usize,
    reached: &'a [bool],
    wanted: &'a [bool],
}

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let x = S::as_mut_simd_f64s(self.x).0;
        let n = self.stride / S::F64_LANES;
        let analysis = &*self.factor.analysis;
        let supernode = |s| Supernode::of(analysis, &self.factor.values, s);
        for s in (0..self.reached.len()).filter(|&s| self.reached[s]) {
            supernode(s).forward(simd, x, n);
        }
        for s in (0..self.wanted.len()).rev().filter(|&s| self.wanted[s]) {
            let supernode = supernode(s);
            if !self.reached[s] {
                let rows = 3 * supernode.first * n..3 * (supernode.first + supernode.width) * n;
                x[rows].fill(simd.splat_f64s(0.0));
            }
            supernode.backward(simd, x, n);
        }
    }
}

#[derive(Clone, Copy)]
struct Supernode<'a> {
    first: usize,
    width: usize,
    below: &'a [u32],
    /// −L and 1/L of its own rows.
    top: &'a [f64],
    /// −L of the rows below.
    bottom: &'a [f64],
}

impl<'a> Supernode<'a> {
    #[inline(always)]
    fn of(analysis: &'a Analysis, values: &'a [f64], s: usize) -> Self {
        let nodes = analysis.nodes(s);
        let width = nodes.len();
        let (top, bottom) = values[analysis.values(s)].split_at(9 * width * (width + 1) / 2);
        Self { first: nodes.start, width, below: analysis.below(s), top, bottom }
    }

    /// The values of the `i`-th node's rows, up to its own columns.
    #[inline(always)]
    fn own(&self, i: usize) -> &'a [f64] {
        &self.top[9 * (i * (i + 1) / 2)..9 * ((i + 1) * (i + 2) / 2)]
    }

    #[inline(always)]
    fn beneath(&self, i: usize) -> &'a [f64] {
        &self.bottom[9 * i * self.width..9 * (i + 1) * self.width]
    }

    /// x ← L⁻¹ x as far as this supernode's columns go; rows of `n` vectors.
    #[inline(always)]
    fn forward<S: Simd>(&self, simd: S, x: &mut [S::f64s], n: usize) {
        let (head, later) = x.split_at_mut(3 * (self.first + self.width) * n);
        let own = &mut head[3 * self.first * n..];
        for start in (0..self.width).step_by(PANEL) {
            let end = (start + PANEL).min(self.width);
            let (panel, rest) = own[3 * start * n..].split_at_mut(3 * (end - start) * n);
            for i in start..end {
                let (known, target) = panel.split_at_mut(3 * (i - start) * n);
                let (l, diagonal) = self.own(i)[9 * start..].split_at(9 * (i - start));
                subtract(simd, l, known, target, n);
                solve_lower(simd, diagonal, target, n);
            }
            for i in end..self.width {
                let l = &self.own(i)[9 * start..9 * end];
                subtract(simd, l, panel, &mut rest[3 * (i - end) * n..], n);
            }
            for (i, &node) in self.below.iter().enumerate() {
                let l = &self.beneath(i)[9 * start..9 * end];
                let row = 3 * (node as usize - self.first - self.width) * n;
                subtract(simd, l, panel, &mut later[row..], n);
            }
        }
    }

    /// x ← L⁻ᵀ x as far as this supernode's rows go; rows of `n` vectors.
    #[inline(always)]
    fn backward<S: Simd>(&self, simd: S, x: &mut [S::f64s], n: usize) {
        let (head, later) = x.split_at_mut(3 * (self.first + self.width) * n);
        let own = &mut head[3 * self.first * n..];
        for start in (0..self.width).step_by(PANEL).rev() {
            let end = (start + PANEL).min(self.width);
            let (panel, rest) = own[3 * start * n..].split_at_mut(3 * (end - start) * n);
            for rows in chunks(end..self.width) {
                for column in start..end {
                    let known = rows.clone().map(|i| {
                        let l = &self.own(i)[9 * column..9 * column + 9];
                        (l, &rest[3 * (i - end) * n..3 * (i - end + 1) * n])
                    });
                    subtract_transposed(simd, known, &mut panel[3 * (column - start) * n..], n);
                }
            }
            for rows in chunks(0..self.below.len()) {
                for column in start..end {
                    let known = rows.clone().map(|i| {
                        let l = &self.beneath(i)[9 * column..9 * column + 9];
                        let row = 3 * (self.below[i] as usize - self.first - self.width) * n;
                        (l, &later[row..row + 3 * n])
                    });
                    subtract_transposed(simd, known, &mut panel[3 * (column - start) * n..], n);
                }
            }
            for column in (start..end).rev() {
                let (target, known) = panel[3 * (column - start) * n..].split_at_mut(3 * n);
                let known = (column + 1..end).map(|i| {
                    let l = &self.own(i)[9 * column..9 * column + 9];
                    let row = 3 * (i - column - 1) * n;
                    (l, &known[row..row + 3 * n])
                });
                subtract_transposed(simd, known, target, n);
                solve_upper(simd, &self.own(column)[9 * column..], target, n);
            }
        }
    }
}

/// `range` in pieces of [`ROWS`].
#[inline(always)]
fn chunks(range: std::ops::Range<usize>) -> impl Iterator<Item = std::ops::Range<usize>> {
    let end = range.end;
    range.step_by(ROWS).map(move |start| start..(start + ROWS).min(end))
}

/// target −= L known for three rows; `l` is −L as `[column][row]`.
#[inline(always)]
fn subtract<S: Simd>(simd: S, l: &[f64], known: &[S::f64s], target: &mut [S::f64s], n: usize) {
    if l.is_empty() {
        return;
    }
    for_vectors!(simd, n, |at, N| {
        let mut sums: Three<S, N> = load::<S, N>(target, n, at);
        for (l, row) in l.chunks_exact(3).zip(known.chunks_exact(n)) {
            add_row(simd, &mut sums, [l[0], l[1], l[2]], &row[at..]);
        }
        store::<S, N>(&sums, target, n, at);
    });
}

/// target −= Lᵀ known for three columns; each of `known` is −L of a node's rows as
/// `[column][row]`, and those rows.
#[inline(always)]
fn subtract_transposed<'a, S: Simd>(
    simd: S,
    known: impl Iterator<Item = (&'a [f64], &'a [S::f64s])> + Clone,
    target: &mut [S::f64s],
    n: usize,
) {
    for_vectors!(simd, n, |at, N| {
        let mut sums: Three<S, N> = load::<S, N>(target, n, at);
        for (l, rows) in known.clone() {
            for (r, row) in rows.chunks_exact(n).enumerate() {
                add_row(simd, &mut sums, [l[r], l[3 + r], l[6 + r]], &row[at..]);
            }
        }
        store::<S, N>(&sums, target, n, at);
    });
}

/// target ← L⁻¹ target for the three rows on the diagonal.
#[inline(always)]
fn solve_lower<S: Simd>(simd: S, l: &[f64], target: &mut [S::f64s], n: usize) {
    let at = |i: usize| simd.splat_f64s(l[i]);
    for v in 0..n {
        let x0 = simd.mul_f64s(at(0), target[v]);
        let x1 = simd.mul_add_e_f64s(at(1), x0, target[n + v]);
        let x1 = simd.mul_f64s(at(4), x1);
        let x2 = simd.mul_add_e_f64s(at(2), x0, target[2 * n + v]);
        let x2 = simd.mul_f64s(at(8), simd.mul_add_e_f64s(at(5), x1, x2));
        (target[v], target[n + v], target[2 * n + v]) = (x0, x1, x2);
    }
}

/// target ← L⁻ᵀ target for the three rows on the diagonal.
#[inline(always)]
fn solve_upper<S: Simd>(simd: S, l: &[f64], target: &mut [S::f64s], n: usize) {
    let at = |i: usize| simd.splat_f64s(l[i]);
    for v in 0..n {
        let x2 = simd.mul_f64s(at(8), target[2 * n + v]);
        let x1 = simd.mul_add_e_f64s(at(5), x2, target[n + v]);
        let x1 = simd.mul_f64s(at(4), x1);
        let x0 = simd.mul_add_e_f64s(at(1), x1, target[v]);
        let x0 = simd.mul_f64s(at(0), simd.mul_add_e_f64s(at(2), x2, x0));
        (target[v], target[n + v], target[2 * n + v]) = (x0, x1, x2);
    }
}
