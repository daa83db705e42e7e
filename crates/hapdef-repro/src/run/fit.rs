//! Nets that only the report needs, each trained in a stage of its own and resumable.

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::Result;
use hapdef::stages::{fit_scales, train_in_modes};
use hapdef::{OutputScale, Run, Schedule, Stage};
use hapdef_nets::train::{BatchSource, Progress, TrainInfo, resume, train};
use hapdef_nets::{Mlp, MlpSpec, Net, Scale, TrainParams, load};
use serde_json::{Value, json};

use super::kept::kept;

const CHECKPOINT_FILE: &str = "net.json";
const VERSION: u32 = 3;

/// Steps between checkpoints.
const CHECKPOINT_EVERY: u64 = 250;

/// How a net that only the report needs is trained.
#[derive(Clone, serde::Serialize)]
pub(crate) struct Training {
    /// Steps, learning rates, seed.
    pub(crate) params: TrainParams,
    /// By what the centred outputs are divided.
    pub(crate) scale: OutputScale,
    /// Into how many modes the outputs go, to be unfolded after; 0: none, or as many as there are outputs.
    pub(crate) modes: usize,
}

impl Training {
    /// So many steps of 100 from a schedule's learning rate, which falls to a hundredth along a cosine.
    fn of(run: &Run, schedule: &Schedule, steps: usize) -> Self {
        let params = TrainParams {
            steps: steps as u64,
            learning_rate: schedule.learning_rate,
            final_learning_rate: Some(schedule.learning_rate * 1e-2),
            checkpoint_every: CHECKPOINT_EVERY,
            ..TrainParams::paper(run.scene.seed)
        };
        Self { params, scale: OutputScale::Each, modes: 0 }
    }

    /// As long as the profile trains such a net.
    pub(crate) fn whole(run: &Run, schedule: &Schedule) -> Self {
        Self::of(run, schedule, schedule.steps)
    }

    /// Half the profile's steps of F_R, at most 1,500.
    pub(crate) fn reconstruction(run: &Run) -> Self {
        let schedule = &run.profile.reconstruction;
        Self::of(run, schedule, (schedule.steps / 2).clamp(1, 1500))
    }

    /// Half the profile's steps of F_T, at most 2,500.
    pub(crate) fn transfer(run: &Run) -> Self {
        let schedule = &run.profile.transfer;
        Self::of(run, schedule, (schedule.steps / 2).clamp(1, 2500))
    }
}

/// Trains a net on the samples that `open` gives, or reads it from the cache. `of` says in the
/// cache's key what the samples are.
pub(crate) fn fit<S: BatchSource>(
    run: &Run,
    name: &str,
    of: &Value,
    training: &Training,
    spec: impl FnOnce(usize, usize) -> MlpSpec,
    open: impl FnOnce() -> Result<S>,
) -> Result<(Net, Stage)> {
    let inputs = json!({ "version": VERSION, "net": name, "of": of, "training": training });
    let (_, stage) = kept(run, "brief-net", &inputs, |dir| {
        run.say(&format!("training {name}: {} steps", training.params.steps));
        let train_loss = train_in(run, dir, training, spec, &mut open()?)?;
        Ok(json!({ "net": name, "train_loss": train_loss }))
    })?;
    Ok((load(&stage.dir.join(CHECKPOINT_FILE))?.0, stage))
}

/// From the start or from the checkpoint to the last step; the loss of the last batch.
fn train_in(
    run: &Run,
    dir: &Path,
    training: &Training,
    spec: impl FnOnce(usize, usize) -> MlpSpec,
    samples: &mut dyn BatchSource,
) -> Result<Option<f64>> {
    let scales = fit_scales(samples, training.scale)?;
    let (rank, params) = (training.modes, &training.params);
    let steps = |checkpoint: &Path, scales, samples: &mut dyn BatchSource| {
        steps(run, checkpoint, params, scales, spec, samples)
    };
    if rank == 0 || rank >= samples.n_outputs() {
        return Ok(steps(&dir.join(CHECKPOINT_FILE), scales, samples)?.0.train_loss);
    }
    let (info, _) =
        train_in_modes(dir, rank, scales, samples, |checkpoint, scales, _, samples| {
            steps(checkpoint, scales, samples)
        })?;
    Ok(info.train_loss)
}

fn steps(
    run: &Run,
    checkpoint: &Path,
    params: &TrainParams,
    [input, output]: [Scale; 2],
    spec: impl FnOnce(usize, usize) -> MlpSpec,
    samples: &mut dyn BatchSource,
) -> Result<(TrainInfo, Net)> {
    let mut watch = |_: &Progress| match run.stopping() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let (net, info) = if checkpoint.exists() {
        resume(checkpoint, samples, None, params, &mut watch)?
    } else {
        let spec = spec(samples.n_inputs(), samples.n_outputs());
        let mut net = Net::new(Mlp::random(&spec, params.seed)?, input, output)?;
        let info = train(&mut net, samples, None, params, Some(checkpoint), &mut watch)?;
        (net, info)
    };
    if info.stopped_early {
        run.check_stop("a brief training")?;
    }
    Ok((info, net))
}
