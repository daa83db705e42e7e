//! Training: that it learns, repeats itself, resumes, stops and says what is wrong.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::Command;

use hapdef_nets::train::{
    BatchSource, MemorySource, Progress, SourceError, TrainInfo, resume, train, validation_loss,
};
use hapdef_nets::{
    Activation, Layer, Mlp, MlpSpec, Net, NetsError, Scale, Scratch, TrainParams, TrainPrecision,
    load,
};

const PARAMS: TrainParams = TrainParams {
    steps: 20,
    batch: 32,
    learning_rate: 1e-3,
    final_learning_rate: Some(1e-5),
    warmup_steps: 0,
    l2: 1e-4,
    precision: TrainPrecision::F32,
    seed: 9,
    checkpoint_every: 0,
    validate_every: 0,
    keep_best: false,
    patience: 0,
};

fn net(hidden: &[usize], activation: Activation) -> Net {
    let spec = MlpSpec {
        inputs: 3,
        hidden: hidden.to_vec(),
        outputs: 2,
        activation,
    };
    let input = Scale::new(vec![10.0; 3], vec![2.0; 3]).unwrap();
    let output = Scale::new(vec![0.0; 2], vec![100.0; 2]).unwrap();
    Net::new(Mlp::random(&spec, 1).unwrap(), input, output).unwrap()
}

/// Two smooth functions of three numbers.
fn samples(n: usize, phase: f32) -> MemorySource {
    let x: Vec<f32> = (0..3 * n)
        .map(|i| 10.0 + 3.0 * (1.618 * (i * i % 9973) as f32 + phase).sin())
        .collect();
    let y = x.chunks(3).flat_map(|p| {
        let [a, b, c] = [p[0] - 10.0, p[1] - 10.0, p[2] - 10.0];
        [20.0 * a * b + 30.0 * c, 100.0 * (0.5 * a - b).sin()]
    });
    let y = y.collect();
    MemorySource::new(3, 2, x, y).unwrap()
}

fn go_on(_: &Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn run(net: &mut Net, params: &TrainParams) -> TrainInfo {
    train(net, &mut samples(500, 0.0), None, params, None, &mut go_on).unwrap()
}

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
    let params = TrainParams {
        steps: 3000,
        learning_rate: 3e-3,
        l2: 0.0,
        ..PARAMS
    };
    let mut source = samples(2000, 0.0);
    let info = train(
        &mut net,
        &mut source,
        Some(&mut unseen),
        &params,
        None,
        &mut go_on,
    )
    .unwrap();
    let after = info.validation_loss.unwrap();
    assert_eq!(after, validation_loss(&net, &mut unseen).unwrap());
    assert!(after < 0.08 * before, "{before} before, {after} after");

    // The same figure from the lean forward pass, in raw units.
    let (mut x, mut y) = (vec![0.0; 900], vec![0.0; 600]);
    let rows: Vec<usize> = (0..300).collect();
    unseen.fill(&rows, &mut x, &mut y).unwrap();
    let mut out = vec![0.0; 600];
    net.forward_batch(&x, &mut Scratch::default(), &mut out)
        .unwrap();
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
        run(
            &mut net,
            &TrainParams {
                steps: 500,
                l2,
                ..PARAMS
            },
        );
        let weights = net.mlp().layers().iter().flat_map(|l| &l.weights);
        weights.map(|w| w * w).sum::<f32>()
    };
    let (without, with) = (size(0.0), size(0.1));
    assert!(with < 0.5 * without, "{with} against {without}");
}

fn checkpoint() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("net.json");
    (folder, path)
}

#[test]
fn a_break_and_a_resume_change_no_bit() {
    let (_folder, path) = checkpoint();
    let mut straight = net(&[16, 12], Activation::Relu);
    let straight_info = run(&mut straight, &PARAMS);

    let mut first = net(&[16, 12], Activation::Relu);
    let mut stop_at_10 = |p: &Progress| match p.step {
        10 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let mut source = samples(500, 0.0);
    let info = train(
        &mut first,
        &mut source,
        None,
        &PARAMS,
        Some(&path),
        &mut stop_at_10,
    )
    .unwrap();
    assert_eq!((info.step, info.stopped_early), (10, true));
    assert_eq!(load(&path).unwrap().0, first);

    let (resumed, info) = resume(&path, &mut source, None, &PARAMS, &mut go_on).unwrap();
    assert_eq!((info.step, info.stopped_early), (20, false));
    assert_eq!(info.train_loss, straight_info.train_loss);
    assert_eq!(resumed, straight);
    assert_eq!(load(&path).unwrap().0, straight);

    let (again, info) = resume(&path, &mut source, None, &PARAMS, &mut go_on).unwrap();
    assert_eq!((again, info.step), (straight, 20), "nothing is left to do");
}

#[test]
fn checkpoints_on_the_way_can_be_resumed() {
    let (_folder, path) = checkpoint();
    let params = TrainParams {
        checkpoint_every: 7,
        ..PARAMS
    };
    let mut crash_at_16 = |p: &Progress| {
        assert!(p.step < 16, "as if the power failed");
        ControlFlow::Continue(())
    };
    let crashed = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        let mut net = net(&[16], Activation::Tanh);
        train(
            &mut net,
            &mut samples(500, 0.0),
            None,
            &params,
            Some(&path),
            &mut crash_at_16,
        )
    }));
    assert!(crashed.is_err());
    assert_eq!(load(&path).unwrap().1.step, 14);
    let (resumed, _) = resume(&path, &mut samples(500, 0.0), None, &params, &mut go_on).unwrap();
    let mut straight = net(&[16], Activation::Tanh);
    run(&mut straight, &params);
    assert_eq!(resumed, straight);
}

