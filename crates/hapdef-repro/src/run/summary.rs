//! What a run prints: metrics for machines, tables and verdicts for people.

use std::io::Stdout;

use anyhow::Result;
use hapdef_bench::terminal_table;
use hapdef_report::{Figure, Headline, MetricLog, Report, Summary, TextTable};

use super::made::Made;
use super::{claims, contents};
use crate::tables::{Claim, PAPER_TABLE2, PaperAccuracy, Table2, TestSet, fnn_over_lr};

/// The metrics of the whole reproduction; `n_cached` stages were in the cache when it began.
pub(crate) fn log_repro(
    log: &mut MetricLog<Stdout>,
    made: &Made<'_>,
    claims: &[Claim],
    n_cached: usize,
    wall_s: f64,
) -> Result<()> {
    let (n_claims, n_held) = claims::count(claims);
    match n_cached {
        0 => log.value("repro.wall_s", wall_s, "s")?,
        n => log.skipped("repro.wall_s", &format!("{n} stages were in the cache"))?,
    }
    log.value("repro.claims", n_claims as f64, "1")?;
    log.value("repro.claims_held", n_held as f64, "1")?;
    for (test, ratio) in TestSet::ALL.into_iter().zip(fnn_over_lr(&made.table1[0])) {
        let name = format!("repro.fnn_over_lr_{}", test.name());
        match ratio.filter(|ratio| ratio.is_finite()) {
            Some(ratio) => log.value(&name, ratio, "1")?,
            None => log.skipped(&name, "the scene has fewer contacts")?,
        }
    }
    Ok(())
}

/// The metrics of the demo.
pub(crate) fn log_demo(
    log: &mut MetricLog<Stdout>,
    made: &Made<'_>,
    table2: &Table2,
    wall_s: f64,
) -> Result<()> {
    let (cells1, cells2) = (made.table1[0].cells(), table2.cells());
    log.value("demo.wall_s", wall_s, "s")?;
    log.value("demo.table1_cells", cells1.measured as f64, "1")?;
    log.value("demo.table2_cells", cells2.measured as f64, "1")?;
    let n_nan = cells1.nan + cells2.nan;
    log.value("demo.nan_cells", n_nan as f64, "1")?;
    let info = &made.done.compliance.record.info;
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

/// The figure that shows most: a double press with what is found. Or the limb, where nothing is pressed twice.
const PICTURES: [&str; 2] = ["figure6b-limb.svg", "rigidity-limb.svg"];

/// What a reader sees first: how many claims hold, errors beside the paper's, the picture, which is taken out
/// of the figures.
pub(crate) fn first(
    profile: &str,
    claims: &[Claim],
    table2: &Table2,
    figures: &mut Vec<Figure>,
) -> Option<Summary> {
    let at = PICTURES.iter().find_map(|name| figures.iter().position(|f| f.file == *name))?;
    let (n_claims, n_held) = claims::count(claims);
    // Whoever opens a quick run's report should not take its errors for those of the method.
    let trained = match profile {
        "quick" => "trained briefly (profile quick)",
        _ => "trained",
    };
    let sentence = format!(
        "The paper's chain of networks, {trained} and tested on this limb, simulated: {n_held} of {n_claims} \
         metrics of the paper's claims hold. How well contacts are found by superposition, which needs no \
         networks, shows cargo xtask demo."
    );
    let headline = |paper: &PaperAccuracy| {
        let ours = table2.ours.iter().find(|ours| ours.name == paper.name)?.location_mm?;
        let beside = format!("the paper's limb: {} mm", paper.location_mm[0]);
        let (value, what) = (format!("{ours:.1} mm"), format!("{}, location", paper.name));
        Some(Headline { value, what, beside })
    };
    let numbers = PAPER_TABLE2.iter().filter_map(headline).collect();
    let next = vec!["What each verdict rests on: docs/report.md".into()];
    Some(Summary { sentence, numbers, picture: Some(figures.remove(at)), next })
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
