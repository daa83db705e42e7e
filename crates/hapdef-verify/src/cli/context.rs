//! What every metric carries, and where pages go.

use std::io::Stdout;
use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

use anyhow::Result;
use hapdef_report::{MetricContext, MetricLog, NamedText, Report, write_report};

/// Commit, machine and time of this run.
pub(crate) fn context(seed: u64) -> MetricContext {
    let commit = output("git", &["rev-parse", "--short", "HEAD"]);
    MetricContext {
        commit: commit.unwrap_or_else(|| "unknown".into()),
        machine: machine(),
        seed,
        time: now(),
    }
}

/// Writes a report into `folder` beside the metrics' file, with the metrics of `log`, and says where.
pub(crate) fn write_page(
    mut report: Report,
    log: &MetricLog<Stdout>,
    metrics: &Path,
    folder: &str,
) -> Result<()> {
    let records = log.records();
    report.metrics = records.to_vec();
    if let Some(record) = records.first() {
        let of = &record.context;
        report.facts.extend(
            [
                ("commit", &of.commit),
                ("machine", &of.machine),
                ("time", &of.time),
            ]
            .map(|(name, text)| NamedText {
                name: name.into(),
                text: text.clone(),
            }),
        );
    }
    let paths = write_report(&metrics.with_file_name(folder), &report)?;
    if let Some(page) = paths.last() {
        eprintln!("page: {}", page.display());
    }
    Ok(())
}

/// Seconds since 1970 as RFC 3339 in UTC, by the date program; plain seconds without it.
fn now() -> String {
    output("date", &["-u", "+%Y-%m-%dT%H:%M:%SZ"]).unwrap_or_else(|| {
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        format!("{} s since 1970", since.map_or(0, |d| d.as_secs()))
    })
}

fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map_or("unknown processor", |(_, name)| name.trim());
    format!("{name}, {cores} cores")
}

fn output(program: &str, words: &[&str]) -> Option<String> {
    let output = Command::new(program).args(words).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (output.status.success() && !text.is_empty()).then_some(text)
}
