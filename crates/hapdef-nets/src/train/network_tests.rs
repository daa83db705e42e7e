//! Gradients against finite differences.

use proptest::prelude::*;

use super::*;
use crate::spec::MlpSpec;

#[cfg(feature = "candle")]
#[path = "network_autograd_tests.rs"]
mod autograd;

fn example(activation: Activation, seed: u64) -> (Mlp, Vec<f32>, Vec<f32>) {
    let spec = MlpSpec { inputs: 3, hidden: vec![7, 5], outputs: 4, activation };
    let mut mlp = Mlp::random(&spec, seed).unwrap();
    // Biases away from 0, so that their derivatives are tested too.
    let mut layers = mlp.layers().to_vec();
    for layer in &mut layers {
        let n = layer.bias.len();
        layer.bias = (0..n).map(|i| 0.1 * ((i as f32) + seed as f32).sin()).collect();
    }
    mlp = Mlp::from_layers(&spec, layers).unwrap();
    let values = |n: usize, phase: f32| -> Vec<f32> {
        (0..n).map(|i| (1.7 * i as f32 + phase).sin()).collect()
    };
    (mlp, values(6 * 3, seed as f32), values(6 * 4, 0.3))
}

/// Leaves weights as they are and puts the derivatives in place of the first moments.
struct Keep;

impl Update for Keep {
    fn weights(&self, part: Part<'_>, gradient: &[f32]) -> f64 {
        part.m.copy_from_slice(gradient);
        0.0
    }

    fn biases(&self, part: Part<'_>, gradient: &[f32]) -> f64 {
        self.weights(part, gradient)
    }
}

/// Loss and derivatives, weights then bias, first layer first.
fn gradients(mlp: &Mlp, (x, y): (&[f32], &[f32]), loss: Loss) -> (f64, Vec<Vec<f32>>) {
    let mut network = Network::new(mlp);
    let loss = network.forward(loss, x, y);
    let mut found = Moments::zeros(mlp);
    network.backward(x, &mut found, &Keep);
    let each = found.into_iter();
    (loss, each.flat_map(|m| [m.weights_m, m.bias_m]).collect())
}

#[track_caller]
fn assert_close(found: &[Vec<f32>], expected: &[Vec<f32>], tolerance: f32) {
    assert_eq!(found.len(), expected.len());
    for (tensor, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_eq!(found.len(), expected.len());
        let largest = expected.iter().fold(1e-3f32, |m, v| m.max(v.abs()));
        for (i, (f, e)) in found.iter().zip(expected).enumerate() {
            assert!((f - e).abs() <= tolerance * largest, "tensor {tensor}, {i}: {f} against {e}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn derivatives_are_finite_differences_of_the_loss(
        seed in 0..1000u64,
        layer in 0..3usize,
        pick in any::<prop::sample::Index>(),
        of_bias in any::<bool>(),
        of_samples in any::<bool>(),
    ) {
        let kind = if of_samples { Loss::MeanOfSamples } else { Loss::RootMeanSquare };
        let (mlp, x, y) = example(Activation::Tanh, seed);
        let (_, found) = gradients(&mlp, (&x, &y), kind);
        let derivative = &found[2 * layer + usize::from(of_bias)];
        let index = pick.index(derivative.len());
        let loss_at = |shift: f32| {
            let mut layers = mlp.layers().to_vec();
            let values = if of_bias { &mut layers[layer].bias } else { &mut layers[layer].weights };
            values[index] += shift;
            let mlp = Mlp::from_layers(mlp.spec(), layers).unwrap();
            gradients(&mlp, (&x, &y), kind).0
        };
        let h = 4e-3;
        let difference = (loss_at(h) - loss_at(-h)) / (2.0 * f64::from(h));
        prop_assert!(
            (f64::from(derivative[index]) - difference).abs() < 2e-4,
            "{} against {difference}", derivative[index]
        );
    }

    #[test]
    fn a_batch_forward_is_the_lean_forward(seed in 0..1000u64, relu in any::<bool>()) {
        let activation = if relu { Activation::Relu } else { Activation::Tanh };
        let (mlp, x, _) = example(activation, seed);
        let mut lean = vec![0.0; 6 * 4];
        mlp.forward_batch(&x, &mut crate::Scratch::default(), &mut lean).unwrap();
        let mut network = Network::new(&mlp);
        assert_close(&[network.predict(&x).to_vec()], &[lean], 1e-5);
    }
}

#[test]
fn a_perfect_fit_has_no_gradient() {
    let (mlp, x, _) = example(Activation::Relu, 1);
    let y = Network::new(&mlp).predict(&x).to_vec();
    for kind in [Loss::RootMeanSquare, Loss::MeanOfSamples] {
        let (loss, found) = gradients(&mlp, (&x, &y), kind);
        assert_eq!(loss, 0.0);
        assert!(found.iter().flatten().all(|g| *g == 0.0));
    }
}
