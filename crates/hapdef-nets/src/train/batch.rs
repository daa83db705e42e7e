//! Batches on their way from a source to the network.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use rayon::prelude::*;

use crate::error::NetsError;
use crate::net::{Net, Scale};
use crate::train::source::BatchSource;

/// Buffers of a batch.
#[derive(Default)]
pub(super) struct Batch {
    pub(super) rows: Vec<usize>,
    x: Vec<f32>,
    y: Vec<f32>,
}

/// The stream of ChaCha that samples are drawn from; initial weights come from stream 0.
const DRAW_STREAM: u64 = 1;

impl Batch {
    /// Chooses the rows of a step's batch. The choice depends on seed and step alone, so a resumed
    /// training needs no state of a generator.
    pub(super) fn choose(&mut self, seed: u64, step: u64, size: usize, source: &dyn BatchSource) {
        if source.is_endless() {
            let first = step as usize * size;
            self.rows.clear();
            self.rows.extend(first..first + size);
        } else {
            self.draw(seed, step, size, source.n_samples());
        }
    }

    /// Draws `size` of `n` rows with replacement.
    fn draw(&mut self, seed: u64, step: u64, size: usize, n: usize) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(DRAW_STREAM);
        rng.set_word_pos(2 * u128::from(step) * size as u128);
        // The high word of a 64 × 64 bit product: uniform to one part in 2⁶⁴/n.
        let below_n = |word: u64| ((u128::from(word) * n as u128) >> 64) as usize;
        self.rows.clear();
        self.rows.extend((0..size).map(|_| below_n(rng.next_u64())));
    }

    /// The standardised inputs and outputs of the rows, `[rows, inputs]` and `[rows, outputs]`.
    pub(super) fn load(
        &mut self,
        source: &mut dyn BatchSource,
        net: &Net,
        step: u64,
    ) -> Result<(&[f32], &[f32]), NetsError> {
        let n = self.rows.len();
        self.x.resize(n * source.n_inputs(), 0.0);
        self.y.resize(n * source.n_outputs(), 0.0);
        source
            .fill(&self.rows, &mut self.x, &mut self.y)
            .map_err(|source| NetsError::Samples { step, source })?;
        standardise("input", &self.rows, &mut self.x, net.input_scale())?;
        standardise("output", &self.rows, &mut self.y, net.output_scale())?;
        Ok((&self.x, &self.y))
    }
}

/// Rows that one thread standardises together.
const ROW_BLOCK: usize = 32;

/// Standardises samples, and fails on the first value that is not finite.
fn standardise(
    what: &'static str,
    rows: &[usize],
    values: &mut [f32],
    scale: &Scale,
) -> Result<(), NetsError> {
    let size = ROW_BLOCK * scale.width();
    let blocks = values.par_chunks_mut(size).zip(rows.par_chunks(ROW_BLOCK));
    let first_error = blocks
        .map(|(values, rows)| {
            check_samples(what, rows, values)?;
            scale.apply(values);
            Ok(())
        })
        .find_first(Result::is_err);
    first_error.unwrap_or(Ok(()))
}

fn check_samples(what: &'static str, rows: &[usize], values: &[f32]) -> Result<(), NetsError> {
    // Without a way out, the loop becomes vector code.
    if values.iter().fold(true, |all, v| all & v.is_finite()) {
        return Ok(());
    }
    let width = values.len() / rows.len();
    let at = values.iter().position(|v| !v.is_finite()).unwrap_or(0);
    Err(NetsError::SampleNotFinite {
        sample: rows[at / width],
        what,
        column: at % width,
        value: values[at],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draw(seed: u64, step: u64, size: usize, n: usize) -> Vec<usize> {
        let mut batch = Batch::default();
        batch.draw(seed, step, size, n);
        batch.rows
    }

    #[test]
    fn steps_cut_one_stream_into_batches() {
        let whole = draw(7, 0, 60, 1000);
        for step in 0..6 {
            let from = 10 * step as usize;
            assert_eq!(draw(7, step, 10, 1000), whole[from..from + 10]);
        }
        assert_ne!(draw(8, 0, 60, 1000), whole);
    }

    #[test]
    fn every_sample_is_as_likely() {
        let mut counts = [0.0f64; 10];
        for row in draw(1, 0, 100_000, 10) {
            counts[row] += 1.0;
        }
        let chi_square: f64 = counts.iter().map(|c| (c - 1e4).powi(2) / 1e4).sum();
        assert!(chi_square < 27.9, "{chi_square}: beyond the 99.9 % point of 9 degrees");
    }
}
