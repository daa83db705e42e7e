//! Any processor, by what the compiler makes of plain loops.

use super::super::panels::{F32Line, I32Line, Int8Line, Line, Panels};
use super::super::quantise::ByteScale;
use super::{Active, ActiveBytes, elements};

type Vector = [f32; 16];

float_kernels!();
elements!();

/// Sums of byte products.
pub(super) fn bytes<const P: usize>(w: &Panels<Int8Line>, x: ActiveBytes<'_>, out: &mut [I32Line]) {
    for (unit, width, lines) in w.iter() {
        let out = &mut out[4 * P * unit..4 * P * (unit + width)];
        out.fill(Line([0; 16]));
        for (rows, words) in x.fours() {
            for (u, out) in out.chunks_exact_mut(4 * P).enumerate() {
                for (i, row) in rows.iter().enumerate() {
                    let weights = &lines[*row as usize * width + u].0;
                    for (sums, words) in out.chunks_exact_mut(4).zip(words) {
                        let x = i32::from(words.to_le_bytes()[i]);
                        for (sums, weights) in sums.iter_mut().zip(weights.as_chunks::<16>().0) {
                            for (sum, w) in sums.0.iter_mut().zip(weights) {
                                *sum += i32::from(*w) * x;
                            }
                        }
                    }
                }
            }
        }
    }
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
fn int8_quarter<const Q: usize>(line: &Int8Line) -> Vector {
    line.0.as_chunks::<16>().0[Q].map(f32::from)
}

#[inline]
fn store(vector: Vector, line: &mut F32Line) {
    line.0 = vector;
}

/// Leaves fetching ahead to the processor.
#[inline]
fn prefetch<T>(_line: &T) {}
