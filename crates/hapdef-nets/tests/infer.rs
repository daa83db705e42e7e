//! Prepared nets against the plain forward pass, candle, and the formulas in f64.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use hapdef_nets::infer::{InferParams, LowRank, Precision, PreparedNet, SimdLevel};
use hapdef_nets::{Activation, Layer, Mlp, MlpSpec, Net, NetsError, Scale, Scratch};
use proptest::prelude::*;

fn random_net(widths: &[usize], activation: Activation, seed: u64) -> Net {
    let spec = MlpSpec {
        inputs: widths[0],
        hidden: widths[1..widths.len() - 1].to_vec(),
        outputs: widths[widths.len() - 1],
        activation,
    };
    let mut layers = Mlp::random(&spec, seed).unwrap().layers().to_vec();
    for layer in &mut layers {
        for (i, bias) in layer.bias.iter_mut().enumerate() {
            *bias = 0.1 * (i as f32 + seed as f32 * 1e-6).sin();
        }
    }
    net_of(&spec, layers)
}

fn net_of(spec: &MlpSpec, layers: Vec<Layer>) -> Net {
    let mlp = Mlp::from_layers(spec, layers).unwrap();
    let input = Scale::new(vec![0.3; spec.inputs], vec![2.0; spec.inputs]).unwrap();
    let output = Scale::new(vec![-1.0; spec.outputs], vec![0.5; spec.outputs]).unwrap();
    Net::new(mlp, input, output).unwrap()
}

fn inputs(n: usize, seed: u64) -> Vec<f32> {
    let phase = (seed % 1000) as f32;
    (0..n)
        .map(|i| 3.0 * (i as f32 * 1.3 + phase).sin())
        .collect()
}

fn plain(net: &Net, x: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; net.mlp().spec().outputs];
    net.forward(x, &mut Scratch::default(), &mut out).unwrap();
    out
}

fn prepared(net: &Net, params: &InferParams, x: &[f32]) -> Vec<f32> {
    let prepared = PreparedNet::new(net, params).unwrap();
    let mut out = vec![0.0; prepared.n_outputs()];
    prepared
        .forward(x, &mut prepared.scratch(), &mut out)
        .unwrap();
    out
}

fn at(precision: Precision, simd: SimdLevel) -> InferParams {
    InferParams {
        simd: Some(simd),
        ..InferParams::of(precision)
    }
}

fn largest(values: &[f32]) -> f64 {
    values.iter().fold(0.0, |m, v| f64::from(v.abs()).max(m))
}

/// The outputs in f64 and the stated error bound of `precision` for each, in raw units.
fn with_bound(net: &Net, precision: Precision, x: &[f32]) -> Vec<(f64, f64)> {
    let scale = net.input_scale();
    let mut a: Vec<(f64, f64)> = (0..x.len())
        .map(|i| (f64::from((x[i] - scale.mean()[i]) / scale.std()[i]), 0.0))
        .collect();
    let last = net.mlp().layers().len() - 1;
    for (l, layer) in net.mlp().layers().iter().enumerate() {
        // What the bytes are made of: the approximate activations.
        let largest = a.iter().fold(0.0f64, |m, (v, e)| m.max(v.abs() + e));
        let is_signed = net.mlp().spec().activation == Activation::Tanh;
        let step = match precision {
            Precision::Int8 if l > 0 => largest / if is_signed { 127.0 } else { 255.0 },
            _ => 0.0,
        };
        let rows = layer.weights.chunks(a.len()).zip(&layer.bias);
        a = rows
            .map(|(row, &bias)| {
                let row_max = row.iter().fold(0.0f64, |m, w| m.max(f64::from(w.abs())));
                let (mut z, mut error, mut size) = (f64::from(bias), 0.0, f64::from(bias.abs()));
                for (&w, (x, e)) in row.iter().zip(&a) {
                    let w = f64::from(w);
                    let dw = match precision {
                        Precision::F32 => 0.0,
                        Precision::Bf16 => w.abs() / 256.0 + 1e-40,
                        _ => row_max / 254.0 + 1e-44,
                    };
                    let dx = e + step / 2.0;
                    z += w * x;
                    size += w.abs() * (x.abs() + dx);
                    error += w.abs() * dx + dw * (x.abs() + dx);
                }
                // Rounding of f32 sums and products.
                error += 4e-7 * size * (row.len() as f64).sqrt().max(2.0) + 1e-37;
                match net.mlp().spec().activation {
                    _ if l == last => (z, error),
                    Activation::Tanh => (z.tanh(), error.min(2.0) + 3e-7),
                    Activation::Relu => (z.max(0.0), error),
                }
            })
            .collect();
    }
    let scale = net.output_scale();
    a.iter()
        .enumerate()
        .map(|(i, (z, e))| {
            let (mean, std) = (f64::from(scale.mean()[i]), f64::from(scale.std()[i]));
            (
                z * std + mean,
                e * std + 1e-6 * (z * std + mean).abs() + 1e-7,
            )
        })
        .collect()
}

