//! Training with checkpoints: breaks, the best weights, early stopping, endless samples.

use crate::training_common;

use std::ops::ControlFlow;
use std::path::PathBuf;

use hapdef_nets::train::{
    BatchSource, Progress, SourceError, TrainInfo, resume, train, validation_loss,
};
use hapdef_nets::{Activation, Loss, Net, NetsError, TrainParams, load};
use training_common::{PARAMS, go_on, net, run, samples};

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
    let info = train(&mut first, &mut source, None, &PARAMS, Some(&path), &mut stop_at_10).unwrap();
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
    let params = TrainParams { checkpoint_every: 7, ..PARAMS };
    let mut crash_at_16 = |p: &Progress| {
        assert!(p.step < 16, "as if the power failed");
        ControlFlow::Continue(())
    };
    let crashed = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        let mut net = net(&[16], Activation::Tanh);
        train(&mut net, &mut samples(500, 0.0), None, &params, Some(&path), &mut crash_at_16)
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
    assert_eq!(load(&path).unwrap().0, net, "the checkpoint's net is the kept one");
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
    let params = TrainParams { patience: 3, ..OVERFITS };
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
    train(&mut net, &mut source, None, &PARAMS, Some(&path), &mut stop_at_7).unwrap();
    resume(&path, &mut source, None, &PARAMS, &mut go_on).unwrap();
    assert!(source.0.into_iter().eq(0..20 * 32));
}

#[test]
fn a_resume_with_other_knobs_is_refused() {
    let (_folder, path) = checkpoint();
    let mut net = net(&[16], Activation::Tanh);
    let mut source = samples(500, 0.0);
    train(&mut net, &mut source, None, &PARAMS, Some(&path), &mut go_on).unwrap();
    let mut name_refused =
        |params: TrainParams| match resume(&path, &mut source, None, &params, &mut go_on) {
            Err(NetsError::ResumeParams { name, .. }) => name,
            other => panic!("{other:?}"),
        };
    assert_eq!(name_refused(TrainParams { seed: 1, ..PARAMS }), "seed");
    assert_eq!(name_refused(TrainParams { batch: 1, ..PARAMS }), "batch");
    assert_eq!(name_refused(TrainParams { l2: 0.0, ..PARAMS }), "l2");
    let loss = Loss::MeanOfSamples;
    assert_eq!(name_refused(TrainParams { loss, ..PARAMS }), "loss");
    assert_eq!(name_refused(TrainParams { steps: 40, ..PARAMS }), "steps");
}

#[test]
fn a_checkpoint_in_another_precision_is_read_and_not_resumed() {
    let (_folder, path) = checkpoint();
    let mut trained = net(&[16], Activation::Relu);
    train(&mut trained, &mut samples(500, 0.0), None, &PARAMS, Some(&path), &mut go_on).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    for (precision, is_resumed) in [("f32", true), ("mixed", false)] {
        let params = format!("\"params\": {{ \"precision\": \"{precision}\",");
        std::fs::write(&path, text.replacen("\"params\": {", &params, 1)).unwrap();
        assert_eq!(load(&path).unwrap().0, trained);
        let resumed = resume(&path, &mut samples(500, 0.0), None, &PARAMS, &mut go_on);
        match resumed {
            Ok(_) => assert!(is_resumed),
            Err(NetsError::ResumeParams { name, saved, asked, .. }) => {
                assert_eq!((name, saved.as_str(), is_resumed), ("precision", "mixed", false));
                assert!(asked.starts_with("f32"));
            }
            Err(other) => panic!("{other}"),
        }
    }
}
