//! Layers as two thinner ones.

use hapdef_nets::infer::{InferParams, LowRank, Precision};
use hapdef_nets::{Activation, Layer, MlpSpec, Net, Scale};

use super::support::{inputs, largest, net_of, plain, prepared, random_net};

/// Singular values 1, 1/2, 1/4, … are known; so is what the best approximation leaves out.
#[test]
fn the_first_singular_vectors_are_found() {
    let n = 24;
    let angle = |i: usize, j: usize| (2.0 * std::f64::consts::PI * (i * j) as f64 / n as f64).cos();
    let hartley = |i: usize, j: usize| {
        let sine = (2.0 * std::f64::consts::PI * (i * j) as f64 / n as f64).sin();
        (angle(i, j) + sine) / (n as f64).sqrt()
    };
    let weight = |o: usize, i: usize| -> f64 {
        (0..n).map(|k| 0.5f64.powi(k as i32) * hartley(o, k) * hartley((5 * k + 1) % n, i)).sum()
    };
    let weights = (0..n * n).map(|k| weight(k / n, k % n) as f32).collect();
    let spec = MlpSpec { inputs: n, hidden: vec![], outputs: n, activation: Activation::Relu };
    let net = net_of(&spec, vec![Layer { weights, bias: vec![0.25; n] }]);
    for rank in [1, 3, 6] {
        let (low_rank, info) = LowRank::of_weights(&net, 0, rank).unwrap();
        let best = 0.25f64.powi(rank as i32);
        assert!((info.left_out / best - 1.0).abs() < 1e-3, "rank {rank}: {info:?}, best {best:e}");
        let params = InferParams { low_rank: vec![low_rank], ..InferParams::of(Precision::F32) };
        let x = inputs(n, 7);
        let (found, exact) = (prepared(&net, &params, &x), plain(&net, &x));
        let largest_left = 0.5f64.powi(rank as i32) * 0.5;
        let size = x.iter().map(|x| f64::from((x - 0.3) / 2.0).powi(2)).sum::<f64>().sqrt();
        let error: f64 = found.iter().zip(&exact).map(|(f, e)| f64::from(f - e).powi(2)).sum();
        assert!(error.sqrt() <= largest_left * size * 1.001 + 1e-5, "rank {rank}: {error:e}");
    }
}

/// Outputs that lie in a plane need rank 2, whatever the weights' own rank.
#[test]
fn samples_show_the_rank_that_is_needed() {
    let net = random_net(&[2, 40, 60, 90], Activation::Tanh, 8);
    let x: Vec<f32> = (0..400).map(|i| 0.3 + 0.02 * (i as f32 * 0.7).sin()).collect();
    let (low_rank, info) = LowRank::of_samples(&net, 2, &x, 8).unwrap();
    assert!(info.left_out < 1e-9, "{info:?}");
    for precision in [Precision::F32, Precision::Int8Weights] {
        let params = InferParams { low_rank: vec![low_rank.clone()], ..InferParams::of(precision) };
        let (found, exact) = (prepared(&net, &params, &x[..2]), plain(&net, &x[..2]));
        let tolerance = if precision == Precision::F32 { 1e-4 } else { 3e-2 };
        for (f, e) in found.iter().zip(&exact) {
            assert!(
                f64::from((f - e).abs()) < tolerance * largest(&exact),
                "{precision:?} {f} {e}"
            );
        }
    }
    let hidden = LowRank::of_samples(&net, 1, &x, 8).unwrap();
    assert!(hidden.1.left_out < 1e-9 && hidden.0.layer() == 1);
}

/// An output that never varied in training stays at its mean, whatever the modes are.
#[test]
fn a_constant_output_stays_at_its_mean() {
    let net = random_net(&[6, 20, 12, 9], Activation::Relu, 4);
    let mut std = net.output_scale().std().to_vec();
    std[5] = 0.0;
    let output = Scale::new(net.output_scale().mean().to_vec(), std).unwrap();
    let net = Net::new(net.mlp().clone(), net.input_scale().clone(), output).unwrap();
    let samples: Vec<f32> = (0..40).flat_map(|seed| inputs(6, seed)).collect();
    let (low_rank, info) = LowRank::of_samples(&net, 2, &samples, 7).unwrap();
    assert!(info.left_out.is_finite() && info.left_out < 0.1, "{info:?}");
    let params = InferParams { low_rank: vec![low_rank], ..InferParams::of(Precision::F32) };
    let x = inputs(6, 50);
    let (found, exact) = (prepared(&net, &params, &x), plain(&net, &x));
    assert_eq!((found[5], exact[5]), (-1.0, -1.0));
    let apart = found.iter().zip(&exact).map(|(f, e)| (f - e).abs());
    assert!(apart.fold(0.0, f32::max) < 0.5, "{found:?} {exact:?}");
}
