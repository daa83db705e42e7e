//! Command-line arguments of what trains nets.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use hapdef::{OutputScale, Profile, Run, Samples};
use hapdef_nets::{Loss, NetsError, TrainBackend};

use crate::args::at_least;
use crate::{PrepareError, SceneArgs};

/// Fewest samples of a set: one in five is for testing, and the smallest net is trained on 60 %.
const MIN_SAMPLES: usize = 20;

/// Where `--help` lists how nets are trained: after what a command has of its own.
const TRAINING: &str = "Training";

/// How a scene's nets are trained, where a command may train them.
#[derive(Args, Clone, Debug)]
pub struct TrainingArgs {
    /// Optimiser steps of each F_R instead of the profile's.
    #[arg(long, help_heading = TRAINING, value_parser = at_least::<1>)]
    pub steps: Option<usize>,
    /// Weight of the L2 term of each F_R instead of the profile's; the paper states 1e-4.
    #[arg(long, help_heading = TRAINING)]
    pub l2: Option<f64>,
    /// Samples of each step of F_R instead of the profile's; the paper has 100.
    #[arg(long, help_heading = TRAINING, value_parser = at_least::<1>)]
    pub batch: Option<usize>,
    /// Train F_R in that many modes of its outputs, and unfold it to all surface nodes after; 0 trains
    /// the nodes themselves.
    #[arg(long, help_heading = TRAINING, value_name = "N")]
    pub output_modes: Option<usize>,
    /// By what F_R's outputs are divided in training, instead of the profile's choice.
    #[arg(long, help_heading = TRAINING, value_parser = output_scales())]
    pub output_scale: Option<OutputScale>,
    /// What the training of F_R minimises, `root-mean-square` (the paper's) or `mean-of-samples`,
    /// instead of the profile's choice.
    #[arg(long, help_heading = TRAINING, value_parser = loss)]
    pub loss: Option<Loss>,
    /// Where the training samples of F_R come from, instead of the profile's choice.
    #[arg(long, help_heading = TRAINING, value_parser = sources_of_samples())]
    pub samples: Option<Samples>,
    /// What trains the nets: `slices`, `candle`, or `cuda` and `cuda:1` for a GPU in a build with
    /// the feature `cuda`.
    #[arg(long, help_heading = TRAINING, default_value = "slices", value_parser = backend)]
    pub backend: TrainBackend,
    /// Optimiser steps of F_T, F_S and the direct net instead of the profile's.
    #[arg(long, help_heading = TRAINING, value_parser = at_least::<1>)]
    pub other_steps: Option<usize>,
    #[command(flatten)]
    amounts: SampleArgs,
}

/// How many samples the nets are trained on.
#[derive(Args, Clone, Debug)]
pub struct SampleArgs {
    /// Single-contact samples instead of the profile's, simulated and on the rig.
    #[arg(long, help_heading = TRAINING, value_parser = at_least::<MIN_SAMPLES>)]
    pub singles: Option<usize>,
    /// Samples of each set of several contacts instead of the profile's.
    #[arg(long, help_heading = TRAINING, value_parser = at_least::<MIN_SAMPLES>)]
    pub multis: Option<usize>,
}

impl TrainingArgs {
    /// As [`SceneArgs::prepare`], with the nets trained as these say.
    ///
    /// # Errors
    /// The same.
    pub fn prepare(&self, scene: &SceneArgs) -> Result<Run, PrepareError> {
        scene.prepare_amounts(self.profile(scene))
    }

    /// Reads the scene alone, one of several of a process whose threads [`SceneArgs::start_threads`] sets; `stop`
    /// stops the run.
    ///
    /// # Errors
    /// [`hapdef::HapdefError::Scene`] when the scene is refused.
    pub fn read(&self, scene: &SceneArgs, stop: Arc<AtomicBool>) -> Result<Run, PrepareError> {
        Ok(Run { stop, ..scene.read(self.profile(scene))? })
    }

    fn profile(&self, scene: &SceneArgs) -> Profile {
        let mut profile = self.amounts.profile(scene);
        let map = &mut profile.reconstruction;
        map.steps = self.steps.unwrap_or(map.steps);
        map.l2 = self.l2.unwrap_or(map.l2);
        map.batch = self.batch.unwrap_or(map.batch);
        map.loss = self.loss.unwrap_or(map.loss);
        profile.backend = self.backend;
        profile.samples = self.samples.unwrap_or(profile.samples);
        profile.output_scale = self.output_scale.unwrap_or(profile.output_scale);
        profile.output_modes = self.output_modes.unwrap_or(profile.output_modes);
        if let Some(steps) = self.other_steps {
            for schedule in [&mut profile.transfer, &mut profile.sensitivity, &mut profile.direct] {
                schedule.steps = steps;
            }
        }
        profile
    }
}

impl SampleArgs {
    /// As [`SceneArgs::prepare`], with as many samples as these say.
    ///
    /// # Errors
    /// The same.
    pub fn prepare(&self, scene: &SceneArgs) -> Result<Run, PrepareError> {
        scene.prepare_amounts(self.profile(scene))
    }

    fn profile(&self, scene: &SceneArgs) -> Profile {
        let mut profile = scene.profile.amounts();
        profile.n_multi = self.multis.unwrap_or(profile.n_multi);
        if let Some(singles) = self.singles {
            (profile.n_single, profile.n_real_single) = (singles, singles);
        }
        profile
    }
}

fn sources_of_samples() -> impl TypedValueParser<Value = Samples> {
    PossibleValuesParser::new([
        PossibleValue::new("fixed").help("The training parts of the sets, as in the paper"),
        PossibleValue::new("drawn")
            .help("Drawn when needed, in equal shares of every contact count, none twice"),
    ])
    .map(|name| if name == "drawn" { Samples::Drawn } else { Samples::Fixed })
}

fn output_scales() -> impl TypedValueParser<Value = OutputScale> {
    PossibleValuesParser::new([
        PossibleValue::new("each")
            .help("Each by its own deviation, as in the paper: all nodes count alike"),
        PossibleValue::new("one").help("All by one deviation: micrometres count alike"),
    ])
    .map(|name| if name == "one" { OutputScale::One } else { OutputScale::Each })
}

fn loss(text: &str) -> Result<Loss, String> {
    match text {
        "root-mean-square" => Ok(Loss::RootMeanSquare),
        "mean-of-samples" => Ok(Loss::MeanOfSamples),
        _ => Err("expected root-mean-square or mean-of-samples".into()),
    }
}

fn backend(text: &str) -> Result<TrainBackend, String> {
    let backend = match text.split_once(':') {
        None if text == "slices" => TrainBackend::Slices,
        None if text == "candle" => TrainBackend::Candle,
        None if text == "cuda" => TrainBackend::Cuda { ordinal: 0 },
        Some(("cuda", number)) => {
            let ordinal = number.parse().map_err(|e| format!("cuda:{number}: {e}"))?;
            TrainBackend::Cuda { ordinal }
        }
        _ => return Err("expected slices, candle, cuda or cuda:N".into()),
    };
    match backend.is_built() {
        true => Ok(backend),
        false => Err(NetsError::NoBackend { backend }.to_string()),
    }
}
