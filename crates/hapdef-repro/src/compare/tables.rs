//! The comparison as METRIC lines, tables and a page.

use anyhow::Result;
use hapdef_bench::stats::quantile;
use hapdef_bench::{Measurements, Study, dotted_lines, page_table, table};
use hapdef_report::{Figure, LineChart, NamedText, Report, Series, SkippedStage};

use super::figures::{COLUMNS, GOALS, GOALS_NOTE, METRICS, Measured, best_paper};
use super::setup::Bench;
use crate::run::facts::{self, named};

const STUDY: Study<Measured> = Study {
    folder: "compare",
    metrics: &METRICS,
    goals: &GOALS,
    goals_note: GOALS_NOTE,
    file: None,
};

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
pub(super) fn publish(bench: &Bench<'_>, measured: &Measured) -> Result<()> {
    let seed = bench.args.test_seed;
    let rows = table(&COLUMNS, &measured.rows);
    let study = facts::study(bench.run, "superposition and the paper's pipeline", seed)?;
    let report = Report {
        facts: [study.facts, facts_of(bench, measured)].concat(),
        tables: vec![
            STUDY.goal_table(measured)?,
            page_table("Contacts, the same frames for all", NOTE, rows, &measured.rows)?,
        ],
        figures: vec![errors(measured)?],
        skipped: skipped(bench),
        ..study
    };
    STUDY.publish(
        measured,
        report,
        &mut facts::log_of(bench.run, seed),
        &bench.args.scene.results,
    )?;
    Ok(())
}

/// How far contacts are from their matches, by rising distance; rows by superposition beside the paper's
/// better one.
fn errors(measured: &Measured) -> Result<Figure> {
    let names = DRAWN.into_iter().chain(best_paper(measured).map(|row| row.name.as_str()));
    let series = names.filter_map(|name| {
        let row = measured.row(name)?;
        Some(Series { name: name.to_owned(), points: row.within_mm.clone() })
    });
    let labels = ["true contacts matched at most so far away, %", "distance, mm"];
    let chart = dotted_lines("Position error", labels, [false, true], series);
    let chart = LineChart { dots: false, ..chart };
    Ok(Figure::lines(
        "position-error.svg",
        "Distance of contacts from their matches. A line ends where the rest is missed.",
        &chart,
    )?)
}

fn skipped(bench: &Bench<'_>) -> Vec<SkippedStage> {
    let paper = bench.args.without_paper.then(|| SkippedStage {
        name: "the paper's pipeline".into(),
        reason: "--without-paper".into(),
    });
    paper.into_iter().collect()
}

fn facts_of(bench: &Bench<'_>, measured: &Measured) -> Vec<NamedText> {
    let [many, few, none] = measured.map_errors.map(|e| e * 100.0);
    let share_us = |q| quantile(&measured.tracking_us, q);
    vec![
        named(
            "response map",
            format!(
                "relative error at presses it was not calibrated with, their noise included: \
                 {none:.1} % computed, {few:.2} % with 300 presses, {many:.2} % with {}",
                bench.args.presses
            ),
        ),
        named(
            "seeds",
            format!(
                "presses and frames {}, on which nothing was tuned; the rig's are the scene's",
                bench.args.test_seed
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
