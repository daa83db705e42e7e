//! HapDef 2018's support-vector regression on the rig's single presses.

use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::stages::samples_path;
use hapdef::{ContactPair, ContactStats, HapdefError, Pipeline, Run, Stage};
use hapdef_data::{DatasetReader, Split};
use hapdef_repro::{Svr, SvrParams};
use serde::{Deserialize, Serialize};

const VERSION: u32 = 3;

/// How the support-vector baseline did.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct SvrScore {
    /// Errors on the rig's test presses.
    pub(crate) stats: ContactStats,
    /// Presses it was trained on.
    pub(crate) n_trained: usize,
    /// Presses there were.
    pub(crate) n_offered: usize,
    /// Position, m, and force, N, it finds for each test press.
    pub(crate) found: Vec<[f32; 4]>,
}

/// Trains and scores it, or reads it from the cache.
pub(crate) fn svr(run: &Run, done: &Pipeline) -> Result<(SvrScore, Stage)> {
    let data = done.data.as_ref().context("no datasets")?;
    let params =
        SvrParams { max_samples: run.profile.n_svr, seed: run.scene.seed, ..SvrParams::default() };
    let inputs = serde_json::json!({
        "version": VERSION, "data": data.rig_single.key, "params": params,
    });
    let stage = run.cache.stage("svr", &inputs, |_| {
        run.say(&format!("support-vector baseline on {} presses", params.max_samples));
        let score = train_and_score(&params, &samples_path(&data.rig_single));
        let score = score.and_then(|score| Ok(serde_json::to_value(score)?));
        score.map_err(|error| HapdefError::Stale {
            path: "support-vector baseline".into(),
            what: format!("{error:#}"),
        })
    })?;
    let score = serde_json::from_value(stage.record.info.clone()).context("the svr stage")?;
    Ok((score, stage))
}

fn train_and_score(params: &SvrParams, path: &std::path::Path) -> Result<SvrScore> {
    let mut reader = DatasetReader::open(path)?;
    let split = Split::of(reader.n())?;
    let n_gauges = reader.width("readings")?;
    let (x, y) = rows(&mut reader, split.train)?;
    let (svr, info) = Svr::train(&x, &y, n_gauges, 4, params)?;
    let n_test = split.test.len();
    let (x, truth) = rows(&mut reader, split.test)?;
    let mut found = vec![0.0; truth.len()];
    svr.predict(&x, &mut found)?;
    let pairs = truth.chunks_exact(4).zip(found.chunks_exact(4)).map(|(truth, found)| {
        let offset = (0..3).map(|i| f64::from(found[i] - truth[i]).powi(2)).sum::<f64>();
        ContactPair {
            detected: 0,
            truth: 0,
            position_error_m: offset.sqrt(),
            force_error_n: f64::from(found[3] - truth[3]),
        }
    });
    Ok(SvrScore {
        stats: ContactStats::of(&pairs.collect::<Vec<_>>(), n_test),
        n_trained: info.n_trained,
        n_offered: info.n_offered,
        found: found.as_chunks::<4>().0.to_vec(),
    })
}

/// Readings `[n, n_gauges]` and positions with force `[n, 4]`.
fn rows(reader: &mut DatasetReader, rows: Range<usize>) -> Result<(Vec<f32>, Vec<f32>)> {
    let mut read = |tensor: &str| -> Result<Vec<f32>> {
        let mut values = vec![0.0; rows.len() * reader.width(tensor)?];
        reader.read_rows(tensor, rows.clone(), &mut values)?;
        Ok(values)
    };
    let (readings, positions, forces) =
        (read("readings")?, read("contact_positions")?, read("contact_forces")?);
    let targets = positions.chunks_exact(3).zip(&forces).flat_map(|(p, f)| [p[0], p[1], p[2], *f]);
    Ok((readings, targets.collect()))
}
