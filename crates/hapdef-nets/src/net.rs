//! A network in raw units: what a user of a trained net holds.

use serde::{Deserialize, Serialize};

use crate::error::{NetsError, check_finite, check_inputs, check_length};
use crate::forward::Scratch;
use crate::mlp::Mlp;

/// Mean and standard deviation of every column: `standardised = (raw − mean) / std`.
///
/// A deviation of 0 marks a column that never varied in training. No weight has learned what its
/// changes mean: as an input it is 0 standardised, whatever it shows, and as an output it is its
/// mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    mean: Vec<f32>,
    std: Vec<f32>,
}

/// A network with the scales of its inputs and outputs: raw units in, raw units out.
#[derive(Debug, Clone, PartialEq)]
pub struct Net {
    mlp: Mlp,
    input: Scale,
    output: Scale,
}

impl Scale {
    /// A scale of given means and deviations, in the columns' units.
    ///
    /// Fails if the lengths differ, on a mean that is not finite, and on a deviation that is
    /// negative or not finite.
    pub fn new(mean: Vec<f32>, std: Vec<f32>) -> Result<Self, NetsError> {
        let scale = Self { mean, std };
        scale.check()?;
        Ok(scale)
    }

    /// The scale that changes nothing, for `width` columns.
    pub fn identity(width: usize) -> Self {
        Self { mean: vec![0.0; width], std: vec![1.0; width] }
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.mean.len()
    }

    /// Mean of every column.
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }

    /// Standard deviation of every column.
    pub fn std(&self) -> &[f32] {
        &self.std
    }

    /// Columns that never varied in training: inputs without a say, outputs that stay.
    pub fn constant_columns(&self) -> impl Iterator<Item = usize> + '_ {
        let columns = self.std.iter().enumerate();
        columns.filter(|(_, std)| **std <= 0.0).map(|(column, _)| column)
    }

    pub(crate) fn check(&self) -> Result<(), NetsError> {
        check_length("deviations of a scale", self.mean.len(), self.std.len())?;
        check_finite("means of a scale", &self.mean)?;
        let is_bad = |s: &f32| !(*s >= 0.0 && s.is_finite());
        match self.std.iter().position(is_bad) {
            Some(column) => Err(NetsError::Deviation { column, std: self.std[column] }),
            None => Ok(()),
        }
    }

    /// Standardises whole rows in place.
    pub(crate) fn apply(&self, rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(self.width()) {
            for ((x, mean), std) in row.iter_mut().zip(&self.mean).zip(&self.std) {
                *x = if *std > 0.0 { (*x - mean) / std } else { 0.0 };
            }
        }
    }

    /// Brings standardised whole rows back to raw units, in place.
    pub(crate) fn invert(&self, rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(self.width()) {
            for ((x, mean), std) in row.iter_mut().zip(&self.mean).zip(&self.std) {
                *x = *x * std + mean;
            }
        }
    }
}

impl Net {
    /// Puts scales around a network. Fails if their widths are not the network's.
    pub fn new(mlp: Mlp, input: Scale, output: Scale) -> Result<Self, NetsError> {
        check_length("scale of the inputs", mlp.spec().inputs, input.width())?;
        check_length("scale of the outputs", mlp.spec().outputs, output.width())?;
        Ok(Self { mlp, input, output })
    }

    /// The network inside.
    pub fn mlp(&self) -> &Mlp {
        &self.mlp
    }

    /// Scale of the inputs.
    pub fn input_scale(&self) -> &Scale {
        &self.input
    }

    /// Scale of the outputs.
    pub fn output_scale(&self) -> &Scale {
        &self.output
    }

    /// One sample in raw units: `x` is `[inputs]`, `out` is `[outputs]`.
    ///
    /// Fails on slices of another length and, with its row and column, on an input that is NaN or
    /// infinite, which a ReLU would hide. An input within bounds may still overflow f32 inside, which gives an output
    /// that is not finite.
    pub fn forward(
        &self,
        x: &[f32],
        scratch: &mut Scratch,
        out: &mut [f32],
    ) -> Result<(), NetsError> {
        check_length("input of a net", self.mlp.spec().inputs, x.len())?;
        self.forward_batch(x, scratch, out)
    }

    /// Many samples in raw units: `x` is `[n, inputs]`, `out` is `[n, outputs]`, row-major. Fails
    /// as [`Net::forward`] does.
    pub fn forward_batch(
        &self,
        x: &[f32],
        scratch: &mut Scratch,
        out: &mut [f32],
    ) -> Result<(), NetsError> {
        check_inputs(self.mlp.spec().inputs, x)?;
        let mut scaled = std::mem::take(&mut scratch.scaled);
        scaled.clear();
        scaled.extend_from_slice(x);
        self.input.apply(&mut scaled);
        let result = self.mlp.forward_batch(&scaled, scratch, out);
        scratch.scaled = scaled;
        result?;
        self.output.invert(out);
        Ok(())
    }

    #[cfg(feature = "train")]
    pub(crate) fn set_mlp(&mut self, mlp: Mlp) {
        self.mlp = mlp;
    }
}
