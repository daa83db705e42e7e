//! What is done to each input and each output of a layer: plain loops over whole lines, written once and
//! compiled for every instruction set, the same bits by each.

use crate::activation::Activation;
use crate::infer::panels::{F32Line, I32Line};
use crate::infer::quantise::{ByteScale, quantise};

/// 16 numbers of a layer.
pub(in crate::infer) type Sixteen<T> = [T; 16];

/// What becomes of the sums of a layer.
#[derive(Debug, Clone, Copy)]
pub(in crate::infer) struct Ending<'a> {
    /// Factor of each output, `[ceil(n_out / 16)]`; 1 if empty.
    pub(in crate::infer) scales: &'a [Sixteen<f32>],
    /// What is added to each.
    pub(in crate::infer) bias: &'a [Sixteen<f32>],
    /// The function of each.
    pub(in crate::infer) activation: Option<Activation>,
}

/// What becomes of whole sums first.
#[derive(Debug, Clone, Copy)]
pub(in crate::infer) struct ByteEnding<'a> {
    /// How the inputs were turned to bytes.
    pub(in crate::infer) inputs: ByteScale,
    /// Sums of each output's weights, in steps.
    pub(in crate::infer) row_sums: &'a [Sixteen<i32>],
}

/// How far values reach.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::infer) struct Extent {
    /// The bits of the largest without its sign: those of infinity and NaN are the largest of all.
    bits: u32,
    /// Whether one may be below 0.
    is_signed: bool,
}

impl Extent {
    /// Whether every value is finite.
    pub(in crate::infer) fn is_finite(self) -> bool {
        self.bits < f32::INFINITY.to_bits()
    }
}

/// `values ← σ(scales · sums + bias)`.
#[inline(always)]
pub(super) fn finish(sums: &[F32Line], ending: Ending<'_>, values: &mut [Sixteen<f32>]) -> Extent {
    if ending.scales.is_empty() {
        return end(ending, values, |i, lane| sums[i].0[lane]);
    }
    let scales = ending.scales;
    end(ending, values, |i, lane| sums[i].0[lane] * scales[i][lane])
}

/// The same for sums of inputs of `P` bytes, four lines for each byte and 64 outputs.
#[inline(always)]
pub(super) fn finish_bytes<const P: usize>(
    sums: &[I32Line],
    bytes: ByteEnding<'_>,
    ending: Ending<'_>,
    values: &mut [Sixteen<f32>],
) -> Extent {
    let ByteScale { scale, offset } = bytes.inputs;
    let (scales, row_sums) = (ending.scales, bytes.row_sums);
    end(ending, values, |i, lane| {
        let unit = &sums[i / 4 * 4 * P..][..4 * P];
        let top = unit[4 * (P - 1) + i % 4].0[lane] - offset * row_sums[i][lane];
        let mut sum = top as f32;
        if P == 2 {
            sum = sum * 256.0 + unit[i % 4].0[lane] as f32;
        }
        sum * scale * scales[i][lane]
    })
}

/// Whole numbers of `P` bytes for `x`, which `extent` is of.
#[inline(always)]
pub(super) fn to_steps<const P: usize>(x: &[f32], extent: Extent, steps: &mut [u16]) -> ByteScale {
    quantise::<P>(x, f32::from_bits(extent.bits), extent.is_signed, steps)
}

#[inline(always)]
fn end(
    ending: Ending<'_>,
    values: &mut [Sixteen<f32>],
    sum: impl Fn(usize, usize) -> f32,
) -> Extent {
    match ending.activation {
        Some(Activation::Relu) => {
            let extent = end_by(ending.bias, values, sum, |z| z.max(0.0));
            let is_signed = false;
            Extent { is_signed, ..extent }
        }
        Some(Activation::Tanh) => end_by(ending.bias, values, sum, crate::activation::tanh),
        None => end_by(ending.bias, values, sum, |z| z),
    }
}

#[inline(always)]
fn end_by(
    bias: &[Sixteen<f32>],
    values: &mut [Sixteen<f32>],
    sum: impl Fn(usize, usize) -> f32,
    activation: impl Fn(f32) -> f32,
) -> Extent {
    let (mut largest, mut signs) = ([0; 16], [0; 16]);
    for (i, (values, bias)) in values.iter_mut().zip(bias).enumerate() {
        for lane in 0..16 {
            let value = activation(sum(i, lane) + bias[lane]);
            values[lane] = value;
            largest[lane] = largest[lane].max(value.to_bits() & 0x7fff_ffff);
            signs[lane] |= value.to_bits();
        }
    }
    Extent {
        bits: largest.into_iter().fold(0, u32::max),
        is_signed: signs.into_iter().any(|bits| bits >> 31 != 0),
    }
}

/// The loops of this file for the instructions of the module that calls it.
macro_rules! elements {
    ($(#[$feature:meta])*) => {
        /// `values ← σ(scales · sums + bias)`.
        $(#[$feature])*
        pub(super) fn finish(
            sums: &[F32Line],
            ending: elements::Ending<'_>,
            values: &mut [elements::Sixteen<f32>],
        ) -> elements::Extent {
            elements::finish(sums, ending, values)
        }

        /// The same for sums of inputs of `P` bytes.
        $(#[$feature])*
        pub(super) fn finish_bytes<const P: usize>(
            sums: &[I32Line],
            bytes: elements::ByteEnding<'_>,
            ending: elements::Ending<'_>,
            values: &mut [elements::Sixteen<f32>],
        ) -> elements::Extent {
            elements::finish_bytes::<P>(sums, bytes, ending, values)
        }

        /// Whole numbers of `P` bytes for `x`.
        $(#[$feature])*
        pub(super) fn to_steps<const P: usize>(
            x: &[f32],
            extent: elements::Extent,
            steps: &mut [u16],
        ) -> ByteScale {
            elements::to_steps::<P>(x, extent, steps)
        }
    };
}
