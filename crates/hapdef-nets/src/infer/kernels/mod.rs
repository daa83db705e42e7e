//! Products of a layer's weights with its inputs, by the best instructions the processor has.
//!
//! The one module of this crate with `unsafe`, for two things that need it: calling a function that
//! was compiled for instructions which were found at run time ([`Isa`] is the proof that they were),
//! and vector loads and stores, each from or to a whole [`Line`](super::panels::Line). Everything
//! else in here is safe code.
#![allow(
    unsafe_code,
    reason = "vector instructions that are found at run time; every block says why it is sound"
)]

#[macro_use]
mod float;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;

use crate::activation::Activation;
use crate::error::NetsError;

use super::panels::{Bf16Line, F32Line, I32Line, Int8Line, Panels};

/// Vector instructions a processor may have, least first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SimdLevel {
    /// What the program was compiled for.
    Portable,
    /// 128-bit vectors of every 64-bit ARM.
    Neon,
    /// 256-bit vectors with fused multiply-add.
    Avx2,
    /// 512-bit vectors; sums of bytes in halves, as with AVX2.
    Avx512,
    /// 512-bit vectors with sums of four byte products in one instruction.
    Avx512Vnni,
}

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

/// Four inputs in bytes, not all 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct ActiveGroup {
    /// Index of the group.
    pub(super) row: u32,
    /// The inputs.
    pub(super) bytes: [u8; 4],
}

impl SimdLevel {
    /// All levels, least first.
    const ALL: [Self; 5] = [
        Self::Portable,
        Self::Neon,
        Self::Avx2,
        Self::Avx512,
        Self::Avx512Vnni,
    ];

    /// The best that this processor has.
    pub fn best() -> Self {
        let found = Self::ALL.into_iter().rfind(|level| level.is_available());
        found.unwrap_or(Self::Portable)
    }

    /// Those that this processor has, least first.
    pub fn available() -> Vec<Self> {
        let all = Self::ALL.into_iter();
        all.filter(|level| level.is_available()).collect()
    }

    /// Whether this processor has them.
    pub fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            Self::Neon => cfg!(target_arch = "aarch64"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                std::arch::is_x86_feature_detected!("avx2")
                    && std::arch::is_x86_feature_detected!("fma")
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_available() && std::arch::is_x86_feature_detected!("avx512f")
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx512Vnni => {
                Self::Avx512.is_available() && std::arch::is_x86_feature_detected!("avx512vnni")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }
}

/// Calls `$name` of the module for `$isa`.
macro_rules! dispatch {
    ($isa:expr, $name:ident ( $($argument:expr),* ), $vnni:ident) => {
        match $isa.0 {
            // SAFETY (every unsafe arm): an `Isa` of this level exists only where `Isa::new` found
            // the instructions that the function was compiled for.
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx512Vnni => unsafe { avx512::$vnni($($argument),*) },
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx512 => unsafe { avx512::$name($($argument),*) },
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx2 => unsafe { avx2::$name($($argument),*) },
            // NEON belongs to every processor this arm is compiled for.
            #[cfg(target_arch = "aarch64")]
            SimdLevel::Neon => neon::$name($($argument),*),
            _ => portable::$name($($argument),*),
        }
    };
}

impl Isa {
    /// Fails where this processor lacks the instructions.
    pub(super) fn new(level: SimdLevel) -> Result<Self, NetsError> {
        if level.is_available() {
            return Ok(Self(level));
        }
        Err(NetsError::Simd {
            asked: level,
            best: SimdLevel::best(),
        })
    }

    /// `out = Wᵀ x` over the active inputs; a result per output of the panels.
    pub(super) fn f32(self, w: &Panels<F32Line>, x: &[Active], out: &mut [F32Line]) {
        dispatch!(self, f32(w, x, out), f32);
    }

    /// The same with weights in 16 bits.
    pub(super) fn bf16(self, w: &Panels<Bf16Line>, x: &[Active], out: &mut [F32Line]) {
        dispatch!(self, bf16(w, x, out), bf16);
    }

    /// The same with weights in bytes, in steps of their scales.
    pub(super) fn int8(self, w: &Panels<Int8Line>, x: &[Active], out: &mut [F32Line]) {
        dispatch!(self, int8(w, x, out), int8);
    }

    /// The same with inputs in bytes as well: exact sums of whole numbers.
    pub(super) fn groups(self, w: &Panels<Int8Line>, x: &[ActiveGroup], out: &mut [I32Line]) {
        dispatch!(self, groups(w, x, out), groups_vnni);
    }

    /// `z ← σ(z + bias)`, the same bits at every level.
    pub(super) fn activate(self, activation: Activation, z: &mut [f32], bias: &[f32]) {
        dispatch!(self, activate(activation, z, bias), activate);
    }
}
