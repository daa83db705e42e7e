//! The state of Adam, as it is kept in a file.

use crate::mlp::Mlp;

/// Adam's running means of the gradient (m) and of its square (v), for one layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Moments {
    /// m of the weights, `[outputs, inputs]`, row-major.
    pub weights_m: Vec<f32>,
    /// v of the weights, `[outputs, inputs]`, row-major.
    pub weights_v: Vec<f32>,
    /// m of the biases, `[outputs]`.
    pub bias_m: Vec<f32>,
    /// v of the biases, `[outputs]`.
    pub bias_v: Vec<f32>,
}

impl Moments {
    /// The moments before the first step, one per layer.
    pub fn zeros(mlp: &Mlp) -> Vec<Self> {
        let of_layer = |layer: &crate::mlp::Layer| Self {
            weights_m: vec![0.0; layer.weights.len()],
            weights_v: vec![0.0; layer.weights.len()],
            bias_m: vec![0.0; layer.bias.len()],
            bias_v: vec![0.0; layer.bias.len()],
        };
        mlp.layers().iter().map(of_layer).collect()
    }
}
