//! Sparse matrices in dense R × C blocks, stored by rows, and their products.
//!
//! Vectors hold K right-hand sides side by side: entry i of all K is `[f64; K]`, so that one pass
//! over the matrix serves them all and each of them sees the same operations in the same order
//! whatever K is. Rows are shared out in fixed blocks: the result never depends on the threads.

use pulp::Arch;
use rayon::prelude::*;

use crate::system::assembly::BlockMatrix;

/// Block rows that one task handles.
const ROWS: usize = 512;

/// One dense block.
pub(super) type Block<const R: usize, const C: usize> = [[f64; C]; R];

/// A sparse matrix of `n_rows` × `n_cols` blocks; columns ascend in each row.
#[derive(Debug)]
pub(super) struct Bsr<const R: usize, const C: usize> {
    pub(super) row_ptr: Vec<usize>,
    pub(super) columns: Vec<u32>,
    pub(super) blocks: Vec<Block<R, C>>,
    pub(super) n_cols: usize,
}

impl Bsr<3, 3> {
    /// Both triangles of `matrix`, with block row `sequence[i]` at place i.
    pub(super) fn from_symmetric(matrix: &BlockMatrix, sequence: &[u32]) -> Self {
        let pattern = &matrix.pattern;
        let mut place = vec![0_u32; sequence.len()];
        for (i, &row) in sequence.iter().enumerate() {
            place[row as usize] = i as u32;
        }
        let mut entries: Vec<(u32, u32, u32)> = Vec::with_capacity(2 * pattern.columns.len());
        for row in 0..pattern.n_rows() {
            for slot in pattern.row_ptr[row]..pattern.row_ptr[row + 1] {
                let column = pattern.columns[slot] as usize;
                entries.push((place[row], place[column], slot as u32));
                if row != column {
                    entries.push((place[column], place[row], slot as u32));
                }
            }
        }
        entries.par_sort_unstable();
        let mut row_ptr = vec![0; sequence.len() + 1];
        for &(row, ..) in &entries {
            row_ptr[row as usize + 1] += 1;
        }
        for i in 0..sequence.len() {
            row_ptr[i + 1] += row_ptr[i];
        }
        let block = |&(i, j, slot): &(u32, u32, u32)| {
            let b = &matrix.blocks[slot as usize];
            let stored = [[b[0], b[1], b[2]], [b[3], b[4], b[5]], [b[6], b[7], b[8]]];
            if sequence[i as usize] <= sequence[j as usize] { stored } else { transposed(&stored) }
        };
        Self {
            row_ptr,
            columns: entries.iter().map(|&(_, column, _)| column).collect(),
            blocks: entries.par_iter().map(block).collect(),
            n_cols: sequence.len(),
        }
    }
}

impl<const R: usize, const C: usize> Bsr<R, C> {
    pub(super) fn n_rows(&self) -> usize {
        self.row_ptr.len() - 1
    }

    /// The columns and blocks of `row`.
    pub(super) fn row(&self, row: usize) -> impl Iterator<Item = (usize, &Block<R, C>)> {
        let range = self.row_ptr[row]..self.row_ptr[row + 1];
        let columns = self.columns[range.clone()].iter().map(|&c| c as usize);
        columns.zip(&self.blocks[range])
    }

    /// y ← A x.
    pub(super) fn multiply<const K: usize>(&self, x: &[[f64; K]], y: &mut [[f64; K]]) {
        self.each_row(x, y, |y, sum| *y = sum);
    }

    /// y ← y − A x.
    pub(super) fn subtract<const K: usize>(&self, x: &[[f64; K]], y: &mut [[f64; K]]) {
        self.each_row(x, y, |y, sum| *y -= sum);
    }

    /// y ← y + A x.
    pub(super) fn add<const K: usize>(&self, x: &[[f64; K]], y: &mut [[f64; K]]) {
        self.each_row(x, y, |y, sum| *y += sum);
    }

