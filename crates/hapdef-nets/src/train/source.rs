//! Where samples come from.

use crate::error::{NetsError, check_length};

/// Why a source could not deliver: any error.
pub type SourceError = Box<dyn std::error::Error + Send + Sync>;

/// A set of samples that hands out any rows, in raw units.
pub trait BatchSource {
    /// Number of samples; those that count as one pass where the source is endless.
    fn n_samples(&self) -> usize;

    /// Whether every row number gives a sample of its own, those past [`BatchSource::n_samples`]
    /// too. A training then takes rows 0, 1, 2, … in turn and never sees one twice; otherwise it
    /// draws with replacement.
    fn is_endless(&self) -> bool {
        false
    }

    /// Inputs of a sample.
    fn n_inputs(&self) -> usize;

    /// Outputs of a sample.
    fn n_outputs(&self) -> usize;

    /// Writes the samples of the given rows (below [`BatchSource::n_samples`] unless the source is
    /// endless, repeats possible) to `x`, `[rows.len(), n_inputs]`, and `y`, `[rows.len(), n_outputs]`, row-major. The same
    /// rows must always give the same values.
    fn fill(&mut self, rows: &[usize], x: &mut [f32], y: &mut [f32]) -> Result<(), SourceError>;
}

/// Samples in memory.
#[derive(Debug, Clone)]
pub struct MemorySource {
    n_inputs: usize,
    n_outputs: usize,
    x: Vec<f32>,
    y: Vec<f32>,
}

impl MemorySource {
    /// Samples `x`, `[n, n_inputs]`, and `y`, `[n, n_outputs]`, row-major, raw units. Fails if a
    /// width is 0 or the slices are not as many whole rows.
    pub fn new(
        n_inputs: usize,
        n_outputs: usize,
        x: Vec<f32>,
        y: Vec<f32>,
    ) -> Result<Self, NetsError> {
        if n_inputs == 0 || n_outputs == 0 {
            let widths = vec![n_inputs, n_outputs];
            return Err(NetsError::Widths { widths });
        }
        let n = x.len() / n_inputs;
        check_length("inputs of the samples", n * n_inputs, x.len())?;
        check_length("outputs of the samples", n * n_outputs, y.len())?;
        Ok(Self { n_inputs, n_outputs, x, y })
    }
}

impl BatchSource for MemorySource {
    fn n_samples(&self) -> usize {
        self.x.len() / self.n_inputs
    }

    fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    fn n_outputs(&self) -> usize {
        self.n_outputs
    }

    fn fill(&mut self, rows: &[usize], x: &mut [f32], y: &mut [f32]) -> Result<(), SourceError> {
        copy_rows(&self.x, rows, self.n_inputs, x);
        copy_rows(&self.y, rows, self.n_outputs, y);
        Ok(())
    }
}

fn copy_rows(all: &[f32], rows: &[usize], width: usize, out: &mut [f32]) {
    for (row, out) in rows.iter().zip(out.chunks_exact_mut(width)) {
        out.copy_from_slice(&all[row * width..(row + 1) * width]);
    }
}
