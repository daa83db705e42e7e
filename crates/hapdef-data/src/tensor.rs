//! What a tensor of a dataset is: its name, its numbers, its width, its unit.

use std::fmt;

use safetensors::Dtype;
use serde::{Deserialize, Serialize};

/// One tensor `[n, width]` of a dataset, row-major.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TensorSpec {
    /// Name, for example `"virtual_gauges"`.
    pub name: String,
    /// Kind of its numbers.
    pub kind: ElementKind,
    /// Numbers per sample (at least 1).
    pub width: usize,
    /// Unit of the numbers, for example `"m"`, `"N"`, `"µε"`; `"1"` if there is none.
    pub unit: String,
}

/// The kinds of number that a dataset holds, four bytes each, little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ElementKind {
    /// 32-bit floating point.
    F32,
    /// 32-bit signed integer.
    I32,
}

/// A number that a dataset can hold: `f32` or `i32`.
pub trait Element: Copy + private::Sealed {
    /// The kind of this number.
    const KIND: ElementKind;
    /// The number of four little-endian bytes.
    fn from_le(bytes: [u8; 4]) -> Self;
    /// Its four little-endian bytes.
    fn to_le(self) -> [u8; 4];
    /// The number as `f32` if it is NaN or infinite.
    fn not_finite(self) -> Option<f32>;
}

/// Bytes of one number.
pub(crate) const ELEMENT_BYTES: usize = 4;

impl TensorSpec {
    /// An `f32` tensor.
    pub fn f32(name: &str, width: usize, unit: &str) -> Self {
        Self { name: name.to_owned(), kind: ElementKind::F32, width, unit: unit.to_owned() }
    }

    /// An `i32` tensor, for indices; its unit is `"1"`.
    pub fn i32(name: &str, width: usize) -> Self {
        Self { name: name.to_owned(), kind: ElementKind::I32, width, unit: "1".to_owned() }
    }
}

impl ElementKind {
    pub(crate) fn dtype(self) -> Dtype {
        match self {
            Self::F32 => Dtype::F32,
            Self::I32 => Dtype::I32,
        }
    }

    pub(crate) fn from_dtype(dtype: Dtype) -> Option<Self> {
        match dtype {
            Dtype::F32 => Some(Self::F32),
            Dtype::I32 => Some(Self::I32),
            _ => None,
        }
    }
}

impl fmt::Display for ElementKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::I32 => "i32",
        })
    }
}

impl Element for f32 {
    const KIND: ElementKind = ElementKind::F32;

    fn from_le(bytes: [u8; 4]) -> Self {
        Self::from_le_bytes(bytes)
    }

    fn to_le(self) -> [u8; 4] {
        self.to_le_bytes()
    }

    fn not_finite(self) -> Option<f32> {
        (!self.is_finite()).then_some(self)
    }
}

impl Element for i32 {
    const KIND: ElementKind = ElementKind::I32;

    fn from_le(bytes: [u8; 4]) -> Self {
        Self::from_le_bytes(bytes)
    }

    fn to_le(self) -> [u8; 4] {
        self.to_le_bytes()
    }

    fn not_finite(self) -> Option<f32> {
        None
    }
}

mod private {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for i32 {}
}