/// Few samples and a high rate: the validation loss falls and rises again.
const OVERFITS: TrainParams = TrainParams {
    steps: 400,
    learning_rate: 1e-2,
    final_learning_rate: Some(1e-3),
    warmup_steps: 10,
    l2: 0.0,
    validate_every: 20,
    keep_best: true,
    ..PARAMS
};

/// Trains on 30 samples, stopping at some steps and going on from the checkpoint.
fn overfit(params: &TrainParams, stops: &[u64]) -> (Net, TrainInfo) {
    let (_folder, path) = checkpoint();
    let (mut few, mut unseen) = (samples(30, 0.0), samples(200, 0.5));
    let mut net = net(&[32, 32], Activation::Relu);
    let mut stop = |p: &Progress| match stops.contains(&p.step) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let first = Some(&mut unseen as &mut dyn BatchSource);
    let mut info = train(&mut net, &mut few, first, params, Some(&path), &mut stop).unwrap();
    while info.stopped_early {
        (net, info) = resume(&path, &mut few, Some(&mut unseen), params, &mut stop).unwrap();
    }
    assert_eq!(
        load(&path).unwrap().0,
        net,
        "the checkpoint's net is the kept one"
    );
    let loss = validation_loss(&net, &mut unseen).unwrap();
    assert_eq!(info.validation_loss, Some(loss));
    (net, info)
}

#[test]
fn the_best_weights_are_kept() {
    let (_, info) = overfit(&OVERFITS, &[]);
    let lowest = info.looks.iter().map(|l| l.validation_loss);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    assert_eq!(info.validation_loss, Some(lowest));
    assert!(info.kept_step < 400, "it should have overfitted: {info:?}");
    assert_eq!(info.looks.len(), 20);
}

#[test]
fn training_ends_when_the_validation_loss_no_longer_falls() {
    let params = TrainParams {
        patience: 3,
        ..OVERFITS
    };
    let (net, info) = overfit(&params, &[]);
    assert!(info.out_of_patience && !info.stopped_early);
    assert_eq!(info.step, info.kept_step + 3 * 20);
    let (resumed, again) = overfit(&params, &[30, info.kept_step, info.step]);
    assert_eq!((resumed, again.looks), (net, info.looks));
}

#[test]
fn breaks_change_neither_the_best_weights_nor_the_looks() {
    let (net, info) = overfit(&OVERFITS, &[]);
    let (resumed, again) = overfit(&OVERFITS, &[7, 40, info.kept_step, 333]);
    assert_eq!(resumed, net);
    assert_eq!(again.looks, info.looks);
}

/// An endless source: row n is x = n, y = (n, 2 n).
#[derive(Default)]
struct Counting(Vec<usize>);

impl BatchSource for Counting {
    fn n_samples(&self) -> usize {
        10
    }

    fn is_endless(&self) -> bool {
        true
    }

    fn n_inputs(&self) -> usize {
        3
    }

    fn n_outputs(&self) -> usize {
        2
    }

    fn fill(&mut self, rows: &[usize], x: &mut [f32], y: &mut [f32]) -> Result<(), SourceError> {
        x.fill(10.0);
        y.fill(0.0);
        self.0.extend(rows);
        Ok(())
    }
}

