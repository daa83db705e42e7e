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
    /// Contacts by superposition: effort of the search, with the paper's nets and the bound.
    Inverse,
}

/// `cargo xtask frontier`.
pub(crate) fn run(args: &FrontierArgs) -> Result<()> {
    let program = match args.what {
        Subject::Nets => "frontier-nets",
        Subject::Inverse => "frontier-inverse",
    };
    let mut pipeline = args.pipeline.clone();
    pipeline.quick = !args.full;
    let mut command = Command::new(release_binary("hapdef-repro")?);
    finish(command.arg(program).args(common(&pipeline)))
}
