//! HapDef 2018's support-vector regression on the rig's single presses.

use anyhow::{Context, Result};
use hapdef::{ContactPair, ContactStats, Pipeline, Run, Stage};
use serde::{Deserialize, Serialize};

use super::dataset::{Part, Rows, pair, rig_singles};
use super::kept::kept;
use crate::baselines::SvrParams;
use crate::search::{Fitted, Learner};

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
    kept(run, "svr", &inputs, |_| {
        run.say(&format!("support-vector baseline on {} presses", params.max_samples));
        train_and_score(params, done)
    })
}

fn train_and_score(params: SvrParams, done: &Pipeline) -> Result<SvrScore> {
    let (mut presses, split) = rig_singles(done)?;
    let training = Rows::of(&mut presses, [Part::Readings, Part::Contact], split.train)?;
    let fitted = Learner::Svr(params).fit(&training.samples(), &|| false)?;
    let truth = presses.contacts(split.test.clone())?;
    let found = fitted.predictions(&presses.readings(split.test)?, truth.len())?;
    let found = found.as_chunks::<4>().0.to_vec();
    let pairs: Vec<ContactPair> = truth.iter().zip(&found).map(|(t, f)| pair(t, f)).collect();
    Ok(SvrScore {
        stats: ContactStats::of(&pairs, truth.len()),
        n_trained: match fitted {
            Fitted::Svr(_, n_trained) => n_trained,
            _ => training.n,
        },
        n_offered: training.n,
        found,
    })
}
