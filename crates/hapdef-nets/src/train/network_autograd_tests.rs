//! Gradients against candle's automatic ones.

use candle_core::{Device, Tensor, Var};
use proptest::prelude::*;

use super::{Activation, Loss, Mlp, assert_close, example, gradients};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn derivatives_are_those_of_candle_s_autograd(
        seed in 0..1000u64,
        relu in any::<bool>(),
        of_samples in any::<bool>(),
    ) {
        let activation = if relu { Activation::Relu } else { Activation::Tanh };
        let kind = if of_samples { Loss::MeanOfSamples } else { Loss::RootMeanSquare };
        let (mlp, x, y) = example(activation, seed);
        let (loss, found) = gradients(&mlp, (&x, &y), kind);
        let (expected_loss, expected) = autograd(&mlp, &x, &y, kind);
        prop_assert!((loss / expected_loss - 1.0).abs() < 1e-6, "{loss} against {expected_loss}");
        assert_close(&found, &expected, 1e-5);
    }
}

fn autograd(mlp: &Mlp, x: &[f32], y: &[f32], kind: Loss) -> (f64, Vec<Vec<f32>>) {
    let var = |values: &[f32], shape: &[usize]| {
        Var::from_tensor(&Tensor::from_slice(values, shape, &Device::Cpu).unwrap()).unwrap()
    };
    let mut vars = vec![];
    let shapes = mlp.spec().layer_shapes();
    let (n_in, n_out) = (mlp.spec().inputs, mlp.spec().outputs);
    let batch = x.len() / n_in;
    let mut a = Tensor::from_slice(x, (batch, n_in), &Device::Cpu).unwrap();
    let y = Tensor::from_slice(y, (batch, n_out), &Device::Cpu).unwrap();
    for (i, (layer, (n_in, n_out))) in mlp.layers().iter().zip(&shapes).enumerate() {
        let w = var(&layer.weights, &[*n_out, *n_in]);
        let b = var(&layer.bias, &[*n_out]);
        a = a.matmul(&w.t().unwrap()).unwrap().broadcast_add(&b).unwrap();
        if i + 1 < shapes.len() {
            a = match mlp.spec().activation {
                Activation::Relu => a.relu().unwrap(),
                Activation::Tanh => a.tanh().unwrap(),
            };
        }
        vars.extend([w, b]);
    }
    let squares = (a - y).unwrap().sqr().unwrap();
    let root = |mean: candle_core::Result<Tensor>| mean.unwrap().sqrt().unwrap();
    let loss = match kind {
        Loss::RootMeanSquare => root(squares.mean_all()),
        Loss::MeanOfSamples => root(squares.mean(1)).mean_all().unwrap(),
    };
    let store = loss.backward().unwrap();
    let found = vars.iter().map(|v| {
        let gradient = store.get(v).unwrap().flatten_all().unwrap();
        gradient.to_vec1().unwrap()
    });
    (f64::from(loss.to_scalar::<f32>().unwrap()), found.collect())
}
