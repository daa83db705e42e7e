//! 512-bit vectors.

use std::arch::x86_64::{
    __m512, __m512i, _MM_HINT_T0, _mm_load_si128, _mm_prefetch, _mm512_and_si512,
    _mm512_castsi512_ps, _mm512_cvtepi8_epi32, _mm512_cvtepi32_ps, _mm512_dpbusd_epi32,
    _mm512_fmadd_ps, _mm512_load_ps, _mm512_load_si512, _mm512_set1_epi32, _mm512_set1_ps,
    _mm512_setzero_ps, _mm512_setzero_si512, _mm512_slli_epi32, _mm512_store_ps,
    _mm512_store_si512,
};

use crate::activation::Activation;

use super::super::panels::{Bf16Line, F32Line, I32Line, Int8Line, Panels};
use super::{Active, ActiveGroup, avx2};

type Vector = __m512;

/// Active inputs whose lines are asked for ahead of their use.
const AHEAD: usize = 24;

float_kernels!(16, #[target_feature(enable = "avx512f,avx2,fma")]);

/// Sums of byte products without the instruction for them.
#[target_feature(enable = "avx512f,avx2,fma")]
pub(super) fn groups(w: &Panels<Int8Line>, x: &[ActiveGroup], out: &mut [I32Line]) {
    avx2::groups(w, x, out);
}

/// Sums of byte products, four in one instruction.
#[target_feature(enable = "avx512f,avx512vnni")]
pub(super) fn groups_vnni(w: &Panels<Int8Line>, x: &[ActiveGroup], out: &mut [I32Line]) {
    for (unit, width, lines) in w.iter() {
        let out = &mut out[unit..unit + width];
        let mut first = 0;
        while first < width {
            let rest = width - first;
            if rest >= 16 {
                group_units::<16>(lines, width, first, x, out);
                first += 16;
            } else if rest >= 4 {
                group_units::<4>(lines, width, first, x, out);
                first += 4;
            } else {
                group_units::<1>(lines, width, first, x, out);
                first += 1;
            }
        }
    }
}

#[target_feature(enable = "avx512f,avx512vnni")]
#[inline]
fn group_units<const U: usize>(
    lines: &[Int8Line],
    width: usize,
    first: usize,
    x: &[ActiveGroup],
    out: &mut [I32Line],
) {
    let mut sums = [_mm512_setzero_si512(); U];
    for (i, active) in x.iter().enumerate() {
        let start = active.row as usize * width + first;
        let row = &lines[start..start + U];
        if let Some(ahead) = x.get(i + AHEAD) {
            let start = ahead.row as usize * width + first;
            for line in &lines[start..start + U] {
                prefetch(line);
            }
        }
        let bytes = _mm512_set1_epi32(i32::from_le_bytes(active.bytes));
        for u in 0..U {
            sums[u] = _mm512_dpbusd_epi32(sums[u], bytes, int8_line(&row[u]));
        }
    }
    for u in 0..U {
        let line: *mut I32Line = &mut out[first + u];
        // SAFETY: the line is 64 bytes of whole numbers, aligned to 64, and borrowed mutably.
        unsafe { _mm512_store_si512(line.cast(), sums[u]) };
    }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn zero() -> Vector {
    _mm512_setzero_ps()
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
fn bf16_low(line: &Bf16Line) -> Vector {
    // SAFETY: a line is 64 readable bytes, aligned to 64.
    let words = unsafe { _mm512_load_si512(line.0.as_ptr().cast()) };
    _mm512_castsi512_ps(_mm512_slli_epi32::<16>(words))
}

#[target_feature(enable = "avx512f")]
#[inline]
fn bf16_high(line: &Bf16Line) -> Vector {
    // SAFETY: a line is 64 readable bytes, aligned to 64.
    let words = unsafe { _mm512_load_si512(line.0.as_ptr().cast()) };
    _mm512_castsi512_ps(_mm512_and_si512(
        words,
        _mm512_set1_epi32(0xffff_0000_u32 as i32),
    ))
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
fn store(vector: Vector, line: &mut F32Line) {
    // SAFETY: a line is 64 bytes, aligned to 64, and borrowed mutably.
    unsafe { _mm512_store_ps(line.0.as_mut_ptr(), vector) }
}

#[inline]
fn prefetch<L>(line: &L) {
    // SAFETY: a prefetch reads nothing that the program sees; the address is a valid reference's.
    unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(line).cast()) }
}
