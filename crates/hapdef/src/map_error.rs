//! Error of reconstructed deformation maps.

use serde::{Deserialize, Serialize};

/// Error over all nodes and samples.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
pub struct MapError {
    /// Mean absolute error, µm.
    pub mean_abs_um: f64,
    /// Root mean square error, µm.
    pub rms_um: f64,
    /// Fraction of variance unexplained, Σ(y − ŷ)² / Σ(y − ȳ)², ȳ each node's mean over the
    /// samples (Sun & Martius 2019, section 4.2): 0 is perfect, 1 as good as the mean.
    pub fvu: f64,
}

/// Sums up errors block by block, in f64.
#[derive(Clone, Debug)]
pub struct MapErrorSum {
    n_samples: usize,
    abs: f64,
    squares: f64,
    sum: Vec<f64>,
    sum_of_squares: Vec<f64>,
}

impl MapErrorSum {
    /// Starts with no sample of `n_surface` nodes.
    #[must_use]
    pub fn new(n_surface: usize) -> Self {
        let zeros = vec![0.0; n_surface];
        Self { n_samples: 0, abs: 0.0, squares: 0.0, sum: zeros.clone(), sum_of_squares: zeros }
    }

    /// Takes in true and reconstructed maps, both `[n, n_surface]`, µm.
    pub fn add(&mut self, truth: &[f32], found: &[f32]) {
        let width = self.sum.len();
        for (truth, found) in truth.chunks_exact(width).zip(found.chunks_exact(width)) {
            self.n_samples += 1;
            for (node, (y, z)) in truth.iter().zip(found).enumerate() {
                let (y, error) = (f64::from(*y), f64::from(*y) - f64::from(*z));
                self.abs += error.abs();
                self.squares += error * error;
                self.sum[node] += y;
                self.sum_of_squares[node] += y * y;
            }
        }
    }

    /// The errors so far; NaN without any sample.
    #[must_use]
    pub fn finish(&self) -> MapError {
        let n_samples = self.n_samples as f64;
        let n_values = n_samples * self.sum.len() as f64;
        let per_node = self.sum.iter().zip(&self.sum_of_squares);
        let variance: f64 = per_node.map(|(sum, squares)| squares - sum * sum / n_samples).sum();
        MapError {
            mean_abs_um: self.abs / n_values,
            rms_um: (self.squares / n_values).sqrt(),
            fvu: self.squares / variance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: [f32; 6] = [1.0, 10.0, 2.0, 20.0, 3.0, 60.0];

    #[test]
    fn each_nodes_mean_leaves_all_variance_unexplained() {
        let mut sum = MapErrorSum::new(2);
        sum.add(&TRUTH, &[2.0, 30.0, 2.0, 30.0, 2.0, 30.0]);
        assert!((sum.finish().fvu - 1.0).abs() < 1e-12);
    }

    #[test]
    fn errors_of_one_and_three() {
        let mut sum = MapErrorSum::new(2);
        sum.add(&TRUTH[..2], &[2.0, 13.0]);
        let error = sum.finish();
        assert!((error.mean_abs_um - 2.0).abs() < 1e-12);
        assert!((error.rms_um - 5.0_f64.sqrt()).abs() < 1e-12);
    }
}
