//! `hapdef-verify robustness`: the solver at its extremes.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;
use hapdef_bench::robustness::{Inputs, Outputs, Row};
use hapdef_report::MetricContext;

use super::context::MetricsArgs;
use crate::robustness::{ROBUSTNESS_TABLE, robustness_trials};

/// Arguments of `robustness`.
#[derive(clap::Args)]
pub(crate) struct RobustnessArgs {
    /// What is tried.
    #[arg(value_enum)]
    part: Part,
    /// Write the table to this file.
    #[arg(long)]
    write: Option<PathBuf>,
    /// Compare what was said and the verdicts with this file; fail where they differ.
    #[arg(long, conflicts_with = "write")]
    check: Option<PathBuf>,
    /// Print the rows as one JSON array instead of text.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    output: MetricsArgs,
}

/// What is tried at its extremes.
#[derive(Clone, Copy, ValueEnum)]
enum Part {
    /// The elasticity solver.
    Fe,
}

/// Solves, prints and judges; false where a row is silently wrong or not what it should be.
pub(crate) fn run(args: &RobustnessArgs) -> Result<bool> {
    let Part::Fe = args.part;
    let rows = ROBUSTNESS_TABLE.rows(robustness_trials(args.output.seed), |row| {
        if !args.json {
            println!("{}", row.line());
        }
    });
    if args.json {
        println!("{}", rows.iter().map(Row::json).collect::<serde_json::Value>());
    }
    let outputs = Outputs {
        metrics: &args.output.metrics,
        write: args.write.as_deref(),
        check: args.check.as_deref(),
    };
    let log = (std::io::stdout(), MetricContext::here(args.output.seed));
    let published = ROBUSTNESS_TABLE.publish(&rows, Inputs::default(), log, outputs)?;
    eprintln!("page: {}", published.page.display());
    for difference in &published.differences {
        eprintln!("{difference}");
    }
    Ok(published.differences.is_empty() && published.n_failed == 0)
}
