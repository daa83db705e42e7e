//! Products of a layer's weights with its inputs, by the best instructions the processor has.
//!
//! The one module of inference with `unsafe`, for three things that need it: calling a function that
//! was compiled for instructions which were found at run time ([`Isa`] is the proof that they were),
//! vector loads and stores, each from or to a whole [`Line`](super::panels::Line), and in the innermost
//! loop of bytes an index that was checked before. Everything else in here is safe code.
#![allow(
    unsafe_code,
    reason = "vector instructions that are found at run time; every block says why it is sound"
)]

#[macro_use]
mod elements;
#[macro_use]
mod float;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;

use crate::error::NetsError;

use super::panels::{F32Line, I32Line, Int8Line, Panels};
use super::quantise::ByteScale;
use super::simd_level::SimdLevel;
pub(super) use elements::{ByteEnding, Ending, Extent, Sixteen};

/// Instructions that this processor has: only [`Isa::new`] makes one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Isa(SimdLevel);

/// An input that is not 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Active {
    /// Index of the input.
    pub(super) row: u32,
    /// Its value.
    pub(super) value: f32,
}

/// Bytes of an input at most.
pub(super) const MOST_BYTES: usize = 2;

/// Inputs in bytes that are not 0, filled up with zeros to fours.
#[derive(Debug, Clone, Copy)]
pub(super) struct ActiveBytes<'a> {
    /// Indices of the inputs.
    pub(super) rows: &'a [u32],
    /// Their lowest bytes, then their next.
    pub(super) bytes: [&'a [u8]; MOST_BYTES],
}

/// Four inputs, and a word of their bytes for each byte of an input.
type Four = ([u32; 4], [i32; MOST_BYTES]);

impl<'a> ActiveBytes<'a> {
    /// Four after four.
    fn fours(self) -> impl Iterator<Item = Four> + 'a {
        let [low, high] = self.bytes.map(|bytes| bytes.as_chunks::<4>().0.iter());
        let rows = self.rows.as_chunks::<4>().0.iter();
        let words = low.zip(high);
        let words = words.map(|(low, high)| [*low, *high].map(i32::from_le_bytes));
        rows.copied().zip(words)
    }

    /// The same in blocks of `n_fours` fours.
    #[cfg(target_arch = "x86_64")]
    fn blocks(self, n_fours: usize) -> impl Iterator<Item = Self> {
        let [low, high] = self.bytes.map(|bytes| bytes.chunks(4 * n_fours));
        let rows = self.rows.chunks(4 * n_fours);
        let parts = rows.zip(low.zip(high));
        parts.map(|(rows, (low, high))| Self { rows, bytes: [low, high] })
    }
}

/// Calls `$name` of the module for `$isa`.
macro_rules! dispatch {
    ($isa:expr, $name:ident $(::<$p:ident>)? ( $($argument:expr),* ), $vnni:ident) => {
        match $isa.0 {
            // SAFETY (every unsafe arm): an `Isa` of this level exists only where `Isa::new` found
            // the instructions that the function was compiled for.
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx512Vnni => unsafe { avx512::$vnni $(::<$p>)? ($($argument),*) },
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx512 => unsafe { avx512::$name $(::<$p>)? ($($argument),*) },
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx2 => unsafe { avx2::$name $(::<$p>)? ($($argument),*) },
            #[cfg(target_arch = "aarch64")]
            SimdLevel::Neon => unsafe { neon::$name $(::<$p>)? ($($argument),*) },
            _ => portable::$name $(::<$p>)? ($($argument),*),
        }
    };
}

impl Isa {
    /// Fails where this processor lacks the instructions.
    pub(super) fn new(level: SimdLevel) -> Result<Self, NetsError> {
        if level.is_available() {
            return Ok(Self(level));
        }
        Err(NetsError::Simd { asked: level, best: SimdLevel::best() })
    }

    /// `out = Wᵀ x` over the active inputs; a result per output of the panels.
    pub(super) fn f32(self, w: &Panels<F32Line>, x: &[Active], out: &mut [F32Line]) {
        dispatch!(self, f32(w, x, out), f32);
    }

    /// The same with weights in bytes, in steps of their scales.
    pub(super) fn int8(self, w: &Panels<Int8Line>, x: &[Active], out: &mut [F32Line]) {
        dispatch!(self, int8(w, x, out), int8);
    }

    /// The same with inputs of `P` bytes: exact sums of whole numbers, four lines for each byte and
    /// unit.
    pub(super) fn bytes<const P: usize>(
        self,
        w: &Panels<Int8Line>,
        x: ActiveBytes<'_>,
        out: &mut [I32Line],
    ) {
        dispatch!(self, bytes::<P>(w, x, out), bytes_vnni);
    }

    /// `values ← σ(scales · sums + bias)`, the same bits at every level.
    pub(super) fn finish(
        self,
        sums: &[F32Line],
        ending: Ending<'_>,
        values: &mut [Sixteen<f32>],
    ) -> Extent {
        dispatch!(self, finish(sums, ending, values), finish)
    }

    /// The same for sums of inputs of `P` bytes.
    pub(super) fn finish_bytes<const P: usize>(
        self,
        sums: &[I32Line],
        bytes: ByteEnding<'_>,
        ending: Ending<'_>,
        values: &mut [Sixteen<f32>],
    ) -> Extent {
        dispatch!(self, finish_bytes::<P>(sums, bytes, ending, values), finish_bytes)
    }

    /// Whole numbers of `P` bytes for `x`, which `extent` is of.
    pub(super) fn to_steps<const P: usize>(
        self,
        x: &[f32],
        extent: Extent,
        steps: &mut [u16],
    ) -> ByteScale {
        dispatch!(self, to_steps::<P>(x, extent, steps), to_steps)
    }
}

#[cfg(test)]
mod tests;
