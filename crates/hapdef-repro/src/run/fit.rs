//! Nets that only the report needs, each trained in a stage of its own and resumable.

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::Result;
use hapdef::stages::{fit_scales, train_in_modes};
use hapdef::{OutputScale, Profile, Run, Schedule, Stage};
use hapdef_nets::train::{BatchSource, Progress, TrainInfo, resume, train};
use hapdef_nets::{Mlp, MlpSpec, Net, Scale, TrainParams, load};
use serde_json::{Value, json};

use super::kept::kept;

const CHECKPOINT_FILE: &str = "net.json";
const VERSION: u32 = 2;

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

/// What a net's outputs are while it is trained.
#[derive(Clone, Copy, serde::Serialize)]
pub(crate) struct Outputs {
    /// By what the centred outputs are divided.
    pub(crate) scale: OutputScale,
    /// Into how many modes they go, to be unfolded after; 0: none, or as many as there are outputs.
    pub(crate) modes: usize,
}

impl Outputs {
    /// All of them, divided by this.
    pub(crate) fn scaled_by(scale: OutputScale) -> Self {
        Self { scale, modes: 0 }
    }

    /// As the profile trains F_R.
    pub(crate) fn reconstruction(profile: &Profile) -> Self {
        Self { scale: profile.output_scale, modes: profile.output_modes }
    }
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
        Self { steps: schedule.steps, learning_rate: schedule.learning_rate }
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
    let outputs = Outputs::scaled_by(OutputScale::Each);
    fit_outputs(run, name, of, (brief, outputs), spec, open)
}

/// The same with a choice of what the outputs are in training.
pub(crate) fn fit_outputs<S: BatchSource>(
    run: &Run,
    name: &str,
    of: &Value,
    (brief, outputs): (Brief, Outputs),
    spec: impl FnOnce(usize, usize) -> MlpSpec,
    open: impl FnOnce() -> Result<S>,
) -> Result<(Net, Stage)> {
    let seed = run.scene.seed;
    let inputs = json!({
        "version": VERSION, "net": name, "of": of, "brief": brief, "outputs": outputs, "seed": seed,
    });
    let (_, stage) = kept(run, "brief-net", &inputs, |dir| {
        run.say(&format!("training {name} briefly: {} steps", brief.steps));
        let train_loss = Fitting { run, dir, brief }.run(outputs, spec, &mut open()?)?;
        Ok(json!({ "net": name, "train_loss": train_loss }))
    })?;
    Ok((load(&stage.dir.join(CHECKPOINT_FILE))?.0, stage))
}

/// The training of one net.
struct Fitting<'a> {
    run: &'a Run,
    dir: &'a Path,
    brief: Brief,
}

impl Fitting<'_> {
    /// From the start or from the checkpoint to the last step; the loss of the last batch.
    fn run(
        &self,
        outputs: Outputs,
        spec: impl FnOnce(usize, usize) -> MlpSpec,
        samples: &mut dyn BatchSource,
    ) -> Result<Option<f64>> {
        let [input, output] = fit_scales(samples, outputs.scale)?;
        let (rank, net_file) = (outputs.modes, self.dir.join(CHECKPOINT_FILE));
        if rank == 0 || rank >= samples.n_outputs() {
            return Ok(self.steps(&net_file, [input, output], spec, samples)?.0.train_loss);
        }
        let (info, _) = train_in_modes(
            self.dir,
            rank,
            [input, output],
            samples,
            |checkpoint, scales, _, samples| self.steps(checkpoint, scales, spec, samples),
        )?;
        Ok(info.train_loss)
    }

    fn steps(
        &self,
        checkpoint: &Path,
        [input, output]: [Scale; 2],
        spec: impl FnOnce(usize, usize) -> MlpSpec,
        samples: &mut dyn BatchSource,
    ) -> Result<(TrainInfo, Net)> {
        let (run, brief) = (self.run, self.brief);
        let params = TrainParams {
            steps: brief.steps as u64,
            batch: BATCH,
            learning_rate: brief.learning_rate,
            final_learning_rate: Some(brief.learning_rate * 1e-2),
            checkpoint_every: CHECKPOINT_EVERY,
            ..TrainParams::paper(run.scene.seed)
        };
        let mut watch = |_: &Progress| match run.stopping() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let (net, info) = if checkpoint.exists() {
            resume(checkpoint, samples, None, &params, &mut watch)?
        } else {
            let spec = spec(samples.n_inputs(), samples.n_outputs());
            let mut net = Net::new(Mlp::random(&spec, run.scene.seed)?, input, output)?;
            let path = Some(checkpoint);
            let info = train(&mut net, samples, None, &params, path, &mut watch)?;
            (net, info)
        };
        if info.stopped_early {
            run.check_stop("a brief training")?;
        }
        Ok((info, net))
    }
}
