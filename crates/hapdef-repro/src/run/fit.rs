//! Nets that only the report needs, each trained in a stage of its own and resumable.

use anyhow::Result;
use hapdef::stages;
use hapdef::{OutputScale, Run, Schedule, Stage};
use hapdef_nets::train::BatchSource;
use hapdef_nets::{MlpSpec, Net, TrainParams, load};
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
    spec: impl Fn(usize, usize) -> MlpSpec,
    open: impl FnOnce() -> Result<S>,
) -> Result<(Net, Stage)> {
    let inputs = json!({ "version": VERSION, "net": name, "of": of, "training": training });
    let (_, stage) = kept(run, "brief-net", &inputs, |dir| {
        run.say(&format!("training {name}: {} steps", training.params.steps));
        let of_net = stages::Training {
            run,
            name,
            spec: &spec,
            params: &training.params,
            dir,
            output_modes: training.modes,
            output_scale: training.scale,
        };
        let (info, _) = of_net.run(&mut open()?, None, None)?;
        if info.stopped_early {
            run.check_stop("a brief training")?;
        }
        Ok(json!({ "net": name, "train_loss": info.train_loss }))
    })?;
    Ok((load(&stage.dir.join(CHECKPOINT_FILE))?.0, stage))
}
