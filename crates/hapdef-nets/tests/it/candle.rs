//! Training on candle's tensors against training on slices.

use crate::training_common;

use std::ops::ControlFlow;

use hapdef_nets::train::{resume, train};
use hapdef_nets::{Activation, Loss, Net, NetsError, TrainBackend, TrainParams};
use training_common::{PARAMS, go_on, net, samples};

const CANDLE: TrainParams = TrainParams { backend: TrainBackend::Candle, ..PARAMS };

fn trained(params: &TrainParams, activation: Activation) -> Net {
    let mut net = net(&[16, 16], activation);
    let mut source = samples(500, 0.0);
    train(&mut net, &mut source, None, params, None, &mut go_on).unwrap();
    net
}

#[test]
fn both_backends_take_the_same_steps() {
    let cases = [
        (Activation::Relu, Loss::RootMeanSquare),
        (Activation::Tanh, Loss::RootMeanSquare),
        (Activation::Tanh, Loss::MeanOfSamples),
    ];
    for (activation, loss) in cases {
        let before = net(&[16, 16], activation);
        let trained = |params: TrainParams| trained(&TrainParams { loss, ..params }, activation);
        let (ours, candle) = (trained(PARAMS), trained(CANDLE));
        let layers = before.mlp().layers().iter().zip(ours.mlp().layers());
        for ((before, ours), candle) in layers.zip(candle.mlp().layers()) {
            for ((w0, w), c) in before.weights.iter().zip(&ours.weights).zip(&candle.weights) {
                let way = (w - w0).abs();
                assert!((w - c).abs() < 1e-3 * way + 2e-6, "{w0} to {w}, candle's {c}");
            }
        }
        assert_ne!(before, ours);
    }
}

#[test]
fn a_break_changes_no_bit_on_candle() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("net.json");
    let whole = trained(&CANDLE, Activation::Relu);
    let mut broken = net(&[16, 16], Activation::Relu);
    let mut source = samples(500, 0.0);
    let mut stop = |progress: &hapdef_nets::train::Progress| match progress.step {
        7 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    train(&mut broken, &mut source, None, &CANDLE, Some(&path), &mut stop).unwrap();
    assert_ne!(broken, whole);
    let (resumed, _) = resume(&path, &mut source, None, &CANDLE, &mut go_on).unwrap();
    assert_eq!(resumed, whole);
    let error = resume(&path, &mut source, None, &PARAMS, &mut go_on).unwrap_err();
    assert!(matches!(error, NetsError::ResumeParams { name: "backend", .. }), "{error}");
}

#[test]
fn a_gpu_that_is_not_there_is_an_error() {
    let backend = TrainBackend::Cuda { ordinal: 1000 };
    let params = TrainParams { backend, ..PARAMS };
    let mut net = net(&[16], Activation::Relu);
    let error =
        train(&mut net, &mut samples(50, 0.0), None, &params, None, &mut go_on).unwrap_err();
    let is_said = if cfg!(feature = "cuda") {
        matches!(error, NetsError::NoGpu { ordinal: 1000, .. })
    } else {
        matches!(error, NetsError::NoBackend { backend: found } if found == backend)
    };
    assert!(is_said, "{error}");
}
