//! Where metrics and pages go.

use std::io::Stdout;
use std::path::{Path, PathBuf};

use anyhow::Result;
use hapdef_report::{MetricContext, MetricLog, Report, write_report};

/// Where metrics go.
#[derive(clap::Args)]
pub(crate) struct MetricsArgs {
    /// Where metrics are appended.
    #[arg(long, env = "HAPDEF_METRICS", default_value = "target/hapdef/metrics.json")]
    pub(crate) metrics: PathBuf,
    /// The seed the metrics carry; only `robustness` draws something by it, which elements are stiff
    /// where they are scattered at random.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}

impl MetricsArgs {
    /// A log on standard output.
    pub(crate) fn log(&self) -> MetricLog<Stdout> {
        MetricLog::new(std::io::stdout(), MetricContext::here(self.seed))
    }
}

/// Writes a report into `folder` beside the metrics' file, with the metrics of `log`, and says where.
pub(crate) fn write_page(
    mut report: Report,
    log: &MetricLog<Stdout>,
    metrics: &Path,
    folder: &str,
) -> Result<()> {
    report.metrics = log.records().to_vec();
    let paths = write_report(&metrics.with_file_name(folder), &report)?;
    if let Some(page) = paths.last() {
        eprintln!("page: {}", page.display());
    }
    Ok(())
}
