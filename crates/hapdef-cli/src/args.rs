//! Command-line arguments that every program over a scene shares.

use std::path::PathBuf;

use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args, ValueEnum};
use hapdef::scene::scene_file;
use hapdef::{HapdefError, Profile, Run};

use crate::PrepareError;

/// A scene and how to run it.
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// The scene file, or the folder of a `scene.json`.
    #[arg(value_parser = scene_path())]
    pub scene: PathBuf,
    /// How much to make: `quick` for minutes, `full` for the paper's amounts of data.
    #[arg(long, default_value = "full")]
    pub profile: ProfileName,
    /// Folder of results: stages that are kept and not run again, pages, figures, by the scene's name.
    #[arg(long, env = "HAPDEF_OUT", default_value = "target/hapdef")]
    pub results: PathBuf,
    /// Threads; results don't depend on it.
    #[arg(long, default_value_t = default_threads(), value_parser = at_least::<1>)]
    pub threads: usize,
    /// Seed of the training side instead of the scene's.
    #[arg(long)]
    pub seed: Option<u64>,
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
        self.prepare_amounts(self.profile.amounts())
    }

    /// Sets the threads of the whole process, for several scenes that are read one by one.
    ///
    /// # Errors
    /// [`HapdefError::Threads`] when the process has its threads already.
    pub fn start_threads(&self) -> Result<(), PrepareError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads);
        Ok(pool.build_global().map_err(HapdefError::Threads)?)
    }

    /// As [`Self::prepare`] with other amounts than the profile's.
    pub(crate) fn prepare_amounts(&self, amounts: Profile) -> Result<Run, PrepareError> {
        self.start_threads()?;
        let run = self.read(amounts)?;
        crate::stop_on_signals(run.stop.clone())?;
        Ok(run)
    }

    /// Reads the scene alone.
    pub(crate) fn read(&self, amounts: Profile) -> Result<Run, PrepareError> {
        let progress = crate::on_stderr();
        let mut run = Run::new(&self.scene, amounts, &self.results, self.threads, progress)?;
        if let Some(seed) = self.seed {
            run.set_seed(seed)?;
        }
        Ok(run)
    }
}

impl ProfileName {
    pub(crate) fn amounts(self) -> Profile {
        match self {
            Self::Quick => Profile::quick(),
            Self::Full => Profile::full(),
        }
    }
}

/// The path of a scene, of a folder the `scene.json` in it.
pub fn scene_path() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(|path| scene_file(&path))
}

fn default_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

pub(crate) fn at_least<const LEAST: usize>(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(number) if number >= LEAST => Ok(number),
        _ => Err(format!("expected a whole number of at least {LEAST}")),
    }
}