#[test]
fn an_endless_source_gives_every_row_once() {
    let (_folder, path) = checkpoint();
    let mut net = net(&[16], Activation::Relu);
    let mut source = Counting::default();
    let mut stop_at_7 = |p: &Progress| match p.step {
        7 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    train(
        &mut net,
        &mut source,
        None,
        &PARAMS,
        Some(&path),
        &mut stop_at_7,
    )
    .unwrap();
    resume(&path, &mut source, None, &PARAMS, &mut go_on).unwrap();
    assert!(source.0.into_iter().eq(0..20 * 32));
}

#[test]
fn a_resume_with_other_knobs_is_refused() {
    let (_folder, path) = checkpoint();
    let mut net = net(&[16], Activation::Tanh);
    let mut source = samples(500, 0.0);
    train(
        &mut net,
        &mut source,
        None,
        &PARAMS,
        Some(&path),
        &mut go_on,
    )
    .unwrap();
    let mut name_refused =
        |params: TrainParams| match resume(&path, &mut source, None, &params, &mut go_on) {
            Err(NetsError::ResumeParams { name, .. }) => name,
            other => panic!("{other:?}"),
        };
    assert_eq!(name_refused(TrainParams { seed: 1, ..PARAMS }), "seed");
    assert_eq!(name_refused(TrainParams { batch: 1, ..PARAMS }), "batch");
    assert_eq!(name_refused(TrainParams { l2: 0.0, ..PARAMS }), "l2");
    assert_eq!(
        name_refused(TrainParams {
            steps: 40,
            ..PARAMS
        }),
        "steps"
    );
}

#[test]
fn progress_tells_every_step_and_the_validation_as_it_comes() {
    let params = TrainParams {
        validate_every: 8,
        ..PARAMS
    };
    let mut seen = vec![];
    let mut note = |p: &Progress| {
        seen.push(*p);
        ControlFlow::Continue(())
    };
    let mut net = net(&[16], Activation::Tanh);
    let (mut source, mut unseen) = (samples(500, 0.0), samples(50, 1.0));
    train(
        &mut net,
        &mut source,
        Some(&mut unseen),
        &params,
        None,
        &mut note,
    )
    .unwrap();
    assert!(seen.iter().map(|p| p.step).eq(1..=20));
    let first = seen.iter().find(|p| p.validation_loss.is_some());
    assert_eq!(first.map(|p| p.step), Some(8));
    assert!(
        seen.iter()
            .all(|p| p.samples_per_s > 0.0 && p.train_loss > 0.0)
    );
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
    assert!(
        matches!(error, NetsError::Samples { step: 0, .. }),
        "{error}"
    );
    let error = refused(&mut net, &mut Broken(None), &PARAMS);
    assert!(
        matches!(
            error,
            NetsError::SampleNotFinite {
                what: "output",
                column: 1,
                ..
            }
        ),
        "{error}"
    );
    let mut narrow = MemorySource::new(1, 2, vec![0.0], vec![0.0; 2]).unwrap();
    let error = refused(&mut net, &mut narrow, &PARAMS);
    assert!(
        matches!(error, NetsError::SampleWidths { got_inputs: 1, .. }),
        "{error}"
    );
    let mut empty = MemorySource::new(3, 2, vec![], vec![]).unwrap();
    let error = refused(&mut net, &mut empty, &PARAMS);
    assert!(
        matches!(error, NetsError::NoSamples { role: "training" }),
        "{error}"
    );
    let wild = TrainParams {
        learning_rate: 1e30,
        final_learning_rate: None,
        ..PARAMS
    };
    let error = refused(&mut net, &mut samples(500, 0.0), &wild);
    assert!(
        matches!(error, NetsError::Diverged { step: 1.., .. }),
        "{error}"
    );
}

/// The next test runs this one with a set number of threads and compares the hash it prints.
#[test]
fn trained_weights_are_finite_and_moved() {
    let spec = MlpSpec {
        inputs: 64,
        hidden: vec![300, 500],
        outputs: 700,
        activation: Activation::Relu,
    };
    let start = Mlp::random(&spec, 1).unwrap();
    let mut net = Net::new(start.clone(), Scale::identity(64), Scale::identity(700)).unwrap();
    let wave = |n: usize| {
        (0..n)
            .map(|i| (0.37 * (i * i % 7919) as f32).sin())
            .collect()
    };
    let mut source = MemorySource::new(64, 700, wave(200 * 64), wave(200 * 700)).unwrap();
    let params = TrainParams {
        steps: 6,
        batch: 100,
        ..PARAMS
    };
    train(&mut net, &mut source, None, &params, None, &mut go_on).unwrap();
    assert_ne!(net.mlp(), &start);
    let all_finite = |l: &Layer| l.weights.iter().chain(&l.bias).all(|v| v.is_finite());
    assert!(net.mlp().layers().iter().all(all_finite));
    // FNV-1a over the bits of all weights and biases.
    let layers = net.mlp().layers().iter();
    let values = layers.flat_map(|l| l.weights.iter().chain(&l.bias));
    let hash = values.fold(0xcbf2_9ce4_8422_2325u64, |hash, v| {
        (hash ^ u64::from(v.to_bits())).wrapping_mul(0x0100_0000_01b3)
    });
    println!("weights: {hash:016x}");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let weights = |threads: &str| {
        let output = Command::new(std::env::current_exe().unwrap())
            .args([
                "--exact",
                "trained_weights_are_finite_and_moved",
                "--nocapture",
            ])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let line = text.lines().find_map(|l| l.split_once("weights: "));
        line.map(|(_, hash)| hash.trim().to_owned())
            .expect("the child prints its hash")
    };
    let one = weights("1");
    assert_eq!(one, weights("2"));
    assert_eq!(one, weights("3"));
}
