//! 256-bit vectors with fused multiply-add.

use std::arch::x86_64::{
    __m256, __m256i, _MM_HINT_T0, _mm_load_si128, _mm_loadl_epi64, _mm_prefetch, _mm256_add_epi32,
    _mm256_and_si256, _mm256_castsi256_ps, _mm256_cvtepi8_epi16, _mm256_cvtepi8_epi32,
    _mm256_cvtepi32_ps, _mm256_fmadd_ps, _mm256_hadd_epi32, _mm256_load_ps, _mm256_load_si256,
    _mm256_madd_epi16, _mm256_permute4x64_epi64, _mm256_set1_epi32, _mm256_set1_epi64x,
    _mm256_set1_ps, _mm256_setzero_ps, _mm256_setzero_si256, _mm256_slli_epi32, _mm256_store_ps,
    _mm256_store_si256,
};

use crate::activation::Activation;

use super::super::panels::{Bf16Line, F32Line, I32Line, Int8Line, Panels};
use super::{Active, ActiveGroup};

type Vector = [__m256; 2];

/// Active inputs whose lines are asked for ahead of their use.
const AHEAD: usize = 8;

float_kernels!(4, #[target_feature(enable = "avx2,fma")]);

/// Sums of byte products, by way of 16 bits, which hold every product of two.
#[target_feature(enable = "avx2,fma")]
pub(super) fn groups(w: &Panels<Int8Line>, x: &[ActiveGroup], out: &mut [I32Line]) {
    for (unit, width, lines) in w.iter() {
        let out = &mut out[unit..unit + width];
        let mut first = 0;
        while first < width {
            if width - first >= 2 {
                group_units::<2>(lines, width, first, x, out);
                first += 2;
            } else {
                group_units::<1>(lines, width, first, x, out);
                first += 1;
            }
        }
    }
}

#[target_feature(enable = "avx2,fma")]
#[inline]
fn group_units<const U: usize>(
    lines: &[Int8Line],
    width: usize,
    first: usize,
    x: &[ActiveGroup],
    out: &mut [I32Line],
) {
    let mut sums = [[_mm256_setzero_si256(); 4]; U];
    for active in x {
        let start = active.row as usize * width + first;
        let row = &lines[start..start + U];
        let [a, b, c, d] = active.bytes.map(u64::from);
        let words = _mm256_set1_epi64x((a | b << 16 | c << 32 | d << 48) as i64);
        for u in 0..U {
            for quarter in 0..4 {
                let products = _mm256_madd_epi16(wide_quarter(&row[u], quarter), words);
                sums[u][quarter] = _mm256_add_epi32(sums[u][quarter], products);
            }
        }
    }
    for u in 0..U {
        let [a, b, c, d] = sums[u];
        let (low, high) = out[first + u].0.split_at_mut(8);
        store_pairs(a, b, low);
        store_pairs(c, d, high);
    }
}

/// Adds neighbours of `a` and `b`, each with two sums for each of four outputs.
#[target_feature(enable = "avx2")]
#[inline]
fn store_pairs(a: __m256i, b: __m256i, out: &mut [i32]) {
    let sums = _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_hadd_epi32(a, b));
    let out = &mut out[..8];
    // SAFETY: eight whole numbers, borrowed mutably: half a line, which is aligned to 32.
    unsafe { _mm256_store_si256(out.as_mut_ptr().cast(), sums) }
}

/// 16 bytes of a line as 16-bit numbers.
#[target_feature(enable = "avx2")]
#[inline]
fn wide_quarter(line: &Int8Line, quarter: usize) -> __m256i {
    let bytes = &line.0.as_chunks::<16>().0[quarter];
    // SAFETY: a quarter of a line is 16 readable bytes, and aligned to 16, as a line is to 64.
    _mm256_cvtepi8_epi16(unsafe { _mm_load_si128(bytes.as_ptr().cast()) })
}

#[target_feature(enable = "avx2")]
#[inline]
fn zero() -> Vector {
    [_mm256_setzero_ps(); 2]
}

#[target_feature(enable = "avx2")]
#[inline]
fn splat(value: f32) -> Vector {
    [_mm256_set1_ps(value); 2]
}

#[target_feature(enable = "avx2,fma")]
#[inline]
fn fma(a: Vector, b: Vector, c: Vector) -> Vector {
    [
        _mm256_fmadd_ps(a[0], b[0], c[0]),
        _mm256_fmadd_ps(a[1], b[1], c[1]),
    ]
}

#[target_feature(enable = "avx2")]
#[inline]
fn f32_line(line: &F32Line) -> Vector {
    let [a, b] = halves(&line.0);
    // SAFETY: half a line is 32 readable bytes, aligned to 32.
    unsafe { [_mm256_load_ps(a.as_ptr()), _mm256_load_ps(b.as_ptr())] }
}

#[target_feature(enable = "avx2")]
#[inline]
fn words(line: &Bf16Line) -> [__m256i; 2] {
    let [a, b] = halves(&line.0);
    // SAFETY: half a line is 32 readable bytes, aligned to 32.
    unsafe {
        [
            _mm256_load_si256(a.as_ptr().cast()),
            _mm256_load_si256(b.as_ptr().cast()),
        ]
    }
}

#[target_feature(enable = "avx2")]
#[inline]
fn bf16_low(line: &Bf16Line) -> Vector {
    let [a, b] = words(line);
    [
        _mm256_castsi256_ps(_mm256_slli_epi32::<16>(a)),
        _mm256_castsi256_ps(_mm256_slli_epi32::<16>(b)),
    ]
}

#[target_feature(enable = "avx2")]
#[inline]
fn bf16_high(line: &Bf16Line) -> Vector {
    let [a, b] = words(line);
    let mask = _mm256_set1_epi32(0xffff_0000_u32 as i32);
    [
        _mm256_castsi256_ps(_mm256_and_si256(a, mask)),
        _mm256_castsi256_ps(_mm256_and_si256(b, mask)),
    ]
}

#[target_feature(enable = "avx2")]
#[inline]
fn int8_quarter<const Q: usize>(line: &Int8Line) -> Vector {
    let eighths = line.0.as_chunks::<8>().0;
    let (a, b) = (&eighths[2 * Q], &eighths[2 * Q + 1]);
    // SAFETY: an eighth of a line is 8 readable bytes; this load needs no alignment.
    let (a, b) = unsafe {
        (
            _mm_loadl_epi64(a.as_ptr().cast()),
            _mm_loadl_epi64(b.as_ptr().cast()),
        )
    };
    [
        _mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(a)),
        _mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(b)),
    ]
}

#[target_feature(enable = "avx2")]
#[inline]
fn store(vector: Vector, line: &mut F32Line) {
    let (a, b) = line.0.split_at_mut(8);
    // SAFETY: each is half a line, 32 bytes aligned to 32, and borrowed mutably.
    unsafe {
        _mm256_store_ps(a.as_mut_ptr(), vector[0]);
        _mm256_store_ps(b.as_mut_ptr(), vector[1]);
    }
}

#[inline]
fn halves<T>(line: &[T; 16]) -> [&[T; 8]; 2] {
    let halves = line.as_chunks::<8>().0;
    [&halves[0], &halves[1]]
}

#[inline]
fn prefetch<L>(line: &L) {
    // SAFETY: a prefetch reads nothing that the program sees; the address is a valid reference's.
    unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(line).cast()) }
}
