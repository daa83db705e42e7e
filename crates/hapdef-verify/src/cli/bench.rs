//! `hapdef-verify bench`: times against other solvers.

use anyhow::Result;

use super::context::MetricsArgs;
use crate::bench::{self, BenchOptions};

/// Arguments of `bench`.
#[derive(clap::Args)]
pub(crate) struct BenchArgs {
    #[command(flatten)]
    options: BenchOptions,
    #[command(flatten)]
    output: MetricsArgs,
}

/// Measures and prints.
pub(crate) fn run(args: &BenchArgs) -> Result<()> {
    let mut log = args.output.log();
    bench::run(&args.options, &mut log)?;
    Ok(log.append_to(&args.output.metrics)?)
}
