//! The loop of a training.

use std::ops::ControlFlow;
use std::path::Path;

use crate::checkpoint::{Look, Resumable, TrainRecord, load_for_resume, save_all};
use crate::error::NetsError;
use crate::mlp::Mlp;
use crate::net::Net;
use crate::optimiser::Moments;
use crate::params::{Loss, TrainParams};
use crate::train::adam::AdamStep;
use crate::train::batch::Batch;
use crate::train::clock::Clock;
use crate::train::engine::Engine;
use crate::train::learned::check_learned;
use crate::train::loss::LossSum;
use crate::train::network::Network;
use crate::train::same::check_same;
use crate::train::source::BatchSource;

/// How far a training has come, reported after every step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Steps done, those before a resume included.
    pub step: u64,
    /// Steps in all.
    pub steps: u64,
    /// Step size of Adam in the last step.
    pub learning_rate: f64,
    /// Loss of the last batch plus the penalty, standardised outputs.
    pub train_loss: f64,
    /// Loss of the validation set when last looked at, standardised outputs.
    pub validation_loss: Option<f64>,
    /// Samples per second of the last second or so.
    pub samples_per_s: f64,
}

/// How a training ended.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainInfo {
    /// Steps done, those before a resume included.
    pub step: u64,
    /// Whether the caller stopped it before the end.
    pub stopped_early: bool,
    /// Whether it ended before the last step because the validation loss no longer fell.
    pub out_of_patience: bool,
    /// Loss of the last batch plus the penalty, standardised outputs; none if no step was done.
    pub train_loss: Option<f64>,
    /// Loss of the validation set with the net as it is returned, standardised outputs; none
    /// without such a set, or when the caller stopped it.
    pub validation_loss: Option<f64>,
    /// Step whose weights are the net's: the last, or the best.
    pub kept_step: u64,
    /// Every look at the validation set, those before a resume included.
    pub looks: Vec<Look>,
    /// Samples per second, validation and checkpoints included.
    pub samples_per_s: f64,
    /// Seconds, since the resume if it was one.
    pub elapsed_s: f64,
}

