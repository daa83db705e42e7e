//! Times of the networks.

mod clock;
mod frontier;
mod inference;
mod measure;
mod methods;
mod narrow;
mod peers;
mod python;
mod testset;
mod training;
mod unscaled;
mod variants;

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use hapdef::{Profile, Run};

use crate::run::facts;

pub(crate) use frontier::{FrontierArgs, run as run_frontier};
pub(crate) use inference::random;
pub(crate) use methods::{Method, Passes};

/// Arguments of `bench-nets`.
#[derive(Args, Clone, Debug)]
pub(crate) struct BenchNetsArgs {
    /// The scene whose nets are reduced; trained if they are not there.
    #[arg(long, default_value = "fixtures/shin/scene.json")]
    pub(crate) scene: PathBuf,
    /// Folder of results: stages that are kept and not run again, tables, figures.
    #[arg(long, env = "HAPDEF_OUT", default_value = "target/hapdef")]
    pub(crate) results: PathBuf,
    /// Draws the random weights.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Rounds in which every path has its turn.
    #[arg(long, default_value_t = 40)]
    pub(crate) rounds: usize,
    /// Python with onnxruntime, onnx, torch and numpy, for the rows of other programs.
    #[arg(long, env = "HAPDEF_PYTHON", default_value = "python3")]
    pub(crate) python: PathBuf,
    /// Random weights only: no scene, no reduced nets.
    #[arg(long)]
    pub(crate) skip_trained: bool,
    /// The scene's nets as a full run trains them, instead of a quick one.
    #[arg(long, conflicts_with = "skip_trained")]
    pub(crate) full: bool,
}

/// Prints a METRIC line for each figure and adds it to `metrics.json`.
pub(crate) fn run(args: &BenchNetsArgs) -> Result<()> {
    let mut log = facts::log(args.seed);
    inference::run(args, &mut log)?;
    if args.skip_trained {
        for name in ["nets.reduced_p50_us", "nets.reduced_error_ratio"] {
            log.skipped(name, "--skip-trained")?;
        }
    } else {
        let points = reduced(args)?;
        for metric in &frontier::REDUCED {
            metric.log(&points, &mut log)?;
        }
    }
    training::training(&args.python, &mut log)?;
    Ok(log.append_to(&args.results.join("metrics.json"))?)
}

/// Every variant of the scene's nets.
fn reduced(args: &BenchNetsArgs) -> Result<Vec<measure::Point>> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let profile = match args.full {
        true => Profile::full(),
        false => Profile::quick(),
    };
    let progress = hapdef_cli::on_stderr();
    let run = Run::new(&args.scene, profile, &args.results, threads, progress)?;
    Ok(measure::measure(&run, args.rounds.min(20), None)?.points)
}
