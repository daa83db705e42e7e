//! `hapdef-verify verify`: the table.

use std::path::PathBuf;

use anyhow::{Result, bail};
use hapdef_bench::{read_made, write_made};
use hapdef_report::MetricLog;

use super::context::{MetricsArgs, write_page};
use crate::cases::all_cases;
use crate::check::differences;
use crate::page::verification_page;
use crate::run::run_cases;
use crate::table::{markdown, people_table};
use crate::{CaseReport, Report, Verdict};

/// Arguments of `verify`.
#[derive(clap::Args)]
pub(crate) struct VerifyArgs {
    /// Only the cases whose id contains this; may be given more than once.
    #[arg(long)]
    only: Vec<String>,
    /// Write the table to this file.
    #[arg(long)]
    write: Option<PathBuf>,
    /// Compare the table with this file; fail where they differ.
    #[arg(long, conflicts_with = "write")]
    check: Option<PathBuf>,
    /// Print the rows as one JSON array instead of text.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    output: MetricsArgs,
}

/// Solves, prints and judges; false where a row missed its target.
pub(crate) fn run(args: &VerifyArgs) -> Result<bool> {
    let mut cases = all_cases();
    let wanted = |id: &str| args.only.is_empty() || args.only.iter().any(|word| id.contains(word));
    cases.retain(|case| wanted(&case.id()));
    if cases.is_empty() {
        bail!("no case has an id with {:?}; without --only all are listed", args.only);
    }
    let report = run_cases(&cases, |case| {
        if !args.json {
            print!("{}", people_table(case));
        }
    });
    let data = json(&report);
    if args.json {
        println!("{data}");
    }
    if let Some(path) = &args.write {
        write_made(path, &markdown(&report))?;
    }
    let log = metrics(args, &report)?;
    let page = verification_page(&report, data)?;
    write_page(page, &log, &args.output.metrics, "verify")?;
    Ok(agrees(args, &report)? && report.n_failed() == 0)
}

/// Whether the file of `--check` has the report's numbers.
fn agrees(args: &VerifyArgs, report: &Report) -> Result<bool> {
    let Some(path) = &args.check else {
        return Ok(true);
    };
    let faults = differences(report, &read_made(path)?, &all_cases());
    for fault in &faults {
        eprintln!("{}: {fault}", path.display());
    }
    Ok(faults.is_empty())
}

/// One object per mesh of each case; a case that was not run has one with the reason.
fn json(report: &Report) -> serde_json::Value {
    let rows = report.cases.iter().flat_map(|CaseReport { case, rows, verdict }| {
        rows.iter().map(|row| {
            serde_json::json!({
                "case": case.id(),
                "mesh": row.measured.mesh,
                "nodes": row.measured.n_nodes,
                "equations": row.measured.n_equations,
                "value": row.measured.value,
                "unit": case.unit,
                "reference": case.reference.value(),
                "rel_err": row.rel_err,
                "order": row.order,
                "elapsed_s": row.elapsed_s,
                "verdict": verdict.word(),
            })
        })
    });
    let not_run =
        report.cases.iter().filter_map(|CaseReport { case, verdict, .. }| match verdict {
            Verdict::NotRun(reason) => Some(serde_json::json!({
                "case": case.id(),
                "verdict": verdict.word(),
                "reason": reason,
            })),
            _ => None,
        });
    rows.chain(not_run).collect()
}

fn metrics(args: &VerifyArgs, report: &Report) -> Result<MetricLog<std::io::Stdout>> {
    let mut log = args.output.log();
    log.value("verify.rows", report.n_judged() as f64, "1")?;
    log.value("verify.known_misses", report.n_known_misses() as f64, "1")?;
    log.value("verify.failed", report.n_failed() as f64, "1")?;
    match report.worst() {
        Some(error) if error.is_finite() => log.value("verify.worst_rel_err", error, "1")?,
        _ => log.skipped("verify.worst_rel_err", "no row has an error that is a number")?,
    }
    log.append_to(&args.output.metrics)?;
    Ok(log)
}
