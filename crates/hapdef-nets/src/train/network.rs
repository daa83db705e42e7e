//! The forward and backward pass of a batch.
//!
//! Letters: `a` is the input of a layer `[batch, inputs]`, `z = a Wᵀ + b` its sum
//! `[batch, outputs]`, `dx` the derivative of the loss by x.

use candle_core::{Device, Tensor};

use crate::activation::Activation;
use crate::error::NetsError;
use crate::mlp::{Layer, Mlp};
use crate::train::tensors::{edit, edit_with, read};

/// A network whose weights candle can multiply and Adam can change in place.
pub(super) struct Network {
    pub(super) layers: Vec<TrainLayer>,
    activation: Activation,
}

pub(super) struct TrainLayer {
    /// W, `[outputs, inputs]`.
    pub(super) weights: Tensor,
    /// b, `[outputs]`.
    pub(super) bias: Vec<f32>,
}

/// A batch that has passed forward.
pub(super) struct Pass {
    /// Input of every layer.
    layer_inputs: Vec<Tensor>,
    /// Derivative of the loss by the outputs.
    d_outputs: Tensor,
    /// √MSE over the batch and all outputs.
    pub(super) loss: f64,
}

impl Network {
    pub(super) fn new(mlp: &Mlp) -> Result<Self, NetsError> {
        let shapes = mlp.spec().layer_shapes();
        let layers = mlp.layers().iter().zip(shapes);
        let layers = layers.map(|(layer, (n_in, n_out))| {
            Ok(TrainLayer {
                weights: Tensor::from_slice(&layer.weights, (n_out, n_in), &Device::Cpu)?,
                bias: layer.bias.clone(),
            })
        });
        Ok(Self {
            layers: layers.collect::<Result<_, NetsError>>()?,
            activation: mlp.spec().activation,
        })
    }

    /// The weights as they are now, in the architecture of `mlp`.
    pub(super) fn to_mlp(&self, mlp: &Mlp) -> Result<Mlp, NetsError> {
        let layers = self.layers.iter().map(|layer| {
            Ok(Layer {
                weights: read(&layer.weights, <[f32]>::to_vec)?,
                bias: layer.bias.clone(),
            })
        });
        Mlp::from_layers(mlp.spec(), layers.collect::<Result<_, NetsError>>()?)
    }

    /// Outputs, `[batch, outputs]`, of inputs `[batch, inputs]`.
    pub(super) fn predict(&self, x: &Tensor) -> Result<Tensor, NetsError> {
        let mut a = x.clone();
        for i in 0..self.layers.len() {
            a = self.layer_output(i, &a)?;
        }
        Ok(a)
    }

    /// Forward, and the derivative of the loss by the outputs.
    pub(super) fn forward(&self, x: &Tensor, y: &Tensor) -> Result<Pass, NetsError> {
        let mut layer_inputs = vec![x.clone()];
        let mut a = self.layer_output(0, x)?;
        for i in 1..self.layers.len() {
            layer_inputs.push(a.clone());
            a = self.layer_output(i, &a)?;
        }
        let mut loss = 0.0;
        edit_with(&a, y, |p, y| loss = root_mean_square(p, y))?;
        Ok(Pass {
            layer_inputs,
            d_outputs: a,
            loss,
        })
    }

    /// Backward, last layer first. `on_layer` gets each layer's index and its derivatives dW,
    /// `[outputs, inputs]`, and db, `[outputs]`; by then the layer's weights are free to change.
    pub(super) fn backward(
        &mut self,
        pass: Pass,
        mut on_layer: impl FnMut(usize, &mut TrainLayer, &Tensor, &[f32]) -> Result<(), NetsError>,
    ) -> Result<(), NetsError> {
        let Pass {
            mut layer_inputs,
            d_outputs: mut dz,
            ..
        } = pass;
        for i in (0..self.layers.len()).rev() {
            let Some(a) = layer_inputs.pop() else { break };
            let d_weights = dz.t()?.matmul(&a)?;
            let d_bias = column_sums(&dz, self.layers[i].bias.len())?;
            if i > 0 {
                let da = dz.matmul(&self.layers[i].weights)?;
                edit_with(&da, &a, |da, a| self.activation.apply_derivative(da, a))?;
                dz = da;
            }
            on_layer(i, &mut self.layers[i], &d_weights, &d_bias)?;
        }
        Ok(())
    }

    fn layer_output(&self, i: usize, a: &Tensor) -> Result<Tensor, NetsError> {
        let layer = &self.layers[i];
        let z = a.matmul(&layer.weights.t()?)?;
        let is_hidden = i + 1 < self.layers.len();
        edit(&z, |z| {
            for row in z.chunks_exact_mut(layer.bias.len()) {
                if is_hidden {
                    self.activation.apply(row, &layer.bias);
                } else {
                    row.iter_mut().zip(&layer.bias).for_each(|(z, b)| *z += b);
                }
            }
        })?;
        Ok(z)
    }
}

/// L = √(Σ (p − y)²/n), and in place of p its derivative (p − y)/(n L); 0 where L is 0.
fn root_mean_square(p: &mut [f32], y: &[f32]) -> f64 {
    p.iter_mut().zip(y).for_each(|(p, y)| *p -= y);
    let n = p.len() as f64;
    let loss = (sum_of_squares(p) / n).sqrt();
    let factor = if loss > 0.0 {
        (1.0 / (n * loss)) as f32
    } else {
        0.0
    };
    p.iter_mut().for_each(|p| *p *= factor);
    loss
}

/// Σ v² in f64, as eight independent sums added in a fixed order.
pub(super) fn sum_of_squares(values: &[f32]) -> f64 {
    let (blocks, rest) = values.as_chunks::<8>();
    let mut sums = [0.0f64; 8];
    for block in blocks {
        for (sum, &v) in sums.iter_mut().zip(block) {
            *sum += f64::from(v) * f64::from(v);
        }
    }
    let rest = rest.iter().map(|&v| f64::from(v) * f64::from(v));
    sums.into_iter().chain(rest).sum()
}

fn column_sums(rows: &Tensor, width: usize) -> Result<Vec<f32>, NetsError> {
    let mut sums = vec![0.0; width];
    read(rows, |values| {
        for row in values.chunks_exact(width) {
            sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += v);
        }
    })?;
    Ok(sums)
}

#[cfg(test)]
#[path = "network_tests.rs"]
mod tests;
