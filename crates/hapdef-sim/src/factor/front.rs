//! The dense work of a multifrontal factorisation (Duff and Reid, ACM Trans. Math. Softw. 9, 1983):
//! a supernode's front, its elimination, and the update it leaves for its parent.
//!
//! Fronts are cut in tiles of fixed size, and each tile is computed by one thread alone: the result
//! is the same bit for bit on any number of threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot;
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::default;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Columns eliminated together.
const PANEL: usize = 96;

/// Rows or columns of a tile.
const TILE: usize = 192;

/// The lower triangle of what a supernode's elimination leaves for its parent: three columns per
/// node, each from its node's first row on.
pub(crate) type Update = Vec<f64>;

/// Space for fronts, used again and again.
pub(crate) struct Front {
    values: Vec<f64>,
    size: usize,
    memory: MemBuffer,
    /// Whether tiles go to the thread pool.
    parallel: bool,
}

impl Front {
    pub(crate) fn new(parallel: bool) -> Self {
        Self {
            values: Vec::new(),
            size: 0,
            memory: MemBuffer::new(cholesky_in_place_scratch::<f64>(PANEL, Par::Seq, default())),
            parallel,
        }
    }

    /// Starts a front of `size` rows with a lower triangle of zeros.
    pub(crate) fn start(&mut self, size: usize) {
        self.size = size;
        if self.values.len() < size * size {
            self.values.clear();
            self.values.resize(size * size, 0.0);
            return;
        }
        for j in 0..size {
            // a node's three rows stand together: the block on the diagonal is read as a whole
            self.values[j * size + j - j % 3..(j + 1) * size].fill(0.0);
        }
    }

    /// Column `j` of the front.
    pub(crate) fn column(&self, j: usize) -> &[f64] {
        &self.values[j * self.size..(j + 1) * self.size]
    }

    pub(crate) fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.values[j * self.size..(j + 1) * self.size]
    }

    /// Adds a child's update; `local[i]` is the front's node for the update's node i.
    pub(crate) fn add(&mut self, update: &[f64], local: &[u32]) {
        let mut rest = update;
        for (j, &column) in local.iter().enumerate() {
            for c in 0..3 {
                let (values, later) = rest.split_at(3 * (local.len() - j));
                rest = later;
                let target = self.column_mut(3 * column as usize + c);
                for (three, &row) in values.chunks_exact(3).zip(&local[j..]) {
                    let row = 3 * row as usize;
                    for (t, v) in target[row..row + 3].iter_mut().zip(three) {
                        *t += v;
                    }
                }
            }
        }
    }

    /// Eliminates the first `width` columns; the error is the column with a bad pivot.
    pub(crate) fn eliminate(&mut self, width: usize) -> Result<(), usize> {
        let size = self.size;
        let values = &mut self.values[..size * size];
        let mut front = MatMut::from_column_major_slice_mut(values, size, size);
        for start in (0..width).step_by(PANEL) {
            let end = (start + PANEL).min(width);
            let (done, rest) = front.as_mut().split_at_col_mut(start);
            let done = done.as_ref();
            let own = done.submatrix(start, 0, end - start, start);
            let panel = rest.submatrix_mut(start, 0, size - start, end - start);
            let (mut top, below) = panel.split_at_row_mut(end - start);
            multiply(top.as_mut(), own, own);
            cholesky_in_place(
                top.as_mut(),
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                default(),
            )
            .map_err(|NonPositivePivot { index }| start + index)?;
            let top = top.as_ref();
            let tiles = row_tiles(below, done.subrows(end, size - end));
            for_each(tiles, self.parallel, |(mut tile, done)| {
                multiply(tile.as_mut(), done, own);
                solve_lower_triangular_in_place(top, tile.transpose_mut(), Par::Seq);
            });
        }
        let (done, rest) = front.split_at_col_mut(width);
        let done = done.as_ref().subrows(width, size - width);
        let rest = rest.subrows_mut(width, size - width);
        for_each(column_tiles(rest), self.parallel, |(start, tile)| {
            let rows = tile.nrows();
            let columns = done.subrows(start, tile.ncols());
            multiply(tile, done.subrows(start, rows), columns);
        });
        Ok(())
    }

    /// What elimination of `width` columns left.
    pub(crate) fn update(&self, width: usize) -> Update {
        let n = (self.size - width) / 3;
        let mut update = Vec::with_capacity(9 * n * (n + 1) / 2);
        for j in width..self.size {
            update.extend_from_slice(&self.column(j)[j - (j - width) % 3..]);
        }
        update
    }
}

