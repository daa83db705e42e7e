//! Outputs by their modes: nothing is lost but what the modes leave out.

use crate::training_common;

use hapdef_nets::train::{BatchSource, MemorySource, OutputModes, train, validation_loss};
use hapdef_nets::{Activation, Layer, Mlp, MlpSpec, Net, NetsError, Scale, TrainParams};
use training_common::{PARAMS, go_on};

const N_OUT: usize = 12;

/// Samples whose outputs are sums of `n_modes` patterns with falling weights.
fn samples(n: usize, n_modes: usize) -> MemorySource {
    let x: Vec<f32> = (0..3 * n).map(|i| (1.618 * (i * i % 9973) as f32).sin()).collect();
    let y = x.chunks(3).flat_map(|p| {
        let (a, b, c) = (p[0], p[1], p[2]);
        let parts = [a * b, c, (2.0 * a - b).sin(), b * c, a * a, c * a];
        (0..N_OUT).map(move |o| {
            let share =
                |m: usize| 0.5_f32.powi(m as i32) * ((1 + m) as f32 * o as f32 + m as f32).sin();
            3.0 + (0..n_modes).map(|m| share(m) * parts[m]).sum::<f32>()
        })
    });
    let y = y.collect();
    MemorySource::new(3, N_OUT, x, y).unwrap()
}

fn output_scale() -> Scale {
    let std = (0..N_OUT).map(|o| 0.5 + 0.1 * o as f32).collect();
    Scale::new(vec![3.0; N_OUT], std).unwrap()
}

fn rows(n: usize) -> Vec<usize> {
    (0..n).collect()
}

fn net_of_coordinates(rank: usize) -> Net {
    let spec =
        MlpSpec { inputs: 3, hidden: vec![40, 40], outputs: rank, activation: Activation::Relu };
    let mlp = Mlp::random(&spec, 3).unwrap();
    Net::new(mlp, Scale::identity(3), Scale::identity(rank)).unwrap()
}

#[test]
fn an_unfolded_net_has_the_loss_of_its_coordinates_and_what_they_leave_out() {
    for rank in [2, 4, 6] {
        let mut all = samples(400, 6);
        let modes = OutputModes::of_samples(&mut all, &rows(400), &output_scale(), rank).unwrap();
        let net = net_of_coordinates(rank);
        let in_modes = validation_loss(&net, &mut modes.source(&mut all)).unwrap();
        let unfolded = validation_loss(&modes.unfold(&net).unwrap(), &mut all).unwrap();
        let total = validation_loss(&zero_net(net.mlp().spec()), &mut all).unwrap();
        let expected = (in_modes.powi(2) + modes.left_out() * total.powi(2)).sqrt();
        assert!((unfolded / expected - 1.0).abs() < 1e-4, "{rank}: {unfolded} {expected}");
    }
}

/// A net whose standardised output is 0, with the samples' scale.
fn zero_net(spec: &MlpSpec) -> Net {
    let spec = MlpSpec { outputs: N_OUT, ..spec.clone() };
    let layers = spec
        .layer_shapes()
        .into_iter()
        .map(|(n_in, n_out)| Layer { weights: vec![0.0; n_in * n_out], bias: vec![0.0; n_out] });
    let mlp = Mlp::from_layers(&spec, layers.collect()).unwrap();
    Net::new(mlp, Scale::identity(3), output_scale()).unwrap()
}

#[test]
fn more_modes_leave_out_less_and_all_of_them_nothing() {
    let mut all = samples(400, 6);
    let mut left_out = |rank| {
        let modes = OutputModes::of_samples(&mut all, &rows(400), &output_scale(), rank);
        modes.unwrap().left_out()
    };
    let shares: Vec<f64> = (1..=6).map(&mut left_out).collect();
    assert!(shares.windows(2).all(|w| w[1] < w[0]), "{shares:?}");
    assert!(shares[5] < 1e-6, "{shares:?}");
}

#[test]
fn a_net_trained_in_coordinates_learns_the_outputs() {
    let (mut all, mut unseen) = (samples(2000, 4), samples(2300, 4));
    let modes = OutputModes::of_samples(&mut all, &rows(400), &output_scale(), 4).unwrap();
    let mut net = net_of_coordinates(4);
    let before = validation_loss(&modes.unfold(&net).unwrap(), &mut unseen).unwrap();
    let params = TrainParams { steps: 2000, learning_rate: 3e-3, l2: 0.0, ..PARAMS };
    let mut source = modes.source(&mut all);
    train(&mut net, &mut source, None, &params, None, &mut go_on).unwrap();
    let after = validation_loss(&modes.unfold(&net).unwrap(), &mut unseen).unwrap();
    assert!(after < 0.1 * before, "{before} before, {after} after");
}

#[test]
fn ranks_that_do_not_fit_and_nets_that_scale_are_refused() {
    let mut all = samples(400, 6);
    for (rank, n) in [(0, 400), (N_OUT + 1, 400), (6, 5)] {
        let modes = OutputModes::of_samples(&mut all, &rows(n), &output_scale(), rank);
        assert!(matches!(modes, Err(NetsError::Rank { .. })), "{rank} {n}");
    }
    let modes = OutputModes::of_samples(&mut all, &rows(400), &output_scale(), 2).unwrap();
    assert!(modes.unfold(&net_of_coordinates(3)).is_err());
    let net = net_of_coordinates(2);
    let scaled = Scale::new(vec![0.0; 2], vec![2.0; 2]).unwrap();
    let net = Net::new(net.mlp().clone(), Scale::identity(3), scaled).unwrap();
    assert!(matches!(modes.unfold(&net), Err(NetsError::ScaledCoordinates)));
    assert_eq!(modes.source(&mut all).n_outputs(), 2);
}