fn activation(relu: bool) -> Activation {
    if relu {
        Activation::Relu
    } else {
        Activation::Tanh
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn f32_is_the_plain_forward_on_every_level(
        widths in prop::collection::vec(1..150usize, 2..5),
        seed in any::<u64>(),
        relu in any::<bool>(),
    ) {
        let net = random_net(&widths, activation(relu), seed);
        let x = inputs(widths[0], seed);
        let expected = plain(&net, &x);
        for level in SimdLevel::available() {
            let found = prepared(&net, &at(Precision::F32, level), &x);
            for (f, e) in found.iter().zip(&expected) {
                let error = f64::from((f - e).abs());
                prop_assert!(error <= 1e-5 * largest(&expected), "{level:?}: {f} against {e}");
            }
        }
    }

    #[test]
    fn every_precision_keeps_its_bound_on_every_level(
        widths in prop::collection::vec(1..90usize, 2..5),
        seed in any::<u64>(),
        relu in any::<bool>(),
    ) {
        let net = random_net(&widths, activation(relu), seed);
        let x = inputs(widths[0], seed);
        for precision in Precision::ALL {
            let bounds = with_bound(&net, precision, &x);
            for level in SimdLevel::available() {
                let found = prepared(&net, &at(precision, level), &x);
                for (f, (e, bound)) in found.iter().zip(&bounds) {
                    let error = (f64::from(*f) - e).abs();
                    prop_assert!(error <= *bound, "{precision:?} {level:?}: {error:e} > {bound:e}");
                }
            }
        }
    }

    /// Rows of very different size, zeros among them, and inputs of any size.
    #[test]
    fn extreme_rows_keep_their_bound(
        exponents in prop::collection::vec(-44..30i32, 20),
        of_input in -30..6i32,
        seed in any::<u64>(),
    ) {
        let spec = MlpSpec { inputs: 9, hidden: vec![], outputs: 21, activation: Activation::Relu };
        let mut layers = Mlp::random(&spec, seed).unwrap().layers().to_vec();
        for (row, exponent) in layers[0].weights.chunks_mut(9).zip(&exponents) {
            row.iter_mut().for_each(|w| *w = (f64::from(*w) * 10f64.powi(*exponent)) as f32);
        }
        layers[0].weights[20 * 9..].fill(0.0);
        let net = net_of(&spec, layers);
        let x: Vec<f32> = inputs(9, seed).iter().map(|x| x * 10f32.powi(of_input)).collect();
        for precision in Precision::ALL {
            let bounds = with_bound(&net, precision, &x);
            for level in SimdLevel::available() {
                let found = prepared(&net, &at(precision, level), &x);
                for (f, (e, bound)) in found.iter().zip(&bounds) {
                    let error = (f64::from(*f) - e).abs();
                    prop_assert!(error <= *bound, "{precision:?} {level:?}: {error:e} > {bound:e}");
                }
            }
        }
    }

    #[test]
    fn wanted_outputs_have_the_bits_of_the_whole_net(
        widths in prop::collection::vec(1..300usize, 3),
        seed in any::<u64>(),
        picks in prop::collection::vec(any::<prop::sample::Index>(), 1..40),
    ) {
        let net = random_net(&widths, Activation::Relu, seed);
        let x = inputs(widths[0], seed);
        let wanted: Vec<usize> = picks.iter().map(|pick| pick.index(widths[2])).collect();
        for precision in Precision::ALL {
            for level in SimdLevel::available() {
                let whole = prepared(&net, &at(precision, level), &x);
                let params = InferParams { wanted: Some(wanted.clone()), ..at(precision, level) };
                let part = prepared(&net, &params, &x);
                let expected: Vec<u32> = wanted.iter().map(|&o| whole[o].to_bits()).collect();
                let found: Vec<u32> = part.iter().map(|v| v.to_bits()).collect();
                prop_assert_eq!(&found, &expected, "{:?} {:?}", precision, level);
            }
        }
    }
}

#[test]
fn a_net_of_the_paper_s_size_agrees_with_the_plain_forward() {
    for widths in [vec![10, 250, 250, 240], vec![240, 600, 1200, 1800, 500]] {
        for activation in [Activation::Relu, Activation::Tanh] {
            let net = random_net(&widths, activation, 3);
            let x = inputs(widths[0], 3);
            let expected = plain(&net, &x);
            let found = prepared(&net, &InferParams::of(Precision::F32), &x);
            let worst = found.iter().zip(&expected);
            let worst = worst.fold(0.0f64, |m, (f, e)| m.max(f64::from((f - e).abs())));
            let relative = worst / largest(&expected);
            assert!(relative < 1e-5, "{widths:?} {activation:?}: {relative:e}");
        }
    }
}

#[cfg(feature = "train")]
#[test]
fn f32_agrees_with_candle() {
    use candle_core::{Device, Tensor};
    for activation in [Activation::Relu, Activation::Tanh] {
        let net = random_net(&[24, 300, 200, 333], activation, 5);
        let x = inputs(24, 5);
        let scale = net.input_scale();
        let standardised: Vec<f32> = (0..24)
            .map(|i| (x[i] - scale.mean()[i]) / scale.std()[i])
            .collect();
        let mut a = Tensor::from_vec(standardised, (1, 24), &Device::Cpu).unwrap();
        for (i, layer) in net.mlp().layers().iter().enumerate() {
            let shape = (layer.bias.len(), a.dim(1).unwrap());
            let w = Tensor::from_slice(&layer.weights, shape, &Device::Cpu).unwrap();
            let b = Tensor::from_slice(&layer.bias, layer.bias.len(), &Device::Cpu).unwrap();
            a = a
                .matmul(&w.t().unwrap())
                .unwrap()
                .broadcast_add(&b)
                .unwrap();
            a = match activation {
                _ if i == 2 => a,
                Activation::Relu => a.relu().unwrap(),
                Activation::Tanh => a.tanh().unwrap(),
            };
        }
        let expected: Vec<f32> = a.flatten_all().unwrap().to_vec1().unwrap();
        let found = prepared(&net, &InferParams::of(Precision::F32), &x);
        for (f, e) in found.iter().zip(&expected) {
            let error = f64::from((f - (e * 0.5 - 1.0)).abs());
            assert!(error <= 1e-5 * largest(&found), "{activation:?}: {error:e}");
        }
    }
}

#[test]
fn zeros_after_a_relu_are_not_read() {
    let net = random_net(&[16, 512, 64], Activation::Relu, 1);
    let whole = PreparedNet::new(&net, &InferParams::of(Precision::F32)).unwrap();
    let mut out = vec![0.0; 64];
    let info = whole
        .forward(&inputs(16, 1), &mut whole.scratch(), &mut out)
        .unwrap();
    let first = 16 * 512 * 4;
    let live = (info.weight_bytes - first) / (64 * 4);
    assert!((100..412).contains(&live), "{live} of 512 live");
}

#[test]
fn what_a_relu_would_hide_is_refused() {
    let mut layers = random_net(&[4, 8, 3], Activation::Relu, 2)
        .mlp()
        .layers()
        .to_vec();
    layers[0].weights.iter_mut().for_each(|w| *w *= 100.0);
    let spec = MlpSpec {
        inputs: 4,
        hidden: vec![8],
        outputs: 3,
        activation: Activation::Relu,
    };
    let net = net_of(&spec, layers);
    for precision in Precision::ALL {
        let prepared = PreparedNet::new(&net, &InferParams::of(precision)).unwrap();
        let (mut scratch, mut out) = (prepared.scratch(), [0.0; 3]);
        for bad in [f32::NAN, f32::INFINITY] {
            let error = prepared.forward(&[0.0, 0.0, bad, 0.0], &mut scratch, &mut out);
            assert!(matches!(error, Err(NetsError::NotFinite { index: 2, .. })));
        }
        let error = prepared.forward(&[3e38, -3e38, 3e38, 3e38], &mut scratch, &mut out);
        assert!(
            matches!(error, Err(NetsError::Overflow { .. })),
            "{error:?}"
        );
        assert!(prepared.forward(&[0.0; 3], &mut scratch, &mut out).is_err());
        assert!(
            prepared
                .forward(&[0.0; 4], &mut scratch, &mut out[..2])
                .is_err()
        );
        prepared.forward(&[1.0; 4], &mut scratch, &mut out).unwrap();
    }
}

#[test]
fn what_the_net_lacks_is_refused() {
    let net = random_net(&[4, 8, 3], Activation::Relu, 2);
    let params = |wanted: &[usize]| InferParams {
        wanted: Some(wanted.to_vec()),
        ..InferParams::of(Precision::F32)
    };
    let refused = |params: &InferParams| PreparedNet::new(&net, params).unwrap_err();
    assert!(matches!(
        refused(&params(&[0, 3])),
        NetsError::NoSuchOutput {
            output: 3,
            n_outputs: 3
        }
    ));
    assert!(matches!(refused(&params(&[])), NetsError::NoOutputs));
    assert!(matches!(
        LowRank::of_weights(&net, 2, 1),
        Err(NetsError::NoSuchLayer {
            layer: 2,
            n_layers: 2
        })
    ));
    assert!(matches!(
        LowRank::of_weights(&net, 1, 4),
        Err(NetsError::Rank { rank: 4, most: 3 })
    ));
    let mut layers = net.mlp().layers().to_vec();
    layers[1].weights[0] = f32::NAN;
    let broken = net_of(net.mlp().spec(), layers);
    assert!(PreparedNet::new(&broken, &InferParams::of(Precision::Bf16)).is_err());
    if let Some(&missing) = [SimdLevel::Neon, SimdLevel::Avx2]
        .iter()
        .find(|l| !l.is_available())
    {
        let params = at(Precision::F32, missing);
        assert!(matches!(refused(&params), NetsError::Simd { .. }));
    }
}

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
        (0..n)
            .map(|k| 0.5f64.powi(k as i32) * hartley(o, k) * hartley((5 * k + 1) % n, i))
            .sum()
    };
    let weights = (0..n * n).map(|k| weight(k / n, k % n) as f32).collect();
    let spec = MlpSpec {
        inputs: n,
        hidden: vec![],
        outputs: n,
        activation: Activation::Relu,
    };
    let net = net_of(
        &spec,
        vec![Layer {
            weights,
            bias: vec![0.25; n],
        }],
    );
    for rank in [1, 3, 6] {
        let (low_rank, info) = LowRank::of_weights(&net, 0, rank).unwrap();
        let best = 0.25f64.powi(rank as i32);
        assert!(
            (info.left_out / best - 1.0).abs() < 1e-3,
            "rank {rank}: {info:?}, best {best:e}"
        );
        let params = InferParams {
            low_rank: vec![low_rank],
            ..InferParams::of(Precision::F32)
        };
        let x = inputs(n, 7);
        let (found, exact) = (prepared(&net, &params, &x), plain(&net, &x));
        let largest_left = 0.5f64.powi(rank as i32) * 0.5;
        let size = x
            .iter()
            .map(|x| f64::from((x - 0.3) / 2.0).powi(2))
            .sum::<f64>()
            .sqrt();
        let error: f64 = found
            .iter()
            .zip(&exact)
            .map(|(f, e)| f64::from(f - e).powi(2))
            .sum();
        assert!(
            error.sqrt() <= largest_left * size * 1.001 + 1e-5,
            "rank {rank}: {error:e}"
        );
    }
}

/// Outputs that lie in a plane need rank 2, whatever the weights' own rank.
#[test]
fn samples_show_the_rank_that_is_needed() {
    let net = random_net(&[2, 40, 60, 90], Activation::Tanh, 8);
    let x: Vec<f32> = (0..400)
        .map(|i| 0.3 + 0.02 * (i as f32 * 0.7).sin())
        .collect();
    let (low_rank, info) = LowRank::of_samples(&net, 2, &x, 8).unwrap();
    assert!(info.left_out < 1e-9, "{info:?}");
    for precision in [Precision::F32, Precision::Int8Weights] {
        let params = InferParams {
            low_rank: vec![low_rank.clone()],
            ..InferParams::of(precision)
        };
        let (found, exact) = (prepared(&net, &params, &x[..2]), plain(&net, &x[..2]));
        let tolerance = if precision == Precision::F32 {
            1e-4
        } else {
            3e-2
        };
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
