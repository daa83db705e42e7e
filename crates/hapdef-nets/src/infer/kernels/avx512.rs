//! 512-bit vectors.

use std::arch::x86_64::{
    __m512, __m512i, _mm_load_si128, _mm512_cvtepi8_epi32, _mm512_cvtepi32_ps, _mm512_dpbusd_epi32,
    _mm512_fmadd_ps, _mm512_load_ps, _mm512_load_si512, _mm512_set1_epi32, _mm512_set1_ps,
    _mm512_setzero_si512, _mm512_store_ps, _mm512_store_si512, _mm512_unpackhi_epi8,
    _mm512_unpackhi_epi16, _mm512_unpacklo_epi8, _mm512_unpacklo_epi16,
};

use super::super::panels::{F32Line, I32Line, Int8Line, Line, Panels};
use super::super::quantise::ByteScale;
use super::{Active, ActiveBytes, avx2, elements};

type Vector = __m512;

float_kernels!(#[target_feature(enable = "avx512f,avx2,fma")]);
elements!(#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma")]);

/// Fours of inputs that are added to the sums of a unit while these are in registers.
const BLOCK: usize = 4;

/// Sums of byte products without the instruction for them.
#[target_feature(enable = "avx512f,avx2,fma")]
pub(super) fn bytes<const P: usize>(w: &Panels<Int8Line>, x: ActiveBytes<'_>, out: &mut [I32Line]) {
    avx2::bytes::<P>(w, x, out);
}

/// Sums of byte products, four in one instruction.
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
pub(super) fn bytes_vnni<const P: usize>(
    w: &Panels<Int8Line>,
    x: ActiveBytes<'_>,
    out: &mut [I32Line],
) {
    let last_row = x.rows.iter().fold(0, |last, row| last.max(*row));
    assert!((last_row as usize) < w.n_rows(), "rows of weights");
    for (unit, width, lines) in w.iter() {
        let out = &mut out[4 * P * unit..4 * P * (unit + width)];
        out.fill(Line([0; 16]));
        for block in x.blocks(BLOCK) {
            for (u, sums) in out.chunks_exact_mut(4 * P).enumerate() {
                let unit = lines[u..].as_ptr();
                // SAFETY: `lines` are n_rows × width lines; every row is below n_rows, u below width.
                unsafe { add_block::<P>(unit, width, block, sums) }
            }
        }
        for sums in out.as_chunks_mut::<4>().0 {
            in_order(sums);
        }
    }
}

/// Adds a block of inputs to the sums of one unit.
///
/// # Safety
/// `width` lines after `first` there is the next row's, and so on up to the last row of the block.
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
#[inline]
unsafe fn add_block<const P: usize>(
    first: *const Int8Line,
    width: usize,
    block: ActiveBytes<'_>,
    out: &mut [I32Line],
) {
    let mut sums = [[_mm512_setzero_si512(); 4]; P];
    for (sum, line) in sums.as_flattened_mut().iter_mut().zip(&*out) {
        *sum = i32_line(line);
    }
    for (rows, words) in block.fours() {
        let [a, b, c, d] = rows.map(|row| {
            // SAFETY: the caller's promise.
            int8_line(unsafe { &*first.add(row as usize * width) })
        });
        let [low, high] = [_mm512_unpacklo_epi8(a, b), _mm512_unpackhi_epi8(a, b)];
        let [low_2, high_2] = [_mm512_unpacklo_epi8(c, d), _mm512_unpackhi_epi8(c, d)];
        let weights = [
            _mm512_unpacklo_epi16(low, low_2),
            _mm512_unpackhi_epi16(low, low_2),
            _mm512_unpacklo_epi16(high, high_2),
            _mm512_unpackhi_epi16(high, high_2),
        ];
        for (sums, word) in sums.iter_mut().zip(words) {
            let bytes = _mm512_set1_epi32(word);
            for (sum, weights) in sums.iter_mut().zip(weights) {
                *sum = _mm512_dpbusd_epi32(*sum, bytes, weights);
            }
        }
    }
    for (line, sum) in out.iter_mut().zip(sums.as_flattened()) {
        let line: *mut I32Line = line;
        // SAFETY: the line is 64 bytes of whole numbers, aligned to 64, and borrowed mutably.
        unsafe { _mm512_store_si512(line.cast(), *sum) };
    }
}

/// Puts four lines of sums in the order of the outputs: the unpacking above keeps to lanes of 16 bytes,
/// so line k has the k-th four sums of every 16.
fn in_order(sums: &mut [I32Line; 4]) {
    let found = *sums;
    for (k, line) in found.iter().enumerate() {
        for (lane, four) in line.0.as_chunks::<4>().0.iter().enumerate() {
            sums[lane].0[4 * k..4 * k + 4].copy_from_slice(four);
        }
    }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn splat(value: f32) -> Vector {
    _mm512_set1_ps(value)
}

#[target_feature(enable = "avx512f")]
#[inline]
fn fma(a: Vector, b: Vector, c: Vector) -> Vector {
    _mm512_fmadd_ps(a, b, c)
}

#[target_feature(enable = "avx512f")]
#[inline]
fn f32_line(line: &F32Line) -> Vector {
    // SAFETY: a line is 64 readable bytes, aligned to 64.
    unsafe { _mm512_load_ps(line.0.as_ptr()) }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn int8_quarter<const Q: usize>(line: &Int8Line) -> Vector {
    let quarter = &line.0.as_chunks::<16>().0[Q];
    // SAFETY: a quarter of a line is 16 readable bytes, and aligned to 16, as a line is to 64.
    let bytes = unsafe { _mm_load_si128(quarter.as_ptr().cast()) };
    _mm512_cvtepi32_ps(_mm512_cvtepi8_epi32(bytes))
}

#[target_feature(enable = "avx512f")]
#[inline]
fn int8_line(line: &Int8Line) -> __m512i {
    // SAFETY: a line is 64 readable bytes, aligned to 64.
    unsafe { _mm512_load_si512(line.0.as_ptr().cast()) }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn i32_line(line: &I32Line) -> __m512i {
    // SAFETY: a line is 64 readable bytes, aligned to 64.
    unsafe { _mm512_load_si512(line.0.as_ptr().cast()) }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn store(vector: Vector, line: &mut F32Line) {
    // SAFETY: a line is 64 bytes, aligned to 64, and borrowed mutably.
    unsafe { _mm512_store_ps(line.0.as_mut_ptr(), vector) }
}

/// Asks for a line to be fetched to the second cache.
#[target_feature(enable = "avx512f")]
#[inline]
fn prefetch<T>(line: &T) {
    avx2::prefetch(line);
}
