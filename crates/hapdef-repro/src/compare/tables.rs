//! The comparison as METRIC lines, a table and a page.

use std::path::Path;

use anyhow::Result;
use hapdef::Run;
use hapdef_bench::stats::quantile;
use hapdef_bench::{Measurements, goal_table, log_metrics, publish, table, terminal_table};
use hapdef_report::{Figure, LineChart, NamedText, Report, ReportTable, Series, SkippedStage};

use super::figures::{COLUMNS, GOALS, GOALS_NOTE, METRICS};
use super::measured::Measured;
use crate::run::facts::{self, named};

const NOTE: &str = "Simulated: readings come from the scene's rig, another and perturbed mesh, with \
    noise and converter. Contacts are matched one to one; errors are those of matched contacts, \
    missed and spurious ones stand beside them, and \"within 10 mm\" counts a missed contact as \
    far. By superposition the number of contacts is estimated; the paper's pipeline is given it; with \
    exact virtual gauges it has the nominal limb's displacements under the true contacts in place of \
    what its first net makes of the readings. \
    Doubles: 30 N held, 0–34 N varied, 12–75 mm apart. Triples, quadruples and arrivals: 5 N to the \
    strongest, 20 mm apart. Friction: coefficients uniform in 0–.2 in any direction and a tip 8 mm \
    across, neither seen in calibration; the covariance assumes the friction. Four arriving: the \
    contacts when all have come, a fifth of a second apart, and the time of the last frame; two at once: \
    in pairs; one released: the other three after it; one sliding: ten times while it does, by 20 mm at \
    100 mm/s, and at rest after it.";

/// Rows by superposition that are drawn.
const DRAWN: [&str; 5] =
    ["single", "double", "double, 300 presses", "triple, 16 gauges", "four arriving"];

/// Prints the figures and writes `compare/` under the scene's folder.
pub(super) fn write(run: &Run, out: &Path, test_seed: u64, measured: &Measured) -> Result<()> {
    let mut log = facts::log(test_seed);
    log_metrics(&METRICS, "compare", measured, &mut log)?;
    let table = table(&COLUMNS, &measured.rows);
    println!("{}", terminal_table(&table));
    let study = facts::study(run, "superposition and the paper's pipeline", test_seed)?;
    let report = Report {
        facts: [study.facts, facts_of(test_seed, measured)].concat(),
        tables: vec![
            goal_table(&GOALS, measured, GOALS_NOTE)?,
            ReportTable {
                title: "Contacts, the same frames for all".into(),
                note: NOTE.into(),
                text: table,
                data: serde_json::to_value(&measured.rows)?,
            },
        ],
        figures: vec![errors(measured)?],
        skipped: skipped(measured),
        ..study
    };
    publish(out, "compare", report, &log)?;
    Ok(())
}

/// How far contacts are from their matches, by rising distance; rows by superposition beside the paper's
/// better one.
fn errors(measured: &Measured) -> Result<Figure> {
    let names = DRAWN.into_iter().chain(measured.best_paper.as_deref());
    let series = names.filter_map(|name| {
        let row = measured.row(name)?;
        Some(Series { name: name.to_owned(), points: row.within_mm.clone() })
    });
    let chart = LineChart {
        title: "Position error".into(),
        x_label: "true contacts matched at most so far away, %".into(),
        y_label: "distance, mm".into(),
        log_x: false,
        log_y: true,
        dots: false,
        series: series.collect(),
    };
    Ok(Figure::lines(
        "position-error.svg",
        "Distance of contacts from their matches. A line ends where the rest is missed.",
        &chart,
    )?)
}

fn skipped(measured: &Measured) -> Vec<SkippedStage> {
    let is_without = measured.best_paper.is_none();
    let paper = is_without.then(|| SkippedStage {
        name: "the paper's pipeline".into(),
        reason: "--without-paper".into(),
    });
    paper.into_iter().collect()
}

fn facts_of(test_seed: u64, measured: &Measured) -> Vec<NamedText> {
    let [many, few, none] = measured.map_errors.map(|e| e * 100.0);
    let share_us = |q| quantile(&measured.tracking_us, q);
    vec![
        named(
            "response map",
            format!(
                "relative error at presses it was not calibrated with, their noise included: \
                 {none:.1} % computed, {few:.2} % with 300 presses, {many:.2} % with {}",
                measured.n_presses
            ),
        ),
        named(
            "seeds",
            format!(
                "presses and frames {test_seed}, on which nothing was tuned; the rig's are the scene's"
            ),
        ),
        named(
            "tracking",
            format!(
                "{} frames of {:.1} µs (median), {:.0} µs (99 %), {:.0} µs (99.99 %)",
                measured.tracking_us.len(),
                share_us(0.5),
                share_us(0.99),
                share_us(0.9999)
            ),
        ),
    ]
}
