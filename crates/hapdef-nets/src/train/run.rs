//! The loop of a training.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use crate::checkpoint::{TrainRecord, load_for_resume, save};
use crate::error::NetsError;
use crate::net::Net;
use crate::optimiser::Moments;
use crate::params::TrainParams;
use crate::train::adam::AdamStep;
use crate::train::batch::Batch;
use crate::train::network::{Network, sum_of_squares};
use crate::train::source::BatchSource;
use crate::train::tensors::{edit_with, read};

/// How far a training has come, told after every step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Steps done, those before a resume included.
    pub step: u64,
    /// Steps in all.
    pub steps: u64,
    /// Step size of Adam in the last step.
    pub learning_rate: f64,
    /// √MSE of the last batch plus the penalty, standardised outputs.
    pub train_loss: f64,
    /// √MSE of the validation set when last looked at, standardised outputs.
    pub validation_loss: Option<f64>,
    /// Samples per second of the last second or so.
    pub samples_per_s: f64,
}

/// How a training ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainInfo {
    /// Steps done, those before a resume included.
    pub step: u64,
    /// Whether the caller stopped it before the last step.
    pub stopped_early: bool,
    /// √MSE of the last batch plus the penalty, standardised outputs; none if no step was done.
    pub train_loss: Option<f64>,
    /// √MSE of the validation set at the end, standardised outputs; none without such a set.
    pub validation_loss: Option<f64>,
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
/// sample that is not finite, on a source or a file that fails, and when the loss is no longer a
/// number. The net then keeps the weights it came with, and the last checkpoint stays.
pub fn train(
    net: &mut Net,
    samples: &mut dyn BatchSource,
    validation: Option<&mut dyn BatchSource>,
    params: &TrainParams,
    checkpoint: Option<&Path>,
    on_progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<TrainInfo, NetsError> {
    let record = TrainRecord {
        step: 0,
        params: params.clone(),
        train_loss: None,
        validation_loss: None,
    };
    let run = Run {
        network: Network::new(net.mlp())?,
        moments: Moments::zeros(net.mlp()),
        net,
        record,
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
    let (mut net, mut record, moments) = load_for_resume(checkpoint)?;
    check_same(checkpoint, &record.params, params)?;
    record.params = params.clone();
    let run = Run {
        network: Network::new(net.mlp())?,
        moments,
        net: &mut net,
        record,
        checkpoint: Some(checkpoint),
    };
    let info = run.finish(samples, validation, on_progress)?;
    Ok((net, info))
}

/// √MSE of a net over all samples, on standardised outputs. Fails as [`train`] does.
pub fn validation_loss(net: &Net, samples: &mut dyn BatchSource) -> Result<f64, NetsError> {
    check_source("validation", net, samples)?;
    mean_loss(&Network::new(net.mlp())?, net, samples, 0)
}

struct Run<'a> {
    net: &'a mut Net,
    network: Network,
    moments: Vec<Moments>,
    record: TrainRecord,
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
        while self.record.step < params.steps && !stopped {
            let progress = self.step(samples, &mut batch)?;
            let step = self.record.step;
            if is_due(params.validate_every, step) && step < params.steps {
                self.validate(&mut validation)?;
            }
            let progress = Progress {
                validation_loss: self.record.validation_loss,
                samples_per_s: clock.tick(),
                ..progress
            };
            stopped = on_progress(&progress).is_break();
            if is_due(params.checkpoint_every, step) && step < params.steps && !stopped {
                self.write_checkpoint(&self.trained_net()?)?;
            }
        }
        self.validate(&mut validation)?;
        let net = self.trained_net()?;
        self.write_checkpoint(&net)?;
        *self.net = net;
        Ok(TrainInfo {
            step: self.record.step,
            stopped_early: self.record.step < params.steps,
            train_loss: self.record.train_loss,
            validation_loss: self.record.validation_loss,
            samples_per_s: clock.mean_rate(),
            elapsed_s: clock.elapsed_s(),
        })
    }

    fn step(
        &mut self,
        samples: &mut dyn BatchSource,
        batch: &mut Batch,
    ) -> Result<Progress, NetsError> {
        let (params, done) = (&self.record.params, self.record.step);
        batch.draw(params.seed, done, params.batch, samples.n_samples());
        let (x, y) = batch.load(samples, self.net, done)?;
        let learning_rate = params.learning_rate_at(done);
        let pass = self.network.forward(&x, &y)?;
        let mut loss = pass.loss;
        if !loss.is_finite() {
            return Err(NetsError::Diverged {
                step: done,
                learning_rate,
                loss,
            });
        }
        let adam = AdamStep::new(done, learning_rate, params.l2);
        let moments = &mut self.moments;
        self.network.backward(pass, |i, layer, d_weights, d_bias| {
            loss += params.l2 * adam.apply(layer, &mut moments[i], d_weights, d_bias)?;
            Ok(())
        })?;
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

    fn validate(&mut self, source: &mut Option<&mut dyn BatchSource>) -> Result<(), NetsError> {
        if let Some(source) = source {
            let loss = mean_loss(&self.network, self.net, *source, self.record.step)?;
            self.record.validation_loss = Some(loss);
        }
        Ok(())
    }

    /// The net with the weights as they are now.
    fn trained_net(&self) -> Result<Net, NetsError> {
        let mut net = self.net.clone();
        net.set_mlp(self.network.to_mlp(self.net.mlp())?);
        Ok(net)
    }

    fn write_checkpoint(&self, net: &Net) -> Result<(), NetsError> {
        match self.checkpoint {
            Some(path) => save(path, net, &self.record, Some(&self.moments)),
            None => Ok(()),
        }
    }
}

fn mean_loss(
    network: &Network,
    net: &Net,
    source: &mut dyn BatchSource,
    step: u64,
) -> Result<f64, NetsError> {
    let (mut batch, mut sum) = (Batch::default(), 0.0);
    let n = source.n_samples();
    for first in (0..n).step_by(VALIDATION_BATCH) {
        batch.rows.clear();
        batch.rows.extend(first..(first + VALIDATION_BATCH).min(n));
        let (x, y) = batch.load(source, net, step)?;
        let p = network.predict(&x)?;
        edit_with(&p, &y, |p, y| {
            p.iter_mut().zip(y).for_each(|(p, y)| *p -= y);
        })?;
        sum += read(&p, sum_of_squares)?;
    }
    Ok((sum / (n * source.n_outputs()) as f64).sqrt())
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

fn check_same(path: &Path, saved: &TrainParams, asked: &TrainParams) -> Result<(), NetsError> {
    let knobs = |p: &TrainParams| {
        let steps = p.final_learning_rate.map(|_| p.steps);
        [
            ("seed", p.seed.to_string()),
            ("batch", p.batch.to_string()),
            ("learning_rate", p.learning_rate.to_string()),
            (
                "final_learning_rate",
                format!("{:?}", p.final_learning_rate),
            ),
            ("l2", p.l2.to_string()),
            ("steps", format!("{steps:?}")),
        ]
    };
    for ((name, saved), (_, asked)) in knobs(saved).into_iter().zip(knobs(asked)) {
        if saved != asked {
            return Err(NetsError::ResumeParams {
                path: path.to_path_buf(),
                name,
                saved,
                asked,
            });
        }
    }
    Ok(())
}

/// Counts samples per second.
struct Clock {
    batch: f64,
    start: Instant,
    n_steps: u64,
    window_start: Instant,
    window_steps: u64,
    rate: f64,
}

impl Clock {
    fn start(batch: usize) -> Self {
        let now = Instant::now();
        Self {
            batch: batch as f64,
            start: now,
            n_steps: 0,
            window_start: now,
            window_steps: 0,
            rate: 0.0,
        }
    }

    /// Counts a step, and returns the rate of the last second or so.
    fn tick(&mut self) -> f64 {
        self.n_steps += 1;
        self.window_steps += 1;
        let window_s = self.window_start.elapsed().as_secs_f64();
        if window_s > 1.0 || self.rate == 0.0 {
            self.rate = self.window_steps as f64 * self.batch / window_s.max(1e-9);
        }
        if window_s > 1.0 {
            (self.window_start, self.window_steps) = (Instant::now(), 0);
        }
        self.rate
    }

    fn mean_rate(&self) -> f64 {
        self.n_steps as f64 * self.batch / self.elapsed_s().max(1e-9)
    }

    fn elapsed_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}
