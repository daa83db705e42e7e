//! Prepared nets against the plain forward pass, candle, and the formulas in f64.

mod bound;
mod low_rank;
mod refusals;
mod support;

use hapdef_nets::infer::{InferParams, Precision, PreparedNet, SimdLevel};
use hapdef_nets::{Activation, Mlp, MlpSpec};
use proptest::prelude::*;

use bound::with_bound;
use support::{at, inputs, largest, net_of, plain, prepared, random_net};

fn activation(relu: bool) -> Activation {
    if relu { Activation::Relu } else { Activation::Tanh }
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

#[cfg(feature = "candle")]
#[test]
fn f32_agrees_with_candle() {
    use candle_core::{Device, Tensor};
    for activation in [Activation::Relu, Activation::Tanh] {
        let net = random_net(&[24, 300, 200, 333], activation, 5);
        let x = inputs(24, 5);
        let scale = net.input_scale();
        let standardised: Vec<f32> =
            (0..24).map(|i| (x[i] - scale.mean()[i]) / scale.std()[i]).collect();
        let mut a = Tensor::from_vec(standardised, (1, 24), &Device::Cpu).unwrap();
        for (i, layer) in net.mlp().layers().iter().enumerate() {
            let shape = (layer.bias.len(), a.dim(1).unwrap());
            let w = Tensor::from_slice(&layer.weights, shape, &Device::Cpu).unwrap();
            let b = Tensor::from_slice(&layer.bias, layer.bias.len(), &Device::Cpu).unwrap();
            a = a.matmul(&w.t().unwrap()).unwrap().broadcast_add(&b).unwrap();
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
    let info = whole.forward(&inputs(16, 1), &mut whole.scratch(), &mut out).unwrap();
    let first = 16 * 512 * 4;
    let live = (info.weight_bytes - first) / (64 * 4);
    assert!((100..412).contains(&live), "{live} of 512 live");
}
