//! Columns of right-hand sides, and products of three of their rows with small blocks.
//!
//! Columns stand row by row, so that what is added to a row of many columns is whole vectors, and
//! sums over rows stay in registers. Sums have a fixed order per column: a column's result depends
//! neither on its neighbours nor on how many vectors are taken at once.

use std::ops::Range;

use pulp::Simd;

/// Columns are padded to a multiple of this: a vector of the widest machine, and a cache line.
const PAD: usize = 8;

/// Columns of right-hand sides or solutions `[n_rows, n_columns]`, row-major and padded, each row
/// starting on a cache line.
#[derive(Default)]
pub(crate) struct Columns {
    data: Vec<f64>,
    offset: usize,
    n_rows: usize,
    stride: usize,
}

impl Columns {
    /// Space for `n_rows × n_columns`; what was there stays there, in no useful order.
    pub(crate) fn reshape(&mut self, n_rows: usize, n_columns: usize) {
        (self.n_rows, self.stride) = (n_rows, n_columns.next_multiple_of(PAD));
        let len = n_rows * self.stride + PAD;
        if self.data.len() < len {
            self.data = vec![0.0; len];
        }
        // where the allocator can't tell, rows are only slower
        self.offset = self.data.as_ptr().align_offset(64).min(PAD);
    }

    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.data[self.offset..self.offset + self.n_rows * self.stride]
    }

    pub(crate) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.data[self.offset..self.offset + self.n_rows * self.stride]
    }

    /// The values of one row, padding included.
    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.values()[row * self.stride..(row + 1) * self.stride]
    }

    pub(crate) fn rows_mut(&mut self, rows: Range<usize>) -> &mut [f64] {
        let stride = self.stride;
        &mut self.values_mut()[rows.start * stride..rows.end * stride]
    }
}

/// Calls `$body` for runs of vectors that cover 0..$n: `$at` their first, `$N` their number.
macro_rules! for_vectors {
    ($simd:ident, $n:expr, |$at:ident, $N:ident| $body:expr) => {{
        let mut $at = 0;
        if $simd.is_wide() {
            const $N: usize = 8;
            while $at + $N <= $n {
                $body;
                $at += $N;
            }
        }
        {
            const $N: usize = 4;
            while $at + $N <= $n {
                $body;
                $at += $N;
            }
        }
        const $N: usize = 1;
        while $at < $n {
            $body;
            $at += $N;
        }
    }};
}
pub(crate) use for_vectors;

/// Whether 24 sums and what they are made of fit in the registers.
pub(crate) trait Wide {
    fn is_wide(&self) -> bool;
}

impl<S: Simd> Wide for S {
    #[inline(always)]
    fn is_wide(&self) -> bool {
        S::REGISTER_COUNT >= 32
    }
}

/// Three rows of `N` vectors.
pub(crate) type Three<S, const N: usize> = [[<S as Simd>::f64s; N]; 3];

#[inline(always)]
pub(crate) fn zero<S: Simd, const N: usize>(simd: S) -> Three<S, N> {
    [[simd.splat_f64s(0.0); N]; 3]
}

/// Vectors `at..at + N` of the three rows that `rows` begins with, `n` vectors each.
#[inline(always)]
pub(crate) fn load<S: Simd, const N: usize>(rows: &[S::f64s], n: usize, at: usize) -> Three<S, N> {
    std::array::from_fn(|r| {
        let row = &rows[r * n + at..r * n + at + N];
        std::array::from_fn(|v| row[v])
    })
}

#[inline(always)]
pub(crate) fn store<S: Simd, const N: usize>(
    sums: &Three<S, N>,
    rows: &mut [S::f64s],
    n: usize,
    at: usize,
) {
    for r in 0..3 {
        rows[r * n + at..r * n + at + N].copy_from_slice(&sums[r]);
    }
}

/// sums += a · row, with one coefficient per sum.
#[inline(always)]
pub(crate) fn add_row<S: Simd, const N: usize>(
    simd: S,
    sums: &mut Three<S, N>,
    a: [f64; 3],
    row: &[S::f64s],
) {
    let a = a.map(|a| simd.splat_f64s(a));
    let row = &row[..N];
    for v in 0..N {
        let x = row[v];
        for r in 0..3 {
            sums[r][v] = simd.mul_add_e_f64s(a[r], x, sums[r][v]);
        }
    }
}
