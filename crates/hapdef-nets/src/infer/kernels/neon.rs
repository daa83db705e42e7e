//! 128-bit vectors of 64-bit ARM, where they are always there.

use std::arch::aarch64::{
    float32x4_t, vcvtq_f32_s32, vdupq_n_f32, vfmaq_f32, vget_high_s16, vget_low_s16, vld1_s8,
    vld1q_f32, vmovl_s8, vmovl_s16, vst1q_f32,
};

use super::super::panels::{F32Line, I32Line, Int8Line, Line, Panels};
use super::super::quantise::ByteScale;
use super::{Active, ActiveBytes, elements, portable};

type Vector = [float32x4_t; 4];

float_kernels!(#[target_feature(enable = "neon")]);
elements!(#[target_feature(enable = "neon")]);

/// Sums of byte products.
#[target_feature(enable = "neon")]
pub(super) fn bytes<const P: usize>(w: &Panels<Int8Line>, x: ActiveBytes<'_>, out: &mut [I32Line]) {
    portable::bytes::<P>(w, x, out);
}

#[target_feature(enable = "neon")]
#[inline]
fn splat(value: f32) -> Vector {
    [vdupq_n_f32(value); 4]
}

#[target_feature(enable = "neon")]
#[inline]
fn fma(a: Vector, b: Vector, c: Vector) -> Vector {
    [
        vfmaq_f32(c[0], a[0], b[0]),
        vfmaq_f32(c[1], a[1], b[1]),
        vfmaq_f32(c[2], a[2], b[2]),
        vfmaq_f32(c[3], a[3], b[3]),
    ]
}

#[target_feature(enable = "neon")]
#[inline]
fn f32_line(line: &F32Line) -> Vector {
    let [a, b, c, d] = quarters(&line.0);
    // SAFETY: each is four readable numbers.
    unsafe {
        [vld1q_f32(a.as_ptr()), vld1q_f32(b.as_ptr()), vld1q_f32(c.as_ptr()), vld1q_f32(d.as_ptr())]
    }
}

#[target_feature(enable = "neon")]
#[inline]
fn int8_quarter<const Q: usize>(line: &Int8Line) -> Vector {
    let eighths = line.0.as_chunks::<8>().0;
    let mut out = splat(0.0);
    for half in 0..2 {
        // SAFETY: eight readable bytes.
        let words = vmovl_s8(unsafe { vld1_s8(eighths[2 * Q + half].as_ptr()) });
        out[2 * half] = vcvtq_f32_s32(vmovl_s16(vget_low_s16(words)));
        out[2 * half + 1] = vcvtq_f32_s32(vmovl_s16(vget_high_s16(words)));
    }
    out
}

#[target_feature(enable = "neon")]
#[inline]
fn store(vector: Vector, line: &mut F32Line) {
    for (vector, out) in vector.into_iter().zip(line.0.as_chunks_mut::<4>().0) {
        // SAFETY: four numbers, borrowed mutably.
        unsafe { vst1q_f32(out.as_mut_ptr(), vector) }
    }
}

#[inline]
fn quarters<T>(line: &[T; 16]) -> [&[T; 4]; 4] {
    let quarters = line.as_chunks::<4>().0;
    [&quarters[0], &quarters[1], &quarters[2], &quarters[3]]
}

/// Leaves fetching ahead to the processor.
#[inline]
fn prefetch<T>(_line: &T) {}
