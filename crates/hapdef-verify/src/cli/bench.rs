//! `hapdef-verify bench`: times against other solvers.

use std::path::PathBuf;

use anyhow::Result;
use hapdef_verify::bench::{self, BenchOptions};

use super::context::MetricsArgs;

/// Arguments of `bench`.
#[derive(clap::Args)]
pub(crate) struct BenchArgs {
    /// The limb, a solid deck.
    #[arg(long, default_value = "fixtures/shin/shin.inp.gz")]
    deck: PathBuf,
    /// Loads of the campaign.
    #[arg(long, default_value_t = 3255)]
    loads: usize,
    /// Threads where no other solver is compared with; all cores where left out.
    #[arg(long)]
    threads: Option<usize>,
    /// Leave the block of 300,000 equations out.
    #[arg(long)]
    skip_large: bool,
    #[command(flatten)]
    output: MetricsArgs,
}

/// Measures and prints.
pub(crate) fn run(args: &BenchArgs) -> Result<()> {
    let mut options =
        BenchOptions { n_loads: args.loads, large: !args.skip_large, ..BenchOptions::default() };
    if let Some(threads) = args.threads {
        options.n_threads = threads;
    }
    let mut log = args.output.log();
    bench::run(&args.deck, &options, &mut log)?;
    log.append_to(&args.output.metrics)?;
    Ok(())
}
