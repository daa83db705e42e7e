//! The program's part of the stability table of nets and baselines.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use hapdef_repro::{MetricLog, NetsVerdict, nets_differences, nets_line, nets_markdown, nets_rows};

use super::facts;

/// Arguments of `stability`.
#[derive(clap::Args)]
pub(crate) struct StabilityArgs {
    /// Write the table to this file.
    #[arg(long)]
    write: Option<PathBuf>,
    /// Fail where this file says something else.
    #[arg(long)]
    check: Option<PathBuf>,
    /// The metrics' file.
    #[arg(long, default_value = "target/hapdef/metrics.json")]
    metrics: PathBuf,
}

/// Runs the rows.
pub(crate) fn run(args: &StabilityArgs) -> Result<()> {
    let rows = nets_rows(|row| println!("{}", nets_line(row)));
    let failed = rows.iter().filter(|row| row.is_failed()).count();
    let wrong = rows
        .iter()
        .filter(|row| row.verdict() == NetsVerdict::SilentlyWrong);
    let mut log = MetricLog::new(std::io::stdout(), facts::metric_context_of(0));
    log.value("stability.rows", rows.len() as f64, "1")?;
    log.value("stability.failed", failed as f64, "1")?;
    log.value("stability.silently_wrong", wrong.count() as f64, "1")?;
    log.append_to(&args.metrics)?;
    if let Some(path) = &args.write {
        super::search::write(path, &nets_markdown(&rows))?;
    }
    if let Some(path) = &args.check {
        let committed =
            std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
        let faults = nets_differences(&rows, &committed);
        if !faults.is_empty() {
            bail!("{} is stale:\n  {}", path.display(), faults.join("\n  "));
        }
    }
    if failed > 0 {
        bail!("{failed} of {} rows failed", rows.len());
    }
    Ok(())
}
