//! Small nets and samples that tests of the training share.

#![allow(dead_code, reason = "each test program uses some of it")]

use std::ops::ControlFlow;

use hapdef_nets::train::{MemorySource, Progress, TrainInfo, train};
use hapdef_nets::{Activation, Loss, Mlp, MlpSpec, Net, Scale, TrainBackend, TrainParams};

pub const PARAMS: TrainParams = TrainParams {
    steps: 20,
    batch: 32,
    learning_rate: 1e-3,
    final_learning_rate: Some(1e-5),
    warmup_steps: 0,
    loss: Loss::RootMeanSquare,
    l2: 1e-4,
    backend: TrainBackend::Slices,
    seed: 9,
    checkpoint_every: 0,
    validate_every: 0,
    keep_best: false,
    patience: 0,
};

pub fn net(hidden: &[usize], activation: Activation) -> Net {
    let spec = MlpSpec { inputs: 3, hidden: hidden.to_vec(), outputs: 2, activation };
    let input = Scale::new(vec![10.0; 3], vec![2.0; 3]).unwrap();
    let output = Scale::new(vec![0.0; 2], vec![100.0; 2]).unwrap();
    Net::new(Mlp::random(&spec, 1).unwrap(), input, output).unwrap()
}

/// Two smooth functions of three numbers.
pub fn samples(n: usize, phase: f32) -> MemorySource {
    let x: Vec<f32> =
        (0..3 * n).map(|i| 10.0 + 3.0 * (1.618 * (i * i % 9973) as f32 + phase).sin()).collect();
    let y = x.chunks(3).flat_map(|p| {
        let [a, b, c] = [p[0] - 10.0, p[1] - 10.0, p[2] - 10.0];
        [20.0 * a * b + 30.0 * c, 100.0 * (0.5 * a - b).sin()]
    });
    let y = y.collect();
    MemorySource::new(3, 2, x, y).unwrap()
}

pub fn go_on(_: &Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

pub fn run(net: &mut Net, params: &TrainParams) -> TrainInfo {
    train(net, &mut samples(500, 0.0), None, params, None, &mut go_on).unwrap()
}
