//! How the weights of a network begin.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::{Layer, Mlp};
use crate::activation::Activation;
use crate::error::NetsError;
use crate::spec::MlpSpec;

impl Mlp {
    /// A network with random weights that depend on `seed` alone.
    ///
    /// Layers before a ReLU: uniform with variance 2/n_in (K. He et al., "Delving Deep into
    /// Rectifiers", ICCV 2015, arXiv 1502.01852, equation 10). Layers before tanh and the last:
    /// uniform with variance 2/(n_in + n_out) (X. Glorot and Y. Bengio, "Understanding the
    /// difficulty of training deep feedforward neural networks", AISTATS 2010, equation 16).
    /// Biases 0. Fails if a width is 0.
    pub fn random(spec: &MlpSpec, seed: u64) -> Result<Self, NetsError> {
        spec.check()?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let shapes = spec.layer_shapes();
        let last = shapes.len() - 1;
        let layers = shapes.iter().enumerate().map(|(i, &(n_in, n_out))| {
            let variance = match spec.activation {
                Activation::Relu if i < last => 2.0 / n_in as f64,
                _ => 2.0 / (n_in + n_out) as f64,
            };
            Layer {
                weights: uniform(&mut rng, n_in * n_out, (3.0 * variance).sqrt() as f32),
                bias: vec![0.0; n_out],
            }
        });
        Ok(Self { spec: spec.clone(), layers: layers.collect() })
    }
}

/// `n` numbers uniform in ±`bound`.
fn uniform(rng: &mut ChaCha8Rng, n: usize, bound: f32) -> Vec<f32> {
    let unit = |word: u32| (word >> 8) as f32 * 2f32.powi(-24);
    (0..n).map(|_| bound * (2.0 * unit(rng.next_u32()) - 1.0)).collect()
}
