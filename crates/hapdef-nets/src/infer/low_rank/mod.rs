//! A layer as two thinner ones.

#[cfg(feature = "random")]
mod fit;

use crate::mlp::Layer;

/// A layer `z = W a + b` as `z ≈ U (V a) + b'`, of rank r: n_in r + r n_out weights instead of
/// n_in n_out.
#[derive(Debug, Clone, PartialEq)]
pub struct LowRank {
    layer: usize,
    reduce: Layer,
    expand: Layer,
}

/// How much of a layer a [`LowRank`] keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowRankInfo {
    /// Rank r.
    pub rank: usize,
    /// Share of the outputs' variance (of the weights' squares with [`LowRank::of_weights`]) that
    /// is left out.
    pub left_out: f64,
}

impl LowRank {
    /// Index of the layer it stands for.
    pub fn layer(&self) -> usize {
        self.layer
    }

    /// The two layers: `[rank, n_in]` without bias, then `[n_out, rank]`.
    pub fn layers(&self) -> [&Layer; 2] {
        [&self.reduce, &self.expand]
    }
}