    fn each_row<const K: usize>(
        &self,
        x: &[[f64; K]],
        y: &mut [[f64; K]],
        put: impl Fn(&mut f64, f64) + Sync,
    ) {
        let chunks = y.par_chunks_mut(ROWS * R).enumerate();
        chunks.for_each(|(chunk, y)| {
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    for (i, y) in y.chunks_exact_mut(R).enumerate() {
                        let sum = self.row_times(chunk * ROWS + i, x);
                        for (y, sum) in y.iter_mut().zip(&sum) {
                            for l in 0..K {
                                put(&mut y[l], sum[l]);
                            }
                        }
                    }
                },
            );
        });
    }

    #[inline(always)]
    fn row_times<const K: usize>(&self, row: usize, x: &[[f64; K]]) -> [[f64; K]; R] {
        let mut sum = [[0.0; K]; R];
        for (column, block) in self.row(row) {
            let x = &x[column * C..(column + 1) * C];
            for r in 0..R {
                for c in 0..C {
                    for l in 0..K {
                        sum[r][l] += block[r][c] * x[c][l];
                    }
                }
            }
        }
        sum
    }

    /// Aᵀ.
    pub(super) fn transpose(&self) -> Bsr<C, R> {
        let mut row_ptr = vec![0; self.n_cols + 1];
        for &column in &self.columns {
            row_ptr[column as usize + 1] += 1;
        }
        for i in 0..self.n_cols {
            row_ptr[i + 1] += row_ptr[i];
        }
        let mut next = row_ptr.clone();
        let mut columns = vec![0; self.columns.len()];
        let mut blocks = vec![[[0.0; R]; C]; self.columns.len()];
        for row in 0..self.n_rows() {
            for (column, block) in self.row(row) {
                let slot = next[column];
                next[column] += 1;
                columns[slot] = row as u32;
                blocks[slot] = transposed(block);
            }
        }
        Bsr { row_ptr, columns, blocks, n_cols: self.n_rows() }
    }

    /// A B.
    pub(super) fn product<const D: usize>(&self, other: &Bsr<C, D>) -> Bsr<R, D> {
        let n = self.n_rows();
        let starts: Vec<usize> = (0..n).step_by(ROWS).collect();
        let parts: Vec<Bsr<R, D>> = starts
            .par_iter()
            .map_init(
                || vec![u32::MAX; other.n_cols],
                |slot_of, &start| self.product_rows(other, start..n.min(start + ROWS), slot_of),
            )
            .collect();
        let n_blocks = parts.iter().map(|part| part.columns.len()).sum();
        let mut whole = Bsr {
            row_ptr: Vec::with_capacity(n + 1),
            columns: Vec::with_capacity(n_blocks),
            blocks: Vec::with_capacity(n_blocks),
            n_cols: other.n_cols,
        };
        whole.row_ptr.push(0);
        for part in parts {
            let before = whole.columns.len();
            let ends = part.row_ptr.iter().skip(1).map(|end| before + end);
            whole.row_ptr.extend(ends);
            whole.columns.extend(part.columns);
            whole.blocks.extend(part.blocks);
        }
        whole
    }

    /// Rows `rows` of A B; `slot_of` (per column) is `u32::MAX` on entry and on return.
    fn product_rows<const D: usize>(
        &self,
        other: &Bsr<C, D>,
        rows: std::ops::Range<usize>,
        slot_of: &mut [u32],
    ) -> Bsr<R, D> {
        let mut part =
            Bsr { row_ptr: vec![0], columns: Vec::new(), blocks: Vec::new(), n_cols: other.n_cols };
        for row in rows {
            let start = part.columns.len();
            for (middle, _) in self.row(row) {
                for (column, _) in other.row(middle) {
                    if slot_of[column] == u32::MAX {
                        slot_of[column] = 0;
                        part.columns.push(column as u32);
                    }
                }
            }
            part.columns[start..].sort_unstable();
            for (slot, &column) in part.columns[start..].iter().enumerate() {
                slot_of[column as usize] = (start + slot) as u32;
            }
            part.blocks.resize(part.columns.len(), [[0.0; D]; R]);
            for (middle, a) in self.row(row) {
                for (column, b) in other.row(middle) {
                    add_product(a, b, &mut part.blocks[slot_of[column] as usize]);
                }
            }
            for &column in &part.columns[start..] {
                slot_of[column as usize] = u32::MAX;
            }
            part.row_ptr.push(part.columns.len());
        }
        part
    }

    /// Bytes of the arrays.
    pub(super) fn bytes(&self) -> usize {
        8 * (R * C * self.blocks.len() + self.row_ptr.len()) + 4 * self.columns.len()
    }
}

/// c ← c + a b.
#[inline]
pub(super) fn add_product<const R: usize, const C: usize, const D: usize>(
    a: &Block<R, C>,
    b: &Block<C, D>,
    c: &mut Block<R, D>,
) {
    for i in 0..R {
        for j in 0..C {
            for l in 0..D {
                c[i][l] += a[i][j] * b[j][l];
            }
        }
    }
}

fn transposed<const R: usize, const C: usize>(block: &Block<R, C>) -> Block<C, R> {
    std::array::from_fn(|c| std::array::from_fn(|r| block[r][c]))
}
