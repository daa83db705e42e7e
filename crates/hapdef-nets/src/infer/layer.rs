//! One prepared layer: weights in panels, and a pass through it.

use crate::activation::Activation;
use crate::error::NetsError;
use crate::mlp::Layer;

use super::kernels::{Active, ActiveGroup, Isa};
use super::panels::{
    Bf16Line, F32Line, GROUP, I32Line, Int8Line, Line, Panels, bf16_lines, f32_lines, int8_groups,
    int8_lines,
};
use super::params::Precision;
use super::quantise::{bf16_bits, quantise_activations, quantised_weight, row_scale};

/// Inputs beyond which an exact sum of byte products might not fit 32 bits.
const MOST_BYTE_INPUTS: usize = (i32::MAX / (255 * 127 + 128 * 127)) as usize;

/// A layer as the kernels read it.
#[derive(Debug, Clone)]
pub(super) struct PreparedLayer {
    weights: Weights,
    bias: Vec<f32>,
    n_in: usize,
    /// None for a layer whose sums go on as they are.
    activation: Option<Activation>,
}

#[derive(Debug, Clone)]
enum Weights {
    F32(Panels<F32Line>),
    Bf16(Panels<Bf16Line>),
    Bytes(Panels<Int8Line>, Vec<f32>),
    /// Panels, scales of the rows, sums of the rows in steps.
    Groups(Panels<Int8Line>, Vec<f32>, Vec<i32>),
}

/// Buffers of a pass.
#[derive(Debug, Clone, Default)]
pub(super) struct LayerScratch {
    /// Inputs of the layer before the pass, outputs after it.
    pub(super) values: Vec<f32>,
    active: Vec<Active>,
    bytes: Vec<u8>,
    groups: Vec<ActiveGroup>,
    sums: Vec<F32Line>,
    whole_sums: Vec<I32Line>,
}

impl PreparedLayer {
    /// Lays out `layer`. Only the rows of `wanted`, in that order, if it is given.
    pub(super) fn new(
        layer: &Layer,
        precision: Precision,
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
        let weights = match precision {
            Precision::F32 => Weights::F32(f32_lines(shape, |o, i| row(o)[i])),
            Precision::Bf16 => Weights::Bf16(bf16_lines(shape, |o, i| bf16_bits(row(o)[i]))),
            Precision::Int8Weights | Precision::Int8 => {
                let scales: Vec<f32> = (0..rows.len()).map(|o| row_scale(row(o))).collect();
                let steps = |o: usize, i: usize| quantised_weight(row(o)[i], scales[o]);
                if precision == Precision::Int8Weights {
                    Weights::Bytes(int8_lines(shape, steps), scales)
                } else {
                    check_byte_inputs(n_in)?;
                    let sum = |o: usize| (0..n_in).map(|i| i32::from(steps(o, i))).sum();
                    let sums = (0..rows.len()).map(sum).collect();
                    Weights::Groups(int8_groups(shape, steps), scales, sums)
                }
            }
        };
        Ok(Self {
            weights,
            bias: rows.iter().map(|&row| layer.bias[row]).collect(),
            n_in,
            activation,
        })
    }

    /// Numbers out.
    pub(super) fn n_out(&self) -> usize {
        self.bias.len()
    }

    /// Bytes of the weights and what goes with them.
    pub(super) fn bytes(&self) -> usize {
        let lines = match &self.weights {
            Weights::F32(panels) => panels.bytes(),
            Weights::Bf16(panels) => panels.bytes(),
            Weights::Bytes(panels, scales) => panels.bytes() + size_of_val(&scales[..]),
            Weights::Groups(panels, scales, sums) => {
                panels.bytes() + size_of_val(&scales[..]) + size_of_val(&sums[..])
            }
        };
        lines + size_of_val(&self.bias[..])
    }

    /// Makes room for a pass, so that the pass itself allocates nothing.
    pub(super) fn reserve(&self, scratch: &mut LayerScratch) {
        fn at_least<T>(buffer: &mut Vec<T>, n: usize) {
            buffer.reserve(n.saturating_sub(buffer.len()));
        }
        let n_groups = self.n_in.div_ceil(GROUP);
        let n_lines = self.n_out().div_ceil(64) * 4;
        at_least(&mut scratch.values, self.n_in.max(self.n_out()));
        at_least(&mut scratch.active, self.n_in);
        at_least(&mut scratch.bytes, n_groups * GROUP);
        at_least(&mut scratch.groups, n_groups);
        at_least(&mut scratch.sums, n_lines);
        at_least(&mut scratch.whole_sums, n_lines);
    }

