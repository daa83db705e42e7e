//! Stage: the networks, each trained on its own and resumable.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use hapdef_nets::train::{BatchSource, Progress, TrainInfo, resume, train as train_net};
use hapdef_nets::{Mlp, Net, TrainParams, load};
use serde_json::{Value, json};

use super::dataset::Datasets;
use super::nets::{NetKind, fit_scales};
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::profile::Schedule;
use crate::run::Run;

const CHECKPOINT_FILE: &str = "net.json";
const VERSION: u32 = 1;

/// Samples of a batch; the paper's.
const BATCH: usize = 100;

/// Steps between checkpoints.
const CHECKPOINT_EVERY: u64 = 1000;

/// Looks at the validation set during a training.
const N_VALIDATIONS: u64 = 20;

/// A trained net's stage.
#[derive(Clone, Debug)]
pub struct TrainedNet {
    /// Which net.
    pub kind: NetKind,
    /// Its stage.
    pub stage: Stage,
}

/// All trained nets of a scene.
#[derive(Clone, Debug)]
pub struct TrainedNets {
    /// The nets in the order in which they were trained.
    pub nets: Vec<TrainedNet>,
}

impl TrainedNet {
    /// Path of the checkpoint.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        self.stage.dir.join(CHECKPOINT_FILE)
    }
}

impl TrainedNets {
    /// Reads a net.
    ///
    /// # Errors
    /// [`HapdefError::Net`] when its checkpoint is damaged, [`HapdefError::Stale`] when the net was
    /// not trained.
    pub fn load(&self, kind: NetKind) -> Result<Net, HapdefError> {
        let trained = self
            .nets
            .iter()
            .find(|net| net.kind == kind)
            .ok_or_else(|| HapdefError::Stale {
                path: kind.name().into(),
                what: "the net is not trained".into(),
            })?;
        Ok(load(&trained.path())?.0)
    }
}

/// Trains every net: F_R on each union of sets of Table 1, then F_T, F_S and the direct net.
///
/// # Errors
/// [`HapdefError::Stopped`] when the person stopped it (a checkpoint is kept),
/// [`HapdefError::Net`] when a loss is no number.
pub fn train(run: &Run, data: &Datasets) -> Result<TrainedNets, HapdefError> {
    let unions = (1..=data.simulated.len()).map(|n_sets| NetKind::Reconstruction { n_sets });
    let others = [NetKind::Transfer, NetKind::Sensitivity, NetKind::Direct];
    let nets = unions.chain(others).map(|kind| {
        let stage = train_one(run, data, kind)?;
        Ok(TrainedNet { kind, stage })
    });
    Ok(TrainedNets {
        nets: nets.collect::<Result<_, HapdefError>>()?,
    })
}

fn train_one(run: &Run, data: &Datasets, kind: NetKind) -> Result<Stage, HapdefError> {
    let params = params(run, kind);
    let keys: Vec<&str> = kind
        .datasets(data)
        .iter()
        .map(|stage| stage.key.as_str())
        .collect();
    let inputs = json!({
        "version": VERSION, "kind": kind, "datasets": keys, "params": params,
    });
    run.cache.stage("net", &inputs, |dir| {
        let checkpoint = dir.join(CHECKPOINT_FILE);
        let [mut samples, mut validation] = kind.samples(data)?;
        run.say(&format!(
            "training {}: {} samples, {} steps of {BATCH}",
            kind.name(),
            samples.n_samples(),
            params.steps
        ));
        let bar = run.progress.training(&kind.name(), params.steps);
        let mut history = History::default();
        let mut on_progress = |progress: &Progress| {
            history.note(progress);
            let validation = progress.validation_loss.unwrap_or(f64::NAN);
            bar.set(
                progress.step,
                format!(
                    "loss {:.4} val {validation:.4}  {:.0}/s",
                    progress.train_loss, progress.samples_per_s
                ),
            );
            if run.stopping() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let [samples, validation] = [samples.as_mut(), validation.as_mut()];
        let info = fit(
            kind,
            samples,
            validation,
            &params,
            &checkpoint,
            &mut on_progress,
        )?;
        if info.stopped_early {
            return Err(HapdefError::Stopped {
                stage: format!("training {}", kind.name()),
            });
        }
        Ok(record(kind, samples.n_samples(), &info, &history))
    })
}

/// Trains a net from the start, or goes on from its checkpoint.
fn fit(
    kind: NetKind,
    samples: &mut dyn BatchSource,
    validation: &mut dyn BatchSource,
    params: &TrainParams,
    checkpoint: &Path,
    on_progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<TrainInfo, HapdefError> {
    let validation = Some(validation);
    if checkpoint.exists() {
        return Ok(resume(checkpoint, samples, validation, params, on_progress)?.1);
    }
    let [input, output] = fit_scales(samples)?;
    let spec = kind.spec(samples.n_inputs(), samples.n_outputs());
    let mut net = Net::new(Mlp::random(&spec, params.seed)?, input, output)?;
    Ok(train_net(
        &mut net,
        samples,
        validation,
        params,
        Some(checkpoint),
        on_progress,
    )?)
}

fn params(run: &Run, kind: NetKind) -> TrainParams {
    let profile = &run.profile;
    let (schedule, stream) = match kind {
        NetKind::Transfer => (profile.transfer, 1),
        NetKind::Sensitivity => (profile.sensitivity, 2),
        NetKind::Direct => (profile.direct, 3),
        NetKind::Reconstruction { n_sets } => (profile.reconstruction, 10 + n_sets as u64),
    };
    let Schedule {
        steps,
        learning_rate,
        final_learning_rate,
        l2,
    } = schedule;
    TrainParams {
        steps: steps as u64,
        batch: BATCH,
        learning_rate,
        final_learning_rate: Some(final_learning_rate),
        l2,
        seed: run.scene.seed.wrapping_mul(1000).wrapping_add(stream),
        checkpoint_every: CHECKPOINT_EVERY,
        validate_every: (steps as u64 / N_VALIDATIONS).max(1),
    }
}

/// Losses over a training, for the report's curves.
#[derive(Default)]
struct History {
    steps: Vec<u64>,
    train: Vec<f64>,
    validation: Vec<f64>,
    last_validation: Option<f64>,
}

impl History {
    /// Keeps a point whenever the validation set was looked at.
    fn note(&mut self, progress: &Progress) {
        if let Some(validation) = progress.validation_loss
            && self
                .last_validation
                .is_none_or(|last| last.total_cmp(&validation).is_ne())
        {
            self.steps.push(progress.step);
            self.train.push(progress.train_loss);
            self.validation.push(validation);
            self.last_validation = Some(validation);
        }
    }
}

fn record(kind: NetKind, n_samples: usize, info: &TrainInfo, history: &History) -> Value {
    json!({
        "net": kind.name(),
        "n_samples": n_samples,
        "steps": info.step,
        "train_loss": info.train_loss,
        "validation_loss": info.validation_loss,
        "samples_per_s": info.samples_per_s,
        "history": {
            "step": history.steps,
            "train_loss": history.train,
            "validation_loss": history.validation,
        },
    })
}
