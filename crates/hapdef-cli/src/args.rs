//! Command-line arguments that every program over a scene shares.

use std::path::PathBuf;

use clap::builder::{PathBufValueParser, PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use hapdef::scene::scene_file;
use hapdef::{HapdefError, OutputScale, Profile, Run, Samples};
use hapdef_nets::{Loss, NetsError, TrainBackend};

use crate::PrepareError;

/// Fewest samples of a set: one in five is for testing, and the smallest net is trained on 60 %.
const MIN_SAMPLES: usize = 20;

/// Where `--help` lists how nets are trained: after what a command has of its own.
const TRAINING: &str = "Training";

/// A scene and how to run it.
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// The scene file, or the folder of a `scene.json`.
    #[arg(value_parser = scene_path())]
    pub scene: PathBuf,
    /// How much to make: `quick` for minutes, `full` for the paper's amounts of data.
    #[arg(long, default_value = "full")]
    pub profile: ProfileName,
    /// Folder for everything that is written.
    #[arg(long, env = "HAPDEF_OUT", default_value = "target/hapdef")]
    pub out: PathBuf,
    /// Threads; results don't depend on it.
    #[arg(long, default_value_t = default_threads(), value_parser = at_least::<1>)]
    pub threads: usize,
    /// Seed of the training side instead of the scene's.
    #[arg(long)]
    pub seed: Option<u64>,
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
    /// Single-contact samples instead of the profile's, simulated and on the rig.
    #[arg(long, help_heading = TRAINING, value_parser = at_least::<MIN_SAMPLES>)]
    pub singles: Option<usize>,
    /// Samples of each set of several contacts instead of the profile's.
    #[arg(long, help_heading = TRAINING, value_parser = at_least::<MIN_SAMPLES>)]
    pub multis: Option<usize>,
}

/// Name of a [`Profile`].
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ProfileName {
    /// Minutes instead of hours: less data, short training.
    Quick,
    /// The paper's amounts of data.
    Full,
}

impl SceneArgs {
    /// Reads the scene and prepares the run; sets the threads of the whole process and lets Ctrl-C
    /// stop the run at the next step, with a checkpoint kept; a second Ctrl-C ends it at once.
    ///
    /// # Errors
    /// [`HapdefError::Scene`] when the scene is refused, [`HapdefError::Threads`] and
    /// [`PrepareError::Signal`] when the process has its threads or its handler already.
    pub fn prepare(&self) -> Result<Run, PrepareError> {
        rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .build_global()
            .map_err(HapdefError::Threads)?;
        let progress = crate::on_stderr();
        let mut run = Run::new(&self.scene, self.amounts(), &self.out, self.threads, progress)?;
        if let Some(seed) = self.seed {
            run.set_seed(seed)?;
        }
        crate::stop_on_signals(run.stop.clone())?;
        Ok(run)
    }

    fn amounts(&self) -> Profile {
        let mut profile = match self.profile {
            ProfileName::Quick => Profile::quick(),
            ProfileName::Full => Profile::full(),
        };
        profile.reconstruction.steps = self.steps.unwrap_or(profile.reconstruction.steps);
        profile.reconstruction.l2 = self.l2.unwrap_or(profile.reconstruction.l2);
        profile.reconstruction.batch = self.batch.unwrap_or(profile.reconstruction.batch);
        profile.backend = self.backend;
        profile.samples = self.samples.unwrap_or(profile.samples);
        profile.output_scale = self.output_scale.unwrap_or(profile.output_scale);
        profile.reconstruction.loss = self.loss.unwrap_or(profile.reconstruction.loss);
        profile.output_modes = self.output_modes.unwrap_or(profile.output_modes);
        if let Some(steps) = self.other_steps {
            for schedule in [&mut profile.transfer, &mut profile.sensitivity, &mut profile.direct] {
                schedule.steps = steps;
            }
        }
        profile.n_multi = self.multis.unwrap_or(profile.n_multi);
        if let Some(singles) = self.singles {
            (profile.n_single, profile.n_real_single) = (singles, singles);
        }
        profile
    }
}

/// The path of a scene, of a folder the `scene.json` in it.
pub fn scene_path() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(|path| scene_file(&path))
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

fn default_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn at_least<const LEAST: usize>(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(number) if number >= LEAST => Ok(number),
        _ => Err(format!("expected a whole number of at least {LEAST}")),
    }
}
