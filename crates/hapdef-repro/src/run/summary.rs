//! What a run prints: metrics for machines, tables and verdicts for people.

use std::io::Stdout;

use anyhow::Result;
use hapdef::Pipeline;
use hapdef_bench::terminal_table;
use hapdef_report::{MetricLog, Report, TextTable};

use super::{claims, contents};
use crate::tables::{Claim, Table1, Table2, TestSet, fnn_over_lr};

/// What the metrics are taken from.
pub(crate) struct Printed<'a> {
    /// By mean absolute error.
    pub(crate) table1: &'a Table1,
    pub(crate) table2: &'a Table2,
    pub(crate) claims: &'a [Claim],
    pub(crate) done: &'a Pipeline,
    /// Since the command began, s.
    pub(crate) wall_s: f64,
    /// Stages that were in the cache when it began.
    pub(crate) n_cached: usize,
}

/// The metrics of the demo or of the whole reproduction.
pub(crate) fn log(
    log: &mut MetricLog<Stdout>,
    printed: &Printed<'_>,
    is_repro: bool,
) -> Result<()> {
    if is_repro { log_repro(log, printed) } else { log_demo(log, printed) }
}

fn log_repro(log: &mut MetricLog<Stdout>, printed: &Printed<'_>) -> Result<()> {
    let (n_claims, n_held) = claims::count(printed.claims);
    match printed.n_cached {
        0 => log.value("repro.wall_s", printed.wall_s, "s")?,
        n => log.skipped("repro.wall_s", &format!("{n} stages were in the cache"))?,
    }
    log.value("repro.claims", n_claims as f64, "1")?;
    log.value("repro.claims_held", n_held as f64, "1")?;
    for (test, ratio) in TestSet::ALL.into_iter().zip(fnn_over_lr(printed.table1)) {
        let name = format!("repro.fnn_over_lr_{}", test.name());
        match ratio.filter(|ratio| ratio.is_finite()) {
            Some(ratio) => log.value(&name, ratio, "1")?,
            None => log.skipped(&name, "the scene has fewer contacts")?,
        }
    }
    Ok(())
}

fn log_demo(log: &mut MetricLog<Stdout>, printed: &Printed<'_>) -> Result<()> {
    let (cells1, cells2) = (printed.table1.cells(), printed.table2.cells());
    log.value("demo.wall_s", printed.wall_s, "s")?;
    log.value("demo.table1_cells", cells1.measured as f64, "1")?;
    log.value("demo.table2_cells", cells2.measured as f64, "1")?;
    let n_nan = cells1.nan + cells2.nan;
    log.value("demo.nan_cells", n_nan as f64, "1")?;
    let info = &printed.done.compliance.record.info;
    for (name, key, unit) in [
        ("fe.nnz_l", "nnz_l", "1"),
        ("fe.factor_s", "factor_s", "s"),
        ("fe.compliance_s", "compliance_s", "s"),
        ("fe.compliance_rss_gib", "peak_rss_gib", "GiB"),
    ] {
        match info[key].as_f64() {
            Some(value) => log.value(name, value, unit)?,
            None => log.skipped(name, "the stage's record lacks it")?,
        }
    }
    Ok(())
}

/// Tables and verdicts on the terminal.
pub(crate) fn print(report: &Report) {
    for table in &report.tables {
        if table.title == contents::CLAIMS {
            print_claims(&table.text);
        } else {
            println!("\n{}\n{}", table.title, terminal_table(&table.text));
        }
    }
    println!();
}

/// A claim, and a line for each metric: too wide for a table.
fn print_claims(text: &TextTable) {
    for row in &text.rows {
        if let [claim, _, metric, fate, reason] = row.as_slice() {
            if !claim.text.is_empty() {
                println!("\n{}", claim.text);
            }
            println!("  {}: {}; {}", metric.text, fate.text, reason.text);
        }
    }
}
