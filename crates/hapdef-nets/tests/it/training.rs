//! Training: that it learns, repeats itself, stops and says what is wrong.

use crate::training_common;

use std::ops::ControlFlow;
use std::process::Command;

use hapdef_nets::train::{
    BatchSource, MemorySource, Progress, SourceError, train, validation_loss,
};
use hapdef_nets::{Activation, Layer, Mlp, MlpSpec, Net, NetsError, Scale, Scratch, TrainParams};
use training_common::{PARAMS, go_on, net, run, samples};

fn refused(net: &mut Net, source: &mut dyn BatchSource, params: &TrainParams) -> NetsError {
    let before = net.clone();
    let error = train(net, source, None, params, None, &mut go_on).unwrap_err();
    assert_eq!(*net, before, "a failed training leaves the net as it was");
    error
}

#[track_caller]
fn check_learns(activation: Activation) {
    let mut net = net(&[32, 32], activation);
    let mut unseen = samples(300, 0.5);
    let before = validation_loss(&net, &mut unseen).unwrap();
    let params = TrainParams { steps: 3000, learning_rate: 3e-3, l2: 0.0, ..PARAMS };
    let mut source = samples(2000, 0.0);
    let info = train(&mut net, &mut source, Some(&mut unseen), &params, None, &mut go_on).unwrap();
    let after = info.validation_loss.unwrap();
    assert_eq!(after, validation_loss(&net, &mut unseen).unwrap());
    assert!(after < 0.08 * before, "{before} before, {after} after");

    // The same figure from the lean forward pass, in raw units.
    let (mut x, mut y) = (vec![0.0; 900], vec![0.0; 600]);
    let rows: Vec<usize> = (0..300).collect();
    unseen.fill(&rows, &mut x, &mut y).unwrap();
    let mut out = vec![0.0; 600];
    net.forward_batch(&x, &mut Scratch::default(), &mut out).unwrap();
    let square = |(p, y): (&f32, &f32)| f64::from((p - y) / 100.0).powi(2);
    let lean = (out.iter().zip(&y).map(square).sum::<f64>() / 600.0).sqrt();
    assert!((lean / after - 1.0).abs() < 1e-3, "{lean} against {after}");
}

#[test]
fn a_relu_net_learns_a_function_it_has_not_seen() {
    check_learns(Activation::Relu);
}

#[test]
fn a_tanh_net_learns_a_function_it_has_not_seen() {
    check_learns(Activation::Tanh);
}

#[test]
fn the_same_seed_gives_the_same_weights_and_another_does_not() {
    let trained = |seed| {
        let mut net = net(&[16], Activation::Tanh);
        run(&mut net, &TrainParams { seed, ..PARAMS });
        net
    };
    assert_eq!(trained(9), trained(9));
    assert_ne!(trained(9), trained(10));
}

#[test]
fn the_penalty_makes_weights_smaller() {
    let size = |l2| {
        let mut net = net(&[16], Activation::Tanh);
        run(&mut net, &TrainParams { steps: 500, l2, ..PARAMS });
        let weights = net.mlp().layers().iter().flat_map(|l| &l.weights);
        weights.map(|w| w * w).sum::<f32>()
    };
    let (without, with) = (size(0.0), size(0.1));
    assert!(with < 0.5 * without, "{with} against {without}");
}

#[test]
fn progress_tells_every_step_and_the_validation_as_it_comes() {
    let params = TrainParams { validate_every: 8, ..PARAMS };
    let mut seen = vec![];
    let mut note = |p: &Progress| {
        seen.push(*p);
        ControlFlow::Continue(())
    };
    let mut net = net(&[16], Activation::Tanh);
    let (mut source, mut unseen) = (samples(500, 0.0), samples(50, 1.0));
    train(&mut net, &mut source, Some(&mut unseen), &params, None, &mut note).unwrap();
    assert!(seen.iter().map(|p| p.step).eq(1..=20));
    let first = seen.iter().find(|p| p.validation_loss.is_some());
    assert_eq!(first.map(|p| p.step), Some(8));
    assert!(seen.iter().all(|p| p.samples_per_s > 0.0 && p.train_loss > 0.0));
    assert!(seen.is_sorted_by(|a, b| a.learning_rate > b.learning_rate));
}

/// A source that fails or hands out a NaN.
struct Broken(Option<SourceError>);

impl BatchSource for Broken {
    fn n_samples(&self) -> usize {
        5
    }

    fn n_inputs(&self) -> usize {
        3
    }

    fn n_outputs(&self) -> usize {
        2
    }

    fn fill(&mut self, _: &[usize], x: &mut [f32], y: &mut [f32]) -> Result<(), SourceError> {
        x.fill(0.0);
        y.fill(0.0);
        y[3] = f32::NAN;
        self.0.take().map_or(Ok(()), Err)
    }
}

