//! Any processor, by what the compiler makes of plain loops.

use crate::activation::Activation;

use super::super::panels::{Bf16Line, F32Line, GROUP, I32Line, Int8Line, Line, Panels};
use super::{Active, ActiveGroup};

type Vector = [f32; 16];

/// Active inputs whose lines are asked for ahead of their use.
const AHEAD: usize = 8;

float_kernels!(4,);

/// Sums of byte products.
pub(super) fn groups(w: &Panels<Int8Line>, x: &[ActiveGroup], out: &mut [I32Line]) {
    for (unit, width, lines) in w.iter() {
        let out = &mut out[unit..unit + width];
        out.fill(Line([0; 16]));
        for active in x {
            let row = &lines[active.row as usize * width..][..width];
            for (line, out) in row.iter().zip(&mut *out) {
                for (weights, out) in line.0.as_chunks::<GROUP>().0.iter().zip(&mut out.0) {
                    for (w, x) in weights.iter().zip(active.bytes) {
                        *out += i32::from(*w) * i32::from(x);
                    }
                }
            }
        }
    }
}

#[inline]
fn zero() -> Vector {
    [0.0; 16]
}

#[inline]
fn splat(value: f32) -> Vector {
    [value; 16]
}

#[inline]
fn fma(a: Vector, b: Vector, c: Vector) -> Vector {
    std::array::from_fn(|i| a[i] * b[i] + c[i])
}

#[inline]
fn f32_line(line: &F32Line) -> Vector {
    line.0
}

#[inline]
fn bf16_low(line: &Bf16Line) -> Vector {
    line.0.map(|word| f32::from_bits(word << 16))
}

#[inline]
fn bf16_high(line: &Bf16Line) -> Vector {
    line.0.map(|word| f32::from_bits(word & 0xffff_0000))
}

#[inline]
fn int8_quarter<const Q: usize>(line: &Int8Line) -> Vector {
    line.0.as_chunks::<16>().0[Q].map(f32::from)
}

#[inline]
fn store(vector: Vector, line: &mut F32Line) {
    line.0 = vector;
}

#[inline]
fn prefetch<L>(_line: &L) {}
