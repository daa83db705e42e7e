//! The weights of a network and how they begin.

#[cfg(feature = "random")]
mod random;

use crate::error::{NetsError, check_length};
use crate::spec::MlpSpec;

/// The weights of a fully connected network.
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp {
    spec: MlpSpec,
    layers: Vec<Layer>,
}

/// One layer: `z = W a + b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// W, `[outputs, inputs]`, row-major.
    pub weights: Vec<f32>,
    /// b, `[outputs]`.
    pub bias: Vec<f32>,
}

impl Mlp {
    /// A network of given weights. Fails if their number is not the architecture's.
    pub fn from_layers(spec: &MlpSpec, layers: Vec<Layer>) -> Result<Self, NetsError> {
        spec.check()?;
        let shapes = spec.layer_shapes();
        check_length("layers of a network", shapes.len(), layers.len())?;
        for ((n_in, n_out), layer) in shapes.iter().zip(&layers) {
            check_length("weights of a layer", n_in * n_out, layer.weights.len())?;
            check_length("biases of a layer", *n_out, layer.bias.len())?;
        }
        Ok(Self { spec: spec.clone(), layers })
    }

    /// The architecture.
    pub fn spec(&self) -> &MlpSpec {
        &self.spec
    }

    /// The layers, first to last.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }
}