#[test]
fn failures_say_where_and_leave_the_net_alone() {
    let mut net = net(&[16], Activation::Relu);
    let error = refused(&mut net, &mut Broken(Some("disk on fire".into())), &PARAMS);
    assert!(matches!(error, NetsError::Samples { step: 0, .. }), "{error}");
    let error = refused(&mut net, &mut Broken(None), &PARAMS);
    assert!(
        matches!(error, NetsError::SampleNotFinite { what: "output", column: 1, .. }),
        "{error}"
    );
    let mut narrow = MemorySource::new(1, 2, vec![0.0], vec![0.0; 2]).unwrap();
    let error = refused(&mut net, &mut narrow, &PARAMS);
    assert!(matches!(error, NetsError::SampleWidths { got_inputs: 1, .. }), "{error}");
    let mut empty = MemorySource::new(3, 2, vec![], vec![]).unwrap();
    let error = refused(&mut net, &mut empty, &PARAMS);
    assert!(matches!(error, NetsError::NoSamples { role: "training" }), "{error}");
    let wild = TrainParams { learning_rate: 1e30, final_learning_rate: None, ..PARAMS };
    let error = refused(&mut net, &mut samples(500, 0.0), &wild);
    assert!(matches!(error, NetsError::Diverged { step: 1.., .. }), "{error}");
}

#[test]
fn a_training_that_learns_nothing_is_refused() {
    let refused_at = |learning_rate: f64, steps: u64| {
        let params = TrainParams { steps, learning_rate, final_learning_rate: None, ..PARAMS };
        let mut net = net(&[16, 16], Activation::Relu);
        match refused(&mut net, &mut samples(500, 0.0), &params) {
            NetsError::NothingLearned { after, of_means, .. } => (after, of_means),
            other => panic!("{other}"),
        }
    };
    // too fast, and so slow that it hardly moves
    for rate in [30.0, 1e6, 1e-9] {
        let (after, of_means) = refused_at(rate, 300);
        assert!(after >= 0.999 * of_means && of_means > 0.1, "{after} {of_means}");
    }
    // outputs that never vary leave nothing to learn
    let scale = |n: usize, std: f32| Scale::new(vec![10.0; n], vec![std; n]).unwrap();
    let mlp = net(&[16], Activation::Relu).mlp().clone();
    let mut constant = Net::new(mlp, scale(3, 2.0), scale(2, 0.0)).unwrap();
    let params = TrainParams { steps: 150, ..PARAMS };
    run(&mut constant, &params);
    let mut out = [0.0; 2];
    let x = [1.0, 2.0, 3.0];
    constant.forward(&x, &mut Scratch::default(), &mut out).unwrap();
    assert_eq!(out, [10.0; 2]);
}

/// The next test runs this one with a set number of threads and compares the hash it prints.
#[test]
fn trained_weights_are_finite_and_moved() {
    let spec =
        MlpSpec { inputs: 64, hidden: vec![300, 500], outputs: 700, activation: Activation::Relu };
    let start = Mlp::random(&spec, 1).unwrap();
    let mut net = Net::new(start.clone(), Scale::identity(64), Scale::identity(700)).unwrap();
    let wave = |n: usize| (0..n).map(|i| (0.37 * (i * i % 7919) as f32).sin()).collect();
    let mut source = MemorySource::new(64, 700, wave(200 * 64), wave(200 * 700)).unwrap();
    let params = TrainParams { steps: 6, batch: 100, ..PARAMS };
    train(&mut net, &mut source, None, &params, None, &mut go_on).unwrap();
    assert_ne!(net.mlp(), &start);
    println!("weights: {:016x}", hash(net.mlp()));
}

/// FNV-1a over the bits of all weights and biases, which must be finite.
fn hash(mlp: &Mlp) -> u64 {
    let all_finite = |l: &Layer| l.weights.iter().chain(&l.bias).all(|v| v.is_finite());
    assert!(mlp.layers().iter().all(all_finite));
    let layers = mlp.layers().iter();
    let values = layers.flat_map(|l| l.weights.iter().chain(&l.bias));
    values.fold(0xcbf2_9ce4_8422_2325u64, |hash, v| {
        (hash ^ u64::from(v.to_bits())).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let weights = |threads: &str| {
        let output = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "training::trained_weights_are_finite_and_moved", "--nocapture"])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let line = text.lines().find_map(|l| l.split_once("weights: "));
        line.map(|(_, hash)| hash.trim().to_owned()).expect("the child prints its hash")
    };
    let one = weights("1");
    assert_eq!(one, weights("2"));
    assert_eq!(one, weights("3"));
}