/// target −= a bᵀ.
fn multiply(target: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    if a.ncols() > 0 {
        matmul(target, Accum::Add, a, b.transpose(), -1.0, Par::Seq);
    }
}

fn row_tiles<'a, 'b>(
    mut rows: MatMut<'a, f64>,
    mut done: MatRef<'b, f64>,
) -> Vec<(MatMut<'a, f64>, MatRef<'b, f64>)> {
    let mut tiles = Vec::new();
    while rows.nrows() > 0 {
        let n = TILE.min(rows.nrows());
        let (tile, rest) = rows.split_at_row_mut(n);
        let (done_tile, done_rest) = done.split_at_row(n);
        tiles.push((tile, done_tile));
        (rows, done) = (rest, done_rest);
    }
    tiles
}

/// Column tiles from the diagonal down, with their first row.
fn column_tiles(mut square: MatMut<'_, f64>) -> Vec<(usize, MatMut<'_, f64>)> {
    let (mut tiles, mut start) = (Vec::new(), 0);
    while square.ncols() > 0 {
        let n = TILE.min(square.ncols());
        let (tile, rest) = square.split_at_col_mut(n);
        tiles.push((start, tile));
        let rows = rest.nrows() - n;
        square = rest.subrows_mut(n, rows);
        start += n;
    }
    tiles
}

fn for_each<T: Send>(tiles: Vec<T>, parallel: bool, work: impl Fn(T) + Sync + Send) {
    if parallel && tiles.len() > 1 {
        tiles.into_par_iter().for_each(work);
    } else {
        tiles.into_iter().for_each(work);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A positive definite matrix of `size` rows, entry (i, j).
    fn entry(i: usize, j: usize, size: usize) -> f64 {
        let off = ((i * 7 + j * 7 + i * j) % 11) as f64 / 11.0;
        if i == j { size as f64 } else { off }
    }

    #[test]
    fn elimination_leaves_the_schur_complement_the_same_on_one_and_two_threads() {
        let (size, width) = (615, 240);
        let run = |parallel| {
            let mut front = Front::new(parallel);
            front.start(size);
            for j in 0..size {
                for i in 0..size {
                    front.column_mut(j)[i] = entry(i, j, size);
                }
            }
            front.eliminate(width).unwrap();
            front
        };
        let front = run(false);
        let mut worst = 0.0_f64;
        for (i, j) in [(240, 240), (614, 240), (614, 614), (400, 300), (239, 7)] {
            let product: f64 =
                (0..width.min(j + 1)).map(|k| front.column(k)[i] * front.column(k)[j]).sum();
            let left = if j < width { 0.0 } else { front.column(j)[i] };
            worst = worst.max((product + left - entry(i, j, size)).abs());
        }
        assert!(worst < 1e-11, "{worst:e}");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
        let twice = pool.unwrap().install(|| run(true));
        assert_eq!(front.update(width), twice.update(width));
        assert_eq!(front.column(100)[100..], twice.column(100)[100..]);
    }

    #[test]
    fn a_bad_pivot_is_named() {
        let mut front = Front::new(false);
        front.start(150);
        for j in 0..150 {
            front.column_mut(j)[j] = if j == 120 { -1.0 } else { 1.0 };
        }
        assert_eq!(front.eliminate(150), Err(120));
    }
}
