//! Nets that only the report needs, each trained in a stage of its own and resumable.

use std::ops::ControlFlow;

use anyhow::Result;
use hapdef::stages::fit_scales;
use hapdef::{HapdefError, OutputScale, Profile, Run, Schedule, Stage};
use hapdef_nets::train::{BatchSource, Progress, resume, train};
use hapdef_nets::{Mlp, MlpSpec, Net, TrainParams, load};
use serde_json::{Value, json};

const CHECKPOINT_FILE: &str = "net.json";
const VERSION: u32 = 1;

/// Samples of a step.
const BATCH: usize = 100;

/// Steps between checkpoints.
const CHECKPOINT_EVERY: u64 = 250;

/// A short training: how many steps, from which learning rate.
#[derive(Clone, Copy, serde::Serialize)]
pub(crate) struct Brief {
    /// Steps.
    pub(crate) steps: usize,
    /// Learning rate at the first step; it falls to a hundredth along a cosine.
    pub(crate) learning_rate: f64,
}

impl Brief {
    /// Half the profile's steps of F_R, at most 1,500.
    pub(crate) fn reconstruction(profile: &Profile) -> Self {
        Self {
            steps: (profile.reconstruction.steps / 2).clamp(1, 1500),
            learning_rate: profile.reconstruction.learning_rate,
        }
    }

    /// As long as the profile trains such a net.
    pub(crate) fn whole(schedule: &Schedule) -> Self {
        Self {
            steps: schedule.steps,
            learning_rate: schedule.learning_rate,
        }
    }

    /// Half the profile's steps of F_T, at most 2,500.
    pub(crate) fn transfer(profile: &Profile) -> Self {
        Self {
            steps: (profile.transfer.steps / 2).clamp(1, 2500),
            learning_rate: profile.transfer.learning_rate,
        }
    }
}

/// Trains a net on the samples that `open` gives, or reads it from the cache. `of` says in the
/// cache's key what the samples are.
pub(crate) fn fit<S: BatchSource>(
    run: &Run,
    name: &str,
    of: &Value,
    brief: Brief,
    spec: impl FnOnce(usize, usize) -> MlpSpec,
    open: impl FnOnce() -> Result<S>,
) -> Result<(Net, Stage)> {
    fit_scaled(run, name, of, (brief, OutputScale::Each), spec, open)
}

/// The same with a choice of the outputs' scale, which `of` should say.
pub(crate) fn fit_scaled<S: BatchSource>(
    run: &Run,
    name: &str,
    of: &Value,
    (brief, scale): (Brief, OutputScale),
    spec: impl FnOnce(usize, usize) -> MlpSpec,
    open: impl FnOnce() -> Result<S>,
) -> Result<(Net, Stage)> {
    let seed = run.scene.seed;
    let inputs = json!({ "version": VERSION, "net": name, "of": of, "brief": brief, "seed": seed });
    let stage = run.cache.stage("brief-net", &inputs, |dir| {
        run.say(&format!("training {name} briefly: {} steps", brief.steps));
        let fitted = open()
            .and_then(|samples| steps(run, dir, (brief, scale), spec, samples))
            .map_err(|error| match error.downcast::<HapdefError>() {
                Ok(error) => error,
                Err(error) => HapdefError::Stale {
                    path: name.into(),
                    what: format!("{error:#}"),
                },
            })?;
        Ok(json!({ "net": name, "train_loss": fitted }))
    })?;
    Ok((load(&stage.dir.join(CHECKPOINT_FILE))?.0, stage))
}

/// From the start or from the checkpoint to the last step; the loss of the last batch.
fn steps(
    run: &Run,
    dir: &std::path::Path,
    (brief, scale): (Brief, OutputScale),
    spec: impl FnOnce(usize, usize) -> MlpSpec,
    mut samples: impl BatchSource,
) -> Result<Option<f64>> {
    let params = TrainParams {
        steps: brief.steps as u64,
        batch: BATCH,
        learning_rate: brief.learning_rate,
        final_learning_rate: Some(brief.learning_rate * 1e-2),
        checkpoint_every: CHECKPOINT_EVERY,
        ..TrainParams::paper(run.scene.seed)
    };
    let checkpoint = dir.join(CHECKPOINT_FILE);
    let mut watch = |_: &Progress| match run.stopping() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let info = if checkpoint.exists() {
        resume(&checkpoint, &mut samples, None, &params, &mut watch)?.1
    } else {
        let [input, output] = fit_scales(&mut samples, scale)?;
        let spec = spec(samples.n_inputs(), samples.n_outputs());
        let mut net = Net::new(Mlp::random(&spec, run.scene.seed)?, input, output)?;
        train(
            &mut net,
            &mut samples,
            None,
            &params,
            Some(&checkpoint),
            &mut watch,
        )?
    };
    if info.stopped_early {
        run.check_stop("a brief training")?;
    }
    Ok(info.train_loss)
}
