//! One prepared layer: weights in panels, and a pass through it.

use crate::activation::Activation;
use crate::error::NetsError;
use crate::mlp::Layer;

use super::kernels::{ByteEnding, Ending, Isa, Sixteen};
use super::panels::{F32Line, Int8Line, Panels, f32_lines, int8_lines};
use super::quantise::{quantised_weight, row_scale};
use super::scratch::LayerScratch;

/// Inputs beyond which an exact sum of byte products might not fit 32 bits.
pub(super) const MOST_BYTE_INPUTS: usize = (i32::MAX / (255 * 127 + 128 * 127)) as usize;

/// A layer as the kernels read it.
#[derive(Debug, Clone)]
pub(super) struct PreparedLayer {
    weights: Weights,
    /// Of the outputs, `[ceil(n_out / 16)]`.
    bias: Vec<Sixteen<f32>>,
    n_in: usize,
    n_out: usize,
    /// None for a layer whose sums go on as they are.
    activation: Option<Activation>,
}

/// How a layer multiplies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Product {
    /// Weights and inputs in f32.
    F32,
    /// Weights in bytes, inputs in f32.
    Int8,
    /// Weights and inputs in bytes; sums are exact.
    Bytes(InputBytes),
}

/// Bytes of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InputBytes {
    One,
    Two,
}

#[derive(Debug, Clone)]
enum Weights {
    F32(Panels<F32Line>),
    Int8(Panels<Int8Line>, Vec<Sixteen<f32>>),
    Bytes(ByteWeights),
}

/// Weights of a layer whose inputs are bytes, too.
#[derive(Debug, Clone)]
struct ByteWeights {
    panels: Panels<Int8Line>,
    /// Of the rows.
    scales: Vec<Sixteen<f32>>,
    /// Of the rows, in steps.
    sums: Vec<Sixteen<i32>>,
    n_bytes: InputBytes,
}

impl PreparedLayer {
    /// Lays out `layer`. Only the rows of `wanted`, in that order, if it is given.
    pub(super) fn new(
        layer: &Layer,
        product: Product,
        activation: Option<Activation>,
        wanted: Option<&[usize]>,
    ) -> Result<Self, NetsError> {
        let n_in = layer.weights.len() / layer.bias.len();
        let all: Vec<usize>;
        let rows = match wanted {
            Some(rows) => rows,
            None => {
                all = (0..layer.bias.len()).collect();
                &all
            }
        };
        let row = |i: usize| &layer.weights[rows[i] * n_in..(rows[i] + 1) * n_in];
        let shape = [rows.len(), n_in];
        let weights = match product {
            Product::F32 => Weights::F32(f32_lines(shape, |o, i| row(o)[i])),
            Product::Int8 | Product::Bytes(_) => {
                let scales: Vec<f32> = (0..rows.len()).map(|o| row_scale(row(o))).collect();
                let steps = |o: usize, i: usize| quantised_weight(row(o)[i], scales[o]);
                let panels = int8_lines(shape, steps);
                if let Product::Bytes(n_bytes) = product {
                    check_byte_inputs(n_in)?;
                    let sum = |o: usize| (0..n_in).map(|i| i32::from(steps(o, i))).sum();
                    let sums: Vec<i32> = (0..rows.len()).map(sum).collect();
                    Weights::Bytes(ByteWeights {
                        panels,
                        scales: sixteens(&scales),
                        sums: sixteens(&sums),
                        n_bytes,
                    })
                } else {
                    Weights::Int8(panels, sixteens(&scales))
                }
            }
        };
        let bias: Vec<f32> = rows.iter().map(|&row| layer.bias[row]).collect();
        Ok(Self { weights, bias: sixteens(&bias), n_in, n_out: rows.len(), activation })
    }

    /// Numbers out.
    pub(super) fn n_out(&self) -> usize {
        self.n_out
    }

    /// Bytes of the weights and what goes with them.
    pub(super) fn bytes(&self) -> usize {
        let lines = match &self.weights {
            Weights::F32(panels) => panels.bytes(),
            Weights::Int8(panels, scales) => panels.bytes() + size_of_val(&scales[..]),
            Weights::Bytes(weights) => {
                let rows = size_of_val(&weights.scales[..]) + size_of_val(&weights.sums[..]);
                weights.panels.bytes() + rows
            }
        };
        lines + size_of_val(&self.bias[..])
    }

    /// Makes room for a pass, so that the pass itself allocates nothing.
    pub(super) fn reserve(&self, scratch: &mut LayerScratch) {
        scratch.reserve(self.n_in, self.n_out);
    }

    /// `values ← σ(W values + b)`; returns the bytes of weights that were read.
    pub(super) fn pass(&self, isa: Isa, scratch: &mut LayerScratch) -> usize {
        let (n_in, n_out) = (self.n_in, self.n_out);
        let mut scales: &[Sixteen<f32>] = &[];
        let bytes = match &self.weights {
            Weights::F32(panels) => {
                let (x, sums) = scratch.active(n_in, n_out.div_ceil(16));
                isa.f32(panels, x, sums);
                x.len() * panels.row_bytes()
            }
            Weights::Int8(panels, of_rows) => {
                scales = of_rows;
                let (x, sums) = scratch.active(n_in, n_out.div_ceil(64) * 4);
                isa.int8(panels, x, sums);
                x.len() * panels.row_bytes()
            }
            Weights::Bytes(weights) => match weights.n_bytes {
                InputBytes::One => return self.pass_bytes::<1>(isa, weights, scratch),
                InputBytes::Two => return self.pass_bytes::<2>(isa, weights, scratch),
            },
        };
        scratch.values.resize(self.bias.len(), [0.0; 16]);
        let ending = self.ending(scales);
        scratch.extent = isa.finish(&scratch.sums, ending, &mut scratch.values);
        bytes
    }

    /// The pass with inputs of `P` bytes.
    fn pass_bytes<const P: usize>(
        &self,
        isa: Isa,
        weights: &ByteWeights,
        scratch: &mut LayerScratch,
    ) -> usize {
        scratch.steps.resize(self.n_in, 0);
        let x = &scratch.values.as_flattened()[..self.n_in];
        let inputs = isa.to_steps::<P>(x, scratch.extent, &mut scratch.steps);
        let (x, n_active, sums) = scratch.active_bytes(self.n_out.div_ceil(64) * 4 * P);
        isa.bytes::<P>(&weights.panels, x, sums);
        let bytes = ByteEnding { inputs, row_sums: &weights.sums };
        scratch.values.resize(self.bias.len(), [0.0; 16]);
        let ending = self.ending(&weights.scales);
        let (sums, values) = (&scratch.whole_sums, &mut scratch.values);
        scratch.extent = isa.finish_bytes::<P>(sums, bytes, ending, values);
        n_active * weights.panels.row_bytes()
    }

    fn ending<'a>(&'a self, scales: &'a [Sixteen<f32>]) -> Ending<'a> {
        Ending { scales, bias: &self.bias, activation: self.activation }
    }
}

/// In lines of 16, the last filled up.
fn sixteens<T: Copy + Default>(values: &[T]) -> Vec<Sixteen<T>> {
    let mut lines = vec![[T::default(); 16]; values.len().div_ceil(16)];
    lines.as_flattened_mut()[..values.len()].copy_from_slice(values);
    lines
}

fn check_byte_inputs(n_in: usize) -> Result<(), NetsError> {
    if n_in > MOST_BYTE_INPUTS {
        return Err(NetsError::TooManyInputs { n_in, most: MOST_BYTE_INPUTS });
    }
    Ok(())
}
