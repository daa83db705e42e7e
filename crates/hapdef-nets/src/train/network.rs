//! The forward and backward pass of a batch.
//!
//! Letters: `a` is the input of a layer `[batch, inputs]`, `z = a Wᵀ + b` its sum
//! `[batch, outputs]`, `dx` the derivative of the loss by x.

use rayon::prelude::*;

use crate::activation::Activation;
use crate::error::NetsError;
use crate::mlp::{Layer, Mlp};
use crate::optimiser::Moments;
use crate::params::Loss;
use crate::train::adam::{Part, Update};
use crate::train::loss::differentiate;
use crate::train::products::{ROW_BLOCK, multiply};
use crate::train::view::View;

/// A network whose weights change in place, with room for a batch.
pub(super) struct Network {
    layers: Vec<Layer>,
    shapes: Vec<(usize, usize)>,
    activation: Activation,
    /// Output of every layer; after [`Network::forward`] the last holds the derivative of the loss
    /// by the outputs.
    outputs: Vec<Vec<f32>>,
    /// Derivative by the input of a layer.
    d_input: Vec<f32>,
    /// Derivative by the weights of a layer.
    d_weights: Vec<f32>,
    /// Derivative by the biases of a layer.
    d_bias: Vec<f32>,
}

impl Network {
    pub(super) fn new(mlp: &Mlp) -> Self {
        let shapes = mlp.spec().layer_shapes();
        Self {
            layers: mlp.layers().to_vec(),
            outputs: vec![vec![]; shapes.len()],
            shapes,
            activation: mlp.spec().activation,
            d_input: vec![],
            d_weights: vec![],
            d_bias: vec![],
        }
    }

    /// The weights as they are now, in the architecture of `mlp`.
    pub(super) fn to_mlp(&self, mlp: &Mlp) -> Result<Mlp, NetsError> {
        Mlp::from_layers(mlp.spec(), self.layers.clone())
    }

    /// Outputs, `[batch, outputs]`, of inputs `[batch, inputs]`.
    pub(super) fn predict(&mut self, x: &[f32]) -> &mut [f32] {
        for i in 0..self.layers.len() {
            self.layer_output(i, x);
        }
        match self.outputs.last_mut() {
            Some(last) => last,
            None => &mut [],
        }
    }

    /// Forward, and the derivative of the loss by the outputs; returns the loss.
    pub(super) fn forward(&mut self, loss: Loss, x: &[f32], y: &[f32]) -> f64 {
        let n_out = self.shapes.last().map_or(1, |(_, n_out)| *n_out);
        differentiate(loss, self.predict(x), y, n_out)
    }

    /// Backward after [`Network::forward`] of `x`, last layer first. `update` gets the derivatives
    /// by all weights and biases, part by part; by then the layer's weights are free to change.
    /// Returns the sum of what it returned.
    pub(super) fn backward(
        &mut self,
        x: &[f32],
        moments: &mut [Moments],
        update: &impl Update,
    ) -> f64 {
        let mut sum = 0.0;
        for i in (0..self.layers.len()).rev() {
            let (n_in, n_out) = self.shapes[i];
            let mut dz = std::mem::take(&mut self.outputs[i]);
            let batch = dz.len() / n_out;
            column_sums(&dz, &mut self.d_bias, n_out);
            if i > 0 {
                self.input_derivative(i, &dz);
            }
            let a = match i {
                0 => x,
                _ => &self.outputs[i - 1],
            };
            self.d_weights.resize(n_in * n_out, 0.0);
            let layer = &mut self.layers[i];
            let (dz_t, a) = (View::new(&dz, batch, n_out).t(), View::new(a, batch, n_in));
            sum += update.biases(bias_part(layer, &mut moments[i]), &self.d_bias);
            let parts = weight_parts(layer, &mut moments[i], ROW_BLOCK * n_in);
            let gradient = &mut self.d_weights;
            let each = |g: &mut [f32], part: Part<'_>| update.weights(part, g);
            let sums = multiply(dz_t, a, gradient, parts, each);
            sum += sums.into_iter().sum::<f64>();
            if i > 0 {
                std::mem::swap(&mut self.d_input, &mut self.outputs[i - 1]);
            }
            std::mem::swap(&mut dz, &mut self.outputs[i]);
        }
        sum
    }

    /// Derivative by the sum of the layer before, from that by the sum of layer `i`.
    fn input_derivative(&mut self, i: usize, dz: &[f32]) {
        let (n_in, n_out) = self.shapes[i];
        let batch = dz.len() / n_out;
        self.d_input.resize(batch * n_in, 0.0);
        let activation = self.activation;
        let a = self.outputs[i - 1].par_chunks(ROW_BLOCK * n_in);
        let (dz, weights) =
            (View::new(dz, batch, n_out), View::new(&self.layers[i].weights, n_out, n_in));
        let finish = |da: &mut [f32], a: &[f32]| activation.apply_derivative(da, a);
        multiply(dz, weights, &mut self.d_input, a, finish);
    }

    fn layer_output(&mut self, i: usize, x: &[f32]) {
        let (n_in, n_out) = self.shapes[i];
        let (before, rest) = self.outputs.split_at_mut(i);
        let a = before.last().map_or(x, |a| a);
        let batch = a.len() / n_in;
        let layer = &self.layers[i];
        let activation = (i + 1 < self.layers.len()).then_some(self.activation);
        let finish = |rows: &mut [f32], _: usize| {
            for row in rows.chunks_exact_mut(n_out) {
                match activation {
                    Some(activation) => activation.apply(row, &layer.bias),
                    None => row.iter_mut().zip(&layer.bias).for_each(|(z, b)| *z += b),
                }
            }
        };
        let z = &mut rest[0];
        z.resize(batch * n_out, 0.0);
        let weights = View::new(&layer.weights, n_out, n_in).t();
        let blocks = (0..batch.div_ceil(ROW_BLOCK)).into_par_iter();
        let a = View::new(a, batch, n_in);
        multiply(a, weights, z, blocks, finish);
    }
}

/// The weights of a layer and their moments in blocks of `size`.
fn weight_parts<'a>(
    layer: &'a mut Layer,
    moments: &'a mut Moments,
    size: usize,
) -> impl IndexedParallelIterator<Item = Part<'a>> {
    let means = moments.weights_m.par_chunks_mut(size);
    let both = means.zip(moments.weights_v.par_chunks_mut(size));
    let parts = layer.weights.par_chunks_mut(size).zip(both);
    parts.map(|(w, (m, v))| Part { w, m, v })
}

fn bias_part<'a>(layer: &'a mut Layer, moments: &'a mut Moments) -> Part<'a> {
    Part { w: &mut layer.bias, m: &mut moments.bias_m, v: &mut moments.bias_v }
}

/// Columns that one thread adds up.
const COLUMN_BLOCK: usize = 256;

fn column_sums(rows: &[f32], sums: &mut Vec<f32>, width: usize) {
    sums.clear();
    sums.resize(width, 0.0);
    let blocks = sums.par_chunks_mut(COLUMN_BLOCK).enumerate();
    blocks.for_each(|(i, sums)| {
        let at = i * COLUMN_BLOCK;
        for row in rows.chunks_exact(width) {
            let row = &row[at..at + sums.len()];
            sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += v);
        }
    });
}

#[cfg(test)]
#[path = "network_tests.rs"]
mod tests;
