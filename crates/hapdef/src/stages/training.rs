//! The training of one net: its scales, where its samples come from, and in which outputs.

use std::ops::ControlFlow;
use std::path::Path;

use hapdef_nets::train::{BatchSource, Progress, TrainInfo, resume, train as train_net};
use hapdef_nets::{Mlp, MlpSpec, Net, Scale, TrainParams};

use super::in_modes::train_in_modes;
use super::nets::{CHECKPOINT_FILE, fit_scales};
use crate::error::HapdefError;
use crate::profile::OutputScale;
use crate::run::Run;

/// The training of one net.
pub struct Training<'a> {
    /// The run that it belongs to.
    pub run: &'a Run,
    /// The net's name.
    pub name: &'a str,
    /// The net of so many inputs and outputs.
    pub spec: &'a dyn Fn(usize, usize) -> MlpSpec,
    /// Steps, learning rates, seed.
    pub params: &'a TrainParams,
    /// Where the net and its checkpoints go.
    pub dir: &'a Path,
    /// Into how many modes the outputs go while it is trained; 0 or as many as there are: as they are.
    pub output_modes: usize,
    /// By what its standardised outputs are divided.
    pub output_scale: OutputScale,
}

impl Training<'_> {
    /// Trains the net from the start, or goes on from its checkpoint, with a bar that shows how far
    /// it is. Samples come from `drawn` where that is given; the scales fit the `fixed` ones.
    ///
    /// # Errors
    /// What samples and training fail with, and files that can't be written.
    pub fn run(
        &self,
        fixed: &mut dyn BatchSource,
        drawn: Option<&mut dyn BatchSource>,
        validation: Option<&mut dyn BatchSource>,
    ) -> Result<(TrainInfo, Net), HapdefError> {
        let scales = fit_scales(fixed, self.output_scale)?;
        self.say_constant(&scales[0]);
        let samples: &mut dyn BatchSource = match drawn {
            Some(drawn) => drawn,
            None => fixed,
        };
        let rank = self.output_modes;
        if rank == 0 || rank >= samples.n_outputs() {
            return self.fit(&self.dir.join(CHECKPOINT_FILE), scales, samples, validation);
        }
        train_in_modes(self.dir, rank, scales, samples, |checkpoint, scales, modes, samples| {
            self.run.say(&format!(
                "{rank} modes of the outputs leave out {:.3} % of their squares",
                modes.left_out() * 100.0
            ));
            match validation {
                Some(of) => self.fit(checkpoint, scales, samples, Some(&mut modes.source(of))),
                None => self.fit(checkpoint, scales, samples, None),
            }
        })
    }

    fn fit(
        &self,
        checkpoint: &Path,
        [input, output]: [Scale; 2],
        samples: &mut dyn BatchSource,
        validation: Option<&mut dyn BatchSource>,
    ) -> Result<(TrainInfo, Net), HapdefError> {
        let (run, params) = (self.run, self.params);
        let bar = run.progress.bar(self.name, params.steps);
        let mut go_on = |progress: &Progress| {
            bar.set(progress.step, state(progress));
            if run.stopping() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        if checkpoint.exists() {
            let (net, info) = resume(checkpoint, samples, validation, params, &mut go_on)?;
            return Ok((info, net));
        }
        let spec = (self.spec)(samples.n_inputs(), samples.n_outputs());
        let mut net = Net::new(Mlp::random(&spec, params.seed)?, input, output)?;
        let path = Some(checkpoint);
        let info = train_net(&mut net, samples, validation, params, path, &mut go_on)?;
        Ok((info, net))
    }

    /// Names the inputs that never vary in training: the net can't learn what they mean, and ignores
    /// them.
    fn say_constant(&self, input: &Scale) {
        let columns: Vec<String> = input.constant_columns().map(|c| c.to_string()).collect();
        if !columns.is_empty() {
            self.run.say(&format!(
                "{}: inputs {} (counted from 0) never vary in its training samples; it will ignore \
                 them",
                self.name,
                columns.join(", ")
            ));
        }
    }
}

/// What a progress bar says.
fn state(progress: &Progress) -> String {
    format!(
        "loss {:.4} val {:.4}  {:.0}/s",
        progress.train_loss,
        progress.validation_loss.unwrap_or(f64::NAN),
        progress.samples_per_s
    )
}
