//! Tiles of products by AVX-512 BF16: one instruction adds two products to each of 16 sums.

#![expect(
    unsafe_code,
    reason = "vector loads and calls of functions that need a processor's extension; each says why \
              it is sound"
)]

use std::arch::x86_64::{
    __m512bh, __m512i, _mm512_dpbf16_ps, _mm512_loadu_ps, _mm512_loadu_si512, _mm512_set1_epi32,
    _mm512_setzero_ps, _mm512_storeu_ps,
};

use super::{GROUP_PAIRS, LeftGroup, RightGroup, TILE_COLUMNS, TILE_ROWS, Target};

/// Rows whose sums fill 24 of the 32 registers.
const ROWS: usize = 8;

/// Proof that the processor has AVX-512 with bfloat16.
#[derive(Clone, Copy, Debug)]
pub(in crate::train) struct Dot(());

impl Dot {
    pub(super) fn detect() -> Option<Self> {
        let has_all = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512bf16");
        has_all.then_some(Self(()))
    }

    /// The target takes the sum over the groups of products of rows and columns.
    pub(super) fn multiply(self, mut target: Target<'_>, a: &[LeftGroup], b: &[RightGroup]) {
        if target.is_whole() {
            self.multiply_whole(target, a, b);
            return;
        }
        let mut tile = [[0.0; TILE_COLUMNS]; TILE_ROWS];
        target.read(&mut tile);
        let whole = Target {
            rows: tile.as_flattened_mut(),
            columns: TILE_COLUMNS,
            at: 0,
            is_first: target.is_first,
        };
        self.multiply_whole(whole, a, b);
        target.write(&tile);
    }

    fn multiply_whole(self, target: Target<'_>, a: &[LeftGroup], b: &[RightGroup]) {
        let strips = target.rows.chunks_exact_mut(ROWS * target.columns);
        for (i, rows) in strips.enumerate() {
            let strip = Target { rows, ..target };
            // SAFETY: `Dot` exists only where `detect` found the extensions.
            unsafe { add(strip, a, i * ROWS, b) }
        }
    }
}

/// Adds the products of [`ROWS`] rows from `first` on.
#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn add(target: Target<'_>, a: &[LeftGroup], first: usize, b: &[RightGroup]) {
    let columns = target.at..target.at + TILE_COLUMNS;
    let mut sums = [[_mm512_setzero_ps(); 3]; ROWS];
    if !target.is_first {
        let rows = target.rows.chunks_exact(target.columns);
        for (row, sums) in rows.zip(&mut sums) {
            for (lanes, sum) in row[columns.clone()].as_chunks::<16>().0.iter().zip(sums) {
                // SAFETY: `lanes` are 16 numbers, which is what the load reads.
                *sum = unsafe { _mm512_loadu_ps(lanes.as_ptr()) };
            }
        }
    }
    for (a, b) in a.iter().zip(b) {
        let a = &a[first..first + ROWS];
        for pair in 0..GROUP_PAIRS {
            let b = [0, 16, 32].map(|at| {
                let lanes: &[u32] = &b[pair][at..at + 16];
                // SAFETY: `lanes` are 16 words, which is what the load reads; it needs no
                // alignment.
                pairs(unsafe { _mm512_loadu_si512(lanes.as_ptr().cast()) })
            });
            for (sums, a) in sums.iter_mut().zip(a) {
                let a = pairs(_mm512_set1_epi32(a[pair].cast_signed()));
                for (sum, b) in sums.iter_mut().zip(b) {
                    *sum = _mm512_dpbf16_ps(*sum, a, b);
                }
            }
        }
    }
    let rows = target.rows.chunks_exact_mut(target.columns);
    for (row, sums) in rows.zip(sums) {
        for (lanes, sum) in row[columns.clone()].as_chunks_mut::<16>().0.iter_mut().zip(sums) {
            // SAFETY: `lanes` are 16 numbers, which is what the store writes.
            unsafe { _mm512_storeu_ps(lanes.as_mut_ptr(), sum) }
        }
    }
}

/// 16 words as 16 pairs.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn pairs(words: __m512i) -> __m512bh {
    // SAFETY: both types are 512 bits, and every pattern of bits is valid in both.
    unsafe { std::mem::transmute(words) }
}
