//! 256-bit vectors with fused multiply-add.

use std::arch::x86_64::{
    __m256, __m256i, _MM_HINT_T1, _mm_load_si128, _mm_loadl_epi64, _mm_prefetch, _mm256_add_epi32,
    _mm256_cvtepi8_epi16, _mm256_cvtepi8_epi32, _mm256_cvtepi32_ps, _mm256_fmadd_ps,
    _mm256_load_ps, _mm256_load_si256, _mm256_madd_epi16, _mm256_permute2x128_si256,
    _mm256_set1_epi32, _mm256_set1_ps, _mm256_store_ps, _mm256_store_si256, _mm256_unpackhi_epi16,
    _mm256_unpacklo_epi16,
};

use super::super::panels::{F32Line, I32Line, Int8Line, Line, Panels};
use super::super::quantise::ByteScale;
use super::{Active, ActiveBytes, elements};

type Vector = [__m256; 2];

float_kernels!(#[target_feature(enable = "avx2,fma")]);
elements!(#[target_feature(enable = "avx2,fma")]);

/// Sums of byte products, by way of 16 bits, which hold every product of two.
#[target_feature(enable = "avx2,fma")]
pub(super) fn bytes<const P: usize>(w: &Panels<Int8Line>, x: ActiveBytes<'_>, out: &mut [I32Line]) {
    for (unit, width, lines) in w.iter() {
        let out = &mut out[4 * P * unit..4 * P * (unit + width)];
        out.fill(Line([0; 16]));
        for (rows, words) in x.fours() {
            for (u, out) in out.chunks_exact_mut(4 * P).enumerate() {
                let rows = rows.map(|row| &lines[row as usize * width + u]);
                for quarter in 0..4 {
                    let weights = pairs(rows.map(|line| wide_quarter(line, quarter)));
                    for (p, word) in words.into_iter().enumerate().take(P) {
                        add_sums(products(weights, word), &mut out[4 * p + quarter]);
                    }
                }
            }
        }
    }
}

/// The weights of four inputs for 16 outputs, two inputs side by side: of the first two inputs for the
/// first four and the third four outputs, for the others; the same of the last two.
#[target_feature(enable = "avx2")]
#[inline]
fn pairs([a, b, c, d]: [__m256i; 4]) -> [[__m256i; 2]; 2] {
    [
        [_mm256_unpacklo_epi16(a, b), _mm256_unpackhi_epi16(a, b)],
        [_mm256_unpacklo_epi16(c, d), _mm256_unpackhi_epi16(c, d)],
    ]
}

/// The sums of the products with four inputs in bytes, in the order of the outputs.
#[target_feature(enable = "avx2")]
#[inline]
fn products([first, last]: [[__m256i; 2]; 2], word: i32) -> [__m256i; 2] {
    let [a, b, c, d] = word.to_le_bytes().map(i32::from);
    let (ab, cd) = (_mm256_set1_epi32(a | b << 16), _mm256_set1_epi32(c | d << 16));
    let [low, high] = [0, 1].map(|half| {
        let first = _mm256_madd_epi16(first[half], ab);
        _mm256_add_epi32(first, _mm256_madd_epi16(last[half], cd))
    });
    [_mm256_permute2x128_si256::<0x20>(low, high), _mm256_permute2x128_si256::<0x31>(low, high)]
}

#[target_feature(enable = "avx2")]
#[inline]
fn add_sums(sums: [__m256i; 2], line: &mut I32Line) {
    for (sums, half) in sums.into_iter().zip(line.0.as_chunks_mut::<8>().0) {
        let half = half.as_mut_ptr().cast();
        // SAFETY: half a line is 32 bytes, aligned to 32, and borrowed mutably.
        unsafe { _mm256_store_si256(half, _mm256_add_epi32(_mm256_load_si256(half), sums)) }
    }
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
fn splat(value: f32) -> Vector {
    [_mm256_set1_ps(value); 2]
}

#[target_feature(enable = "avx2,fma")]
#[inline]
fn fma(a: Vector, b: Vector, c: Vector) -> Vector {
    [_mm256_fmadd_ps(a[0], b[0], c[0]), _mm256_fmadd_ps(a[1], b[1], c[1])]
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
fn int8_quarter<const Q: usize>(line: &Int8Line) -> Vector {
    let eighths = line.0.as_chunks::<8>().0;
    let (a, b) = (&eighths[2 * Q], &eighths[2 * Q + 1]);
    // SAFETY: an eighth of a line is 8 readable bytes; this load needs no alignment.
    let (a, b) =
        unsafe { (_mm_loadl_epi64(a.as_ptr().cast()), _mm_loadl_epi64(b.as_ptr().cast())) };
    [_mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(a)), _mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(b))]
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

/// Asks for a line to be fetched to the second cache.
#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn prefetch<T>(line: &T) {
    _mm_prefetch::<_MM_HINT_T1>(std::ptr::from_ref(line).cast());
}
