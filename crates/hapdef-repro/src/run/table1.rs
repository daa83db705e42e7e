//! Table 1: three methods, four unions of training sets, four test sets.

use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::stages::NetKind;
use hapdef::{MapError, MapErrorSum, Pipeline, Run, Stage};
use serde_json::json;

use super::dataset::{Dataset, Rows, blocks};
use super::kept::kept;
use crate::baselines::{LinearAccumulator, LinearParams, OwnRow};
use crate::search::{Fitted, Learner};
use crate::tables::{MapMetric, Method, Table1, TrainSet, TrainedMethod};

const VERSION: u32 = 3;

/// Samples read, predicted and scored together.
const BLOCK: usize = 512;

/// Most samples a training error is taken over.
const MAX_TRAINING: usize = 2000;

/// Fills Table 1 by each of [`MapMetric::ALL`], or reads it from the cache.
pub(crate) fn table1(run: &Run, done: &Pipeline) -> Result<(Vec<Table1>, Stage)> {
    let inputs = json!({ "version": VERSION, "keys": super::keys_of(run, done) });
    let (trained, stage): (Vec<TrainedMethod>, Stage) = kept(run, "table1", &inputs, |_| {
        run.say("Table 1: baselines and nets on every test set");
        fill(run, done)
    })?;
    Ok((MapMetric::ALL.map(|metric| Table1::of(&trained, metric)).to_vec(), stage))
}

fn fill(run: &Run, done: &Pipeline) -> Result<Vec<TrainedMethod>> {
    let data = done.data.as_ref().context("no datasets")?;
    let nets = done.nets.as_ref().context("no nets")?;
    let mut sets = Dataset::open_all(data)?;
    let mut linear = LinearAccumulator::new(sets[0].n_virtual, sets[0].n_surface);
    let mut all = Vec::new();
    for n_sets in 1..=sets.len() {
        run.say(&format!("  trained on {}", TrainSet::ALL[n_sets - 1].name()));
        add_training(&mut linear, &mut sets[n_sets - 1])?;
        let (regression, _) = linear.solve(&LinearParams::default())?;
        let net = nets.load(NetKind::Reconstruction { n_sets })?;
        let knn = Learner::Knn { k: 6 };
        let knn = knn.fit(&Rows::training(&mut sets[..n_sets])?.samples(), &|| false)?;
        for (method, fitted) in [
            (Method::Linear, Fitted::Linear(regression)),
            (Method::Knn, knn),
            (Method::Fnn, Fitted::Net(Box::new(net))),
        ] {
            run.check_stop("Table 1")?;
            let test = sets.iter_mut().map(|set| test_error(&fitted, set));
            let test: Vec<MapError> = test.collect::<Result<_>>()?;
            let training = training_error(&fitted, &mut sets[..n_sets])?;
            all.push(TrainedMethod { method, n_sets, test, training });
        }
    }
    Ok(all)
}

/// Adds a set's training samples to the sums of linear regression.
pub(super) fn add_training(linear: &mut LinearAccumulator, set: &mut Dataset) -> Result<()> {
    for rows in blocks(set.split()?.train, BLOCK) {
        let x = set.inputs(rows.clone())?;
        linear.add_block(&x, &set.maps(rows)?)?;
    }
    Ok(())
}

/// Error on a set's test samples.
pub(super) fn test_error(fitted: &Fitted, set: &mut Dataset) -> Result<MapError> {
    let test = set.split()?.test;
    error_on(fitted, set, test)
}

/// Error on some rows of a set that it was not trained on.
pub(super) fn error_on(fitted: &Fitted, set: &mut Dataset, rows: Range<usize>) -> Result<MapError> {
    let mut sum = MapErrorSum::new(set.n_surface);
    add_error(fitted, set, rows, None, &mut sum)?;
    Ok(sum.finish())
}

/// Error on the union's own training samples, each set by its share.
fn training_error(fitted: &Fitted, sets: &mut [Dataset]) -> Result<MapError> {
    let n_of = |set: &Dataset| Ok(set.split()?.train.len());
    let n_training: Vec<usize> = sets.iter().map(n_of).collect::<Result<_>>()?;
    let share = (MAX_TRAINING as f64 / n_training.iter().sum::<usize>() as f64).min(1.0);
    let mut sum = MapErrorSum::new(sets[0].n_surface);
    let mut first = 0;
    for (set, n_of_set) in sets.iter_mut().zip(n_training) {
        let n = (n_of_set as f64 * share).round() as usize;
        add_error(fitted, set, 0..n, Some(first), &mut sum)?;
        first += n_of_set;
    }
    Ok(sum.finish())
}

/// Adds the errors on `rows`; `own` is the training sample that the first of the set is, if it is one.
fn add_error(
    fitted: &Fitted,
    set: &mut Dataset,
    rows: Range<usize>,
    own: Option<usize>,
    sum: &mut MapErrorSum,
) -> Result<()> {
    for rows in blocks(rows, BLOCK) {
        let x = set.inputs(rows.clone())?;
        let truth = set.maps(rows.clone())?;
        let mut found = vec![0.0; truth.len()];
        let own = own.map_or(OwnRow::None, |own| OwnRow::Exclude { first: own + rows.start });
        fitted.predict_own(&x, own, &mut found)?;
        sum.add(&truth, &found);
    }
    Ok(())
}
