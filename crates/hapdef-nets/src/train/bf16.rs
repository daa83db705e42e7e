//! Products of matrices rounded to bfloat16, summed in 32 bits, where the processor multiplies them
//! itself (AVX-512 BF16): twice the rate of products in 32 bits.
//!
//! bfloat16 is the upper half of an f32: the same range, 8 significant bits. One instruction adds
//! two products to a sum, so two neighbours along the summed direction (a pair) share a 32-bit
//! word. [`Left`] holds 8 rows to a panel and [`Right`] 48 columns, pair after pair: a tile of
//! 8 × 48 sums fills 24 of the 32 registers and reads both panels straight through.
//!
//! Every sum runs over the pairs in one order, in blocks of a fixed number, whatever the threads
//! do: a product has the same bits on any number of threads.

#![expect(
    unsafe_code,
    reason = "vector loads and calls of functions that need a processor's extension; every one is \
              in this file, and each says why it is sound"
)]

use std::arch::x86_64::{
    __m512bh, __m512i, _mm512_add_ps, _mm512_dpbf16_ps, _mm512_loadu_ps, _mm512_loadu_si512,
    _mm512_set1_epi32, _mm512_setzero_ps, _mm512_storeu_ps,
};

use rayon::prelude::*;

use crate::train::view::View;

/// Rows of a tile.
pub(super) const TILE_ROWS: usize = 8;

/// Columns of a tile: three registers.
pub(super) const TILE_COLUMNS: usize = 48;

/// Pairs summed in registers before a tile is added to the result.
const BLOCK_PAIRS: usize = 256;

/// Panels that one thread packs between two looks for more work.
const PACK_GRAIN: usize = 4;

/// The left matrix of a product.
#[derive(Default)]
pub(super) struct Left {
    panels: Vec<[u32; TILE_ROWS]>,
    n_pairs: usize,
}

/// The right matrix of a product.
#[derive(Default)]
pub(super) struct Right {
    panels: Vec<[u32; TILE_COLUMNS]>,
    n_pairs: usize,
}

/// Proof that the processor has the instructions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bf16Unit(());

impl Bf16Unit {
    /// The unit, if the processor has one.
    pub(super) fn detect() -> Option<Self> {
        let has_all = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512bf16");
        has_all.then_some(Self(()))
    }

    /// Packs `[rows, depth]` as the left matrix.
    pub(super) fn pack_left(self, left: &mut Left, matrix: View<'_>) {
        left.n_pairs = matrix.columns.div_ceil(2);
        self.pack(&mut left.panels, matrix, left.n_pairs);
    }

    /// Packs `[columns, depth]`, that is the transpose of the right matrix.
    pub(super) fn pack_right(self, right: &mut Right, matrix: View<'_>) {
        right.n_pairs = matrix.columns.div_ceil(2);
        self.pack(&mut right.panels, matrix, right.n_pairs);
    }

    /// Packs a matrix into panels of `N` of its rows, pair after pair along its columns, 0 beyond
    /// its ends.
    fn pack<const N: usize>(self, panels: &mut Vec<[u32; N]>, matrix: View<'_>, n_pairs: usize) {
        panels.resize(matrix.rows.div_ceil(N) * n_pairs, [0; N]);
        let panels = panels.par_chunks_exact_mut(n_pairs.max(1)).enumerate();
        panels.with_min_len(PACK_GRAIN).for_each(|(i, panel)| {
            let rows = i * N..((i + 1) * N).min(matrix.rows);
            // SAFETY: `Bf16Unit` exists only where `detect` found the extensions.
            unsafe {
                if matrix.transposed {
                    pack_columns(panel, matrix, rows);
                } else {
                    pack_rows(panel, matrix, rows);
                }
            }
        });
    }