    /// `values ← σ(W values + b)`; returns the bytes of weights that were read.
    pub(super) fn pass(&self, isa: Isa, scratch: &mut LayerScratch) -> usize {
        let bytes = match &self.weights {
            Weights::F32(panels) => {
                let (x, sums) = scratch.prepare(self.n_out().div_ceil(16));
                isa.f32(panels, x, sums);
                x.len() * panels.row_bytes()
            }
            Weights::Bf16(panels) => {
                let (x, sums) = scratch.prepare(self.n_out().div_ceil(32) * 2);
                isa.bf16(panels, x, sums);
                x.len() * panels.row_bytes()
            }
            Weights::Bytes(panels, _) => {
                let (x, sums) = scratch.prepare(self.n_out().div_ceil(64) * 4);
                isa.int8(panels, x, sums);
                x.len() * panels.row_bytes()
            }
            Weights::Groups(panels, scales, row_sums) => {
                return self.pass_bytes(isa, panels, scales, row_sums, scratch);
            }
        };
        scratch.values.resize(self.n_out(), 0.0);
        for (values, sums) in scratch.values.chunks_mut(16).zip(&scratch.sums) {
            values.copy_from_slice(&sums.0[..values.len()]);
        }
        if let Weights::Bytes(_, scales) = &self.weights {
            let pairs = scratch.values.iter_mut().zip(scales);
            pairs.for_each(|(value, scale)| *value *= scale);
        }
        self.finish(isa, &mut scratch.values);
        bytes
    }

    fn pass_bytes(
        &self,
        isa: Isa,
        panels: &Panels<Int8Line>,
        scales: &[f32],
        row_sums: &[i32],
        scratch: &mut LayerScratch,
    ) -> usize {
        scratch.bytes.resize(self.n_in.next_multiple_of(GROUP), 0);
        let scale = quantise_activations(&scratch.values, &mut scratch.bytes);
        scratch.groups.clear();
        for (row, bytes) in scratch.bytes.as_chunks::<GROUP>().0.iter().enumerate() {
            if *bytes != [0; GROUP] {
                scratch.groups.push(ActiveGroup {
                    row: row as u32,
                    bytes: *bytes,
                });
            }
        }
        let n_lines = self.n_out().div_ceil(16);
        scratch.whole_sums.resize(n_lines, Line([0; 16]));
        isa.groups(panels, &scratch.groups, &mut scratch.whole_sums);
        scratch.values.resize(self.n_out(), 0.0);
        let rows = scales.chunks(16).zip(row_sums.chunks(16));
        let lines = scratch.values.chunks_mut(16).zip(&scratch.whole_sums);
        for ((values, sums), (scales, row_sums)) in lines.zip(rows) {
            for (((value, sum), row_scale), row_sum) in
                values.iter_mut().zip(&sums.0).zip(scales).zip(row_sums)
            {
                *value = (sum - scale.offset * row_sum) as f32 * scale.scale * row_scale;
            }
        }
        self.finish(isa, &mut scratch.values);
        scratch.groups.len() * panels.row_bytes()
    }

    fn finish(&self, isa: Isa, values: &mut [f32]) {
        match self.activation {
            Some(activation) => isa.activate(activation, values, &self.bias),
            None => {
                let pairs = values.iter_mut().zip(&self.bias);
                pairs.for_each(|(value, bias)| *value += bias);
            }
        }
    }
}

impl LayerScratch {
    /// The inputs that are not 0, and room for the sums.
    fn prepare(&mut self, n_lines: usize) -> (&[Active], &mut [F32Line]) {
        // Without a branch: half of the values are 0, and nobody can guess which.
        let none = Active { row: 0, value: 0.0 };
        self.active.resize(self.values.len(), none);
        let mut n_active = 0;
        for (row, &value) in self.values.iter().enumerate() {
            let row = row as u32;
            self.active[n_active] = Active { row, value };
            n_active += usize::from(value != 0.0);
        }
        self.sums.resize(n_lines, Line([0.0; 16]));
        (&self.active[..n_active], &mut self.sums)
    }
}

fn check_byte_inputs(n_in: usize) -> Result<(), NetsError> {
    if n_in > MOST_BYTE_INPUTS {
        return Err(NetsError::TooManyInputs {
            n_in,
            most: MOST_BYTE_INPUTS,
        });
    }
    Ok(())
}
