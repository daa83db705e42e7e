//! How a net is prepared.

use super::low_rank::LowRank;
use super::simd_level::SimdLevel;

/// How weights are stored and activations multiplied. Sums are f32 unless said otherwise.
///
/// The errors are of one layer; δ is the error of its inputs x and grows through a layer by at most
/// |W| δ, and not at all through an activation function (ReLU and tanh have slopes of at most 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Precision {
    /// 4 bytes a weight: the net as it is, up to the order of the sum.
    F32,
    /// 1 byte a weight and one scale per row, s = max |w| / 127: an output is off by at most
    /// Σ |x| s / 2. Rows below 1e-38 are off by at most 1e-44 a weight. Activations stay f32, or
    /// where the processor adds products of bytes ([`SimdLevel::Avx512Vnni`]) become 2 bytes in every
    /// layer but the first, with one scale t per vector (its range / 65,535, or its largest magnitude /
    /// 32,767 where there are negative values), which adds at most Σ |w| t / 2.
    Int8Weights,
    /// As [`Precision::Int8Weights`], and the activations of every layer but the first in one byte,
    /// t = range / 255, or largest magnitude / 127; sums are exact integers. The first layer keeps the
    /// f32 of its inputs: they are measured, and may have any range.
    Int8,
}

/// What a prepared net is to be.
#[derive(Debug, Clone, PartialEq)]
pub struct InferParams {
    /// How weights and activations are stored.
    pub precision: Precision,
    /// The outputs to evaluate, by index and in this order; all of them if `None`.
    pub wanted: Option<Vec<usize>>,
    /// Layers that are replaced by two thinner ones.
    pub low_rank: Vec<LowRank>,
    /// The instructions to use; the best the processor has if `None`.
    pub simd: Option<SimdLevel>,
}

impl InferParams {
    /// The whole net in this precision.
    pub fn of(precision: Precision) -> Self {
        Self { precision, wanted: None, low_rank: Vec::new(), simd: None }
    }
}

impl Precision {
    /// All of them, most bytes first.
    pub const ALL: [Self; 3] = [Self::F32, Self::Int8Weights, Self::Int8];

    /// Name for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::Int8Weights => "int8 weights",
            Self::Int8 => "int8",
        }
    }
}