    /// `out`, `[rows, columns]` row-major, becomes the product of `rows` rows of `left`, from row
    /// `first_row` on (a multiple of [`TILE_ROWS`]), and `right`.
    pub(super) fn multiply(
        self,
        left: &Left,
        first_row: usize,
        right: &Right,
        columns: usize,
        out: &mut [f32],
    ) {
        // SAFETY: `Bf16Unit` exists only where `detect` found the extensions.
        unsafe { multiply(left, first_row, right, columns, out) }
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn multiply(left: &Left, first_row: usize, right: &Right, columns: usize, out: &mut [f32]) {
    let n_pairs = left.n_pairs;
    let rows_of_panels = &left.panels[first_row / TILE_ROWS * n_pairs..];
    for from in (0..n_pairs).step_by(BLOCK_PAIRS) {
        let pairs = from..(from + BLOCK_PAIRS).min(n_pairs);
        for (j, b) in right.panels.chunks_exact(n_pairs).enumerate() {
            let b = &b[pairs.clone()];
            let panels = rows_of_panels.chunks_exact(n_pairs);
            for (rows, a) in out.chunks_mut(TILE_ROWS * columns).zip(panels) {
                let a = &a[pairs.clone()];
                let tile = tile(a, b);
                let at = j * TILE_COLUMNS;
                add_tile(&tile, rows, columns, at, from == 0);
            }
        }
    }
}

/// Sums of the products of one panel each, over the same pairs.
#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn tile(a: &[[u32; TILE_ROWS]], b: &[[u32; TILE_COLUMNS]]) -> [[f32; TILE_COLUMNS]; TILE_ROWS] {
    let mut sums = [[_mm512_setzero_ps(); 3]; TILE_ROWS];
    for (a, b) in a.iter().zip(b) {
        let b = [0, 16, 32].map(|at| {
            let lanes: &[u32] = &b[at..at + 16];
            // SAFETY: `lanes` are 16 words, which is what the load reads; it needs no alignment.
            pairs(unsafe { _mm512_loadu_si512(lanes.as_ptr().cast()) })
        });
        for (sums, a) in sums.iter_mut().zip(a) {
            let a = pairs(_mm512_set1_epi32(a.cast_signed()));
            for (sum, b) in sums.iter_mut().zip(b) {
                *sum = _mm512_dpbf16_ps(*sum, a, b);
            }
        }
    }
    let mut tile = [[0.0; TILE_COLUMNS]; TILE_ROWS];
    for (row, sums) in tile.iter_mut().zip(sums) {
        for (lanes, sum) in row.as_chunks_mut::<16>().0.iter_mut().zip(sums) {
            // SAFETY: `lanes` are 16 numbers, which is what the store writes.
            unsafe { _mm512_storeu_ps(lanes.as_mut_ptr(), sum) }
        }
    }
    tile
}

/// 16 words as 16 pairs.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn pairs(words: __m512i) -> __m512bh {
    // SAFETY: both types are 512 bits, and every pattern of bits is valid in both.
    unsafe { std::mem::transmute(words) }
}

/// Adds a tile to rows of the result at column `at`, or sets them to it; what lies beyond the
/// result is left out.
#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn add_tile(
    tile: &[[f32; TILE_COLUMNS]; TILE_ROWS],
    rows: &mut [f32],
    columns: usize,
    at: usize,
    is_first: bool,
) {
    let width = TILE_COLUMNS.min(columns - at);
    for (row, sums) in rows.chunks_exact_mut(columns).zip(tile) {
        let row = &mut row[at..at + width];
        if is_first {
            row.copy_from_slice(&sums[..width]);
        } else {
            add(row, &sums[..width]);
        }
    }
}

#[target_feature(enable = "avx512f")]
fn add(row: &mut [f32], sums: &[f32]) {
    let (row, row_rest) = row.as_chunks_mut::<16>();
    let (sums, sums_rest) = sums.as_chunks::<16>();
    for (row, sums) in row.iter_mut().zip(sums) {
        // SAFETY: both are 16 numbers, which is what the loads read and the store writes.
        unsafe {
            let sum = _mm512_add_ps(
                _mm512_loadu_ps(row.as_ptr()),
                _mm512_loadu_ps(sums.as_ptr()),
            );
            _mm512_storeu_ps(row.as_mut_ptr(), sum);
        }
    }
    row_rest
        .iter_mut()
        .zip(sums_rest)
        .for_each(|(r, s)| *r += s);
}

/// A panel of rows that are contiguous.
#[target_feature(enable = "avx512f,avx512bw")]
fn pack_rows<const N: usize>(
    panel: &mut [[u32; N]],
    matrix: View<'_>,
    rows: std::ops::Range<usize>,
) {
    if rows.len() < N {
        panel.fill([0; N]);
    }
    for (lane, row) in rows.enumerate() {
        let row = &matrix.values()[row * matrix.columns..(row + 1) * matrix.columns];
        let (pairs, rest) = row.as_chunks::<2>();
        let last = rest.first().map(|last| [*last, 0.0]);
        for (words, [a, b]) in panel.iter_mut().zip(pairs.iter().copied().chain(last)) {
            words[lane] = word(a, b);
        }
    }
}

/// A panel of rows of which the values of one column are contiguous.
#[target_feature(enable = "avx512f,avx512bw")]
fn pack_columns<const N: usize>(
    panel: &mut [[u32; N]],
    matrix: View<'_>,
    rows: std::ops::Range<usize>,
) {
    let zeros = [0.0; N];
    let column = |c: usize| match c < matrix.columns {
        true => &matrix.values()[c * matrix.rows + rows.start..c * matrix.rows + rows.end],
        false => &zeros[..rows.len()],
    };
    for (pair, words) in panel.iter_mut().enumerate() {
        let (a, b) = (column(2 * pair), column(2 * pair + 1));
        words[a.len()..].fill(0);
        for ((word_, a), b) in words.iter_mut().zip(a).zip(b) {
            *word_ = word(*a, *b);
        }
    }
}

/// Two numbers rounded to bfloat16, the first in the lower half.
#[inline]
fn word(a: f32, b: f32) -> u32 {
    rounded(a) >> 16 | rounded(b) & 0xffff_0000
}

/// The bits of a number with the upper half rounded to nearest, ties to even. The lower half is
/// left as it comes.
#[inline]
fn rounded(value: f32) -> u32 {
    let bits = value.to_bits();
    bits.wrapping_add(0x7fff + (bits >> 16 & 1))
}