/// Trains a net from its present weights.
///
/// `samples` and `validation` are in raw units; the net's scales standardise them. `checkpoint`
/// is the JSON file to write (see [`crate::save`]), with what [`resume`] needs. `on_progress` is
/// called after every step; on `Break` the training writes its checkpoint and returns.
///
/// Fails on parameters out of range, on samples of other widths than the net's or none, on a
/// sample that is not finite, on a source or a file that fails, when the loss is no longer a number,
/// and when a net of 100 steps or more is no better on training samples than the means of the outputs
/// ([`NetsError::NothingLearned`]: a learning rate that left it dead, or hardly moved it). The net then
/// keeps the weights it came with, and the last checkpoint stays.
pub fn train(
    net: &mut Net,
    samples: &mut dyn BatchSource,
    validation: Option<&mut dyn BatchSource>,
    params: &TrainParams,
    checkpoint: Option<&Path>,
    on_progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<TrainInfo, NetsError> {
    let run = Run {
        engine: Engine::new(net.mlp(), Moments::zeros(net.mlp()), params)?,
        net,
        record: TrainRecord::new(params.clone()),
        best: None,
        checkpoint,
    };
    run.finish(samples, validation, on_progress)
}

/// Continues a training from its checkpoint, bit for bit as if there had been no break, and writes
/// to the same checkpoint.
///
/// Fails as [`train`] does, on a checkpoint that cannot be read, and on parameters that would make
/// it another training: seed, batch, learning rates and penalty must be the checkpoint's, and so
/// must the number of steps if the learning rate falls along it.
pub fn resume(
    checkpoint: &Path,
    samples: &mut dyn BatchSource,
    validation: Option<&mut dyn BatchSource>,
    params: &TrainParams,
    on_progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(Net, TrainInfo), NetsError> {
    let Resumable { mut net, mut record, moments, mut best } = load_for_resume(checkpoint)?;
    check_same(checkpoint, &record.params, params)?;
    if record.best_step == Some(record.step) {
        best = Some(net.mlp().clone());
    }
    record.params = params.clone();
    let run = Run {
        engine: Engine::new(net.mlp(), moments, params)?,
        net: &mut net,
        record,
        best,
        checkpoint: Some(checkpoint),
    };
    let info = run.finish(samples, validation, on_progress)?;
    Ok((net, info))
}

/// √MSE of a net over all samples, on standardised outputs. Fails as [`train`] does.
pub fn validation_loss(net: &Net, samples: &mut dyn BatchSource) -> Result<f64, NetsError> {
    check_source("validation", net, samples)?;
    mean_loss(net, (net.mlp(), Loss::RootMeanSquare), samples, 0)
}

struct Run<'a> {
    net: &'a mut Net,
    engine: Engine,
    record: TrainRecord,
    /// The weights of the best look, where they are not the network's own.
    best: Option<Mlp>,
    checkpoint: Option<&'a Path>,
}

/// Samples that are validated together.
const VALIDATION_BATCH: usize = 256;

impl Run<'_> {
    fn finish(
        mut self,
        samples: &mut dyn BatchSource,
        mut validation: Option<&mut dyn BatchSource>,
        on_progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<TrainInfo, NetsError> {
        let params = self.record.params.clone();
        params.check()?;
        check_source("training", self.net, samples)?;
        if let Some(validation) = &mut validation {
            check_source("validation", self.net, *validation)?;
        }
        let (mut batch, mut clock) = (Batch::default(), Clock::start(params.batch));
        let is_due = |every: u64, step: u64| every > 0 && step.is_multiple_of(every);
        let mut stopped = false;
        while !self.is_over() && !stopped {
            let progress = self.step(samples, &mut batch)?;
            let step = self.record.step;
            if is_due(params.validate_every, step) || step == params.steps {
                self.validate(&mut validation)?;
            }
            let progress = Progress {
                validation_loss: self.record.validation_loss,
                samples_per_s: clock.tick(),
                ..progress
            };
            stopped = on_progress(&progress).is_break();
            if is_due(params.checkpoint_every, step) && !self.is_over() && !stopped {
                self.write_checkpoint()?;
            }
        }
        if params.steps == 0 {
            self.validate(&mut validation)?;
        }
        self.write_checkpoint()?;
        self.end(samples, &clock)
    }

    /// Whether every step is done, or the validation loss has long not fallen.
    fn is_over(&self) -> bool {
        self.record.step >= self.record.params.steps || self.is_out_of_patience()
    }

    fn is_out_of_patience(&self) -> bool {
        let patience = self.record.params.patience;
        patience > 0 && self.record.looks_since_lowest() >= patience
    }

    /// Hands the net to the caller, once it is trained only if it has learned something.
    fn end(self, samples: &mut dyn BatchSource, clock: &Clock) -> Result<TrainInfo, NetsError> {
        let is_over = self.is_over();
        let (kept_step, mlp) = match (self.record.best_step, &self.best) {
            (Some(step), Some(best)) if is_over => (step, best.clone()),
            _ => (self.record.step, self.engine.to_mlp(self.net.mlp())?),
        };
        if is_over {
            check_learned(self.net, &mlp, samples, &self.record)?;
        }
        let look = self.record.looks.iter().find(|l| l.step == kept_step);
        let info = TrainInfo {
            step: self.record.step,
            stopped_early: !is_over,
            out_of_patience: self.record.step < self.record.params.steps && is_over,
            train_loss: self.record.train_loss,
            validation_loss: look.map(|l| l.validation_loss),
            kept_step,
            samples_per_s: clock.mean_rate(),
            elapsed_s: clock.elapsed_s(),
            looks: self.record.looks,
        };
        self.net.set_mlp(mlp);
        Ok(info)
    }

    fn step(
        &mut self,
        samples: &mut dyn BatchSource,
        batch: &mut Batch,
    ) -> Result<Progress, NetsError> {
        let (params, done) = (&self.record.params, self.record.step);
        batch.choose(params.seed, done, params.batch, samples);
        let (x, y) = batch.load(samples, self.net, done)?;
        let learning_rate = params.learning_rate_at(done);
        let mut loss = self.engine.forward(x, y)?;
        if !loss.is_finite() {
            return Err(NetsError::Diverged { step: done, learning_rate, loss });
        }
        let adam = AdamStep::new(done, learning_rate, params.l2);
        loss += params.l2 * self.engine.backward(x, &adam)?;
        self.record.step += 1;
        self.record.train_loss = Some(loss);
        Ok(Progress {
            step: self.record.step,
            steps: params.steps,
            learning_rate,
            train_loss: loss,
            validation_loss: None,
            samples_per_s: 0.0,
        })
    }

    /// Looks at the validation set, and keeps the weights if they are the best so far.
    fn validate(&mut self, source: &mut Option<&mut dyn BatchSource>) -> Result<(), NetsError> {
        let Some(source) = source else { return Ok(()) };
        let step = self.record.step;
        let mlp = self.engine.to_mlp(self.net.mlp())?;
        let of = (&mlp, self.record.params.loss);
        let loss = mean_loss(self.net, of, *source, step)?;
        self.record.validation_loss = Some(loss);
        self.record.looks.push(Look {
            step,
            train_loss: self.record.train_loss,
            validation_loss: loss,
        });
        if self.record.params.keep_best && self.record.lowest().is_some_and(|l| l.step == step) {
            self.record.best_step = Some(step);
            self.best = Some(mlp);
        }
        Ok(())
    }

    fn write_checkpoint(&self) -> Result<(), NetsError> {
        let Some(path) = self.checkpoint else {
            return Ok(());
        };
        let mut net = self.net.clone();
        net.set_mlp(self.engine.to_mlp(self.net.mlp())?);
        let is_apart = self.record.best_step != Some(self.record.step);
        let best = self.best.as_ref().filter(|_| is_apart);
        save_all(path, &net, &self.record, Some(&self.engine.moments()?), best)
    }
}

/// Loss of the weights `mlp` between the scales of `net`, in 32 bits.
fn mean_loss(
    net: &Net,
    (mlp, loss): (&Mlp, Loss),
    source: &mut dyn BatchSource,
    step: u64,
) -> Result<f64, NetsError> {
    let mut network = Network::new(mlp);
    let (mut batch, mut sum) = (Batch::default(), LossSum::new(loss, source.n_outputs()));
    let n = source.n_samples();
    for first in (0..n).step_by(VALIDATION_BATCH) {
        batch.rows.clear();
        batch.rows.extend(first..(first + VALIDATION_BATCH).min(n));
        let (x, y) = batch.load(source, net, step)?;
        sum.add(network.predict(x), y);
    }
    Ok(sum.value())
}

fn check_source(
    role: &'static str,
    net: &Net,
    source: &mut dyn BatchSource,
) -> Result<(), NetsError> {
    let spec = net.mlp().spec();
    if (source.n_inputs(), source.n_outputs()) != (spec.inputs, spec.outputs) {
        return Err(NetsError::SampleWidths {
            expected_inputs: spec.inputs,
            expected_outputs: spec.outputs,
            got_inputs: source.n_inputs(),
            got_outputs: source.n_outputs(),
        });
    }
    if source.n_samples() == 0 {
        return Err(NetsError::NoSamples { role });
    }
    Ok(())
}
