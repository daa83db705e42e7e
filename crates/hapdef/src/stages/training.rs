//! The training of one net: its scales, where its samples come from, and in which outputs.

use std::ops::ControlFlow;
use std::path::Path;

use hapdef_nets::train::{BatchSource, Progress, TrainInfo, resume, train as train_net};
use hapdef_nets::{Mlp, Net, Scale, TrainParams};

use super::drawn::DrawnSamples;
use super::in_modes::train_in_modes;
use super::nets::{CHECKPOINT_FILE, NetKind, fit_scales};
use crate::error::HapdefError;
use crate::profile::OutputScale;
use crate::run::Run;

/// The training of one net.
pub(super) struct Training<'a> {
    pub(super) run: &'a Run,
    pub(super) kind: NetKind,
    pub(super) params: &'a TrainParams,
    /// Where the net and its checkpoints go.
    pub(super) dir: &'a Path,
    /// Into how many modes the outputs go while it is trained; none: as they are.
    pub(super) output_modes: Option<usize>,
    /// By what its standardised outputs are divided.
    pub(super) output_scale: OutputScale,
}

impl Training<'_> {
    /// Trains the net from the start, or goes on from its checkpoint, with a bar that shows how far
    /// it is. Samples come from `drawn` where that is given; the scales fit the `fixed` ones.
    pub(super) fn run(
        &self,
        fixed: &mut dyn BatchSource,
        drawn: Option<&mut DrawnSamples<'_>>,
        validation: &mut dyn BatchSource,
    ) -> Result<(TrainInfo, Net), HapdefError> {
        let scales = fit_scales(fixed, self.output_scale)?;
        self.say_constant(&scales[0]);
        let samples = either(drawn, fixed);
        match self.output_modes {
            Some(rank) => self.run_in_modes(rank, scales, samples, validation),
            None => {
                let checkpoint = self.dir.join(CHECKPOINT_FILE);
                self.fit(&checkpoint, scales, samples, validation)
            }
        }
    }

    /// Trains the net of coordinates and unfolds it.
    fn run_in_modes(
        &self,
        rank: usize,
        scales: [Scale; 2],
        samples: &mut dyn BatchSource,
        validation: &mut dyn BatchSource,
    ) -> Result<(TrainInfo, Net), HapdefError> {
        train_in_modes(self.dir, rank, scales, samples, |checkpoint, scales, modes, samples| {
            self.run.say(&format!(
                "{rank} modes of the outputs leave out {:.3} % of their squares",
                modes.left_out() * 100.0
            ));
            self.fit(checkpoint, scales, samples, &mut modes.source(validation))
        })
    }

    fn fit(
        &self,
        checkpoint: &Path,
        [input, output]: [Scale; 2],
        samples: &mut dyn BatchSource,
        validation: &mut dyn BatchSource,
    ) -> Result<(TrainInfo, Net), HapdefError> {
        let (run, params) = (self.run, self.params);
        let bar = run.progress.bar(&self.kind.name(), params.steps);
        let mut go_on = |progress: &Progress| {
            bar.set(progress.step, state(progress));
            if run.stopping() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let validation = Some(validation);
        if checkpoint.exists() {
            let (net, info) = resume(checkpoint, samples, validation, params, &mut go_on)?;
            return Ok((info, net));
        }
        let spec = self.kind.spec(samples.n_inputs(), samples.n_outputs());
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
                self.kind.name(),
                columns.join(", ")
            ));
        }
    }
}

fn either<'a>(
    first: Option<&'a mut DrawnSamples<'_>>,
    second: &'a mut dyn BatchSource,
) -> &'a mut dyn BatchSource {
    match first {
        Some(first) => first,
        None => second,
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
