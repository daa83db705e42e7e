//! Error against run time.

use std::process::Command;

use anyhow::Result;
use clap::ValueEnum;

use crate::pipeline::{PipelineArgs, common, finish};
use crate::tool::release_binary;

/// Arguments of `frontier`.
#[derive(clap::Args)]
pub(crate) struct FrontierArgs {
    /// What is compared.
    what: Subject,
    /// `--quick` takes the quick run's data and nets; this is also the default. `--full` takes the
    /// paper's amounts.
    #[arg(long, conflicts_with = "quick")]
    full: bool,
    #[command(flatten)]
    pipeline: PipelineArgs,
}

/// What `frontier` can compare.
#[derive(Clone, Copy, ValueEnum)]
enum Subject {
    /// Networks and the paper's baselines.
    Nets,
}

/// `cargo xtask frontier nets`.
pub(crate) fn run(args: &FrontierArgs) -> Result<()> {
    let Subject::Nets = args.what;
    let mut pipeline = args.pipeline.clone();
    pipeline.quick = !args.full;
    let mut command = Command::new(release_binary("hapdef-repro")?);
    finish(command.arg("frontier-nets").args(common(&pipeline)))
}
