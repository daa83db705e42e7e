//! The comparison as METRIC lines, a table and a page.

use std::path::Path;

use anyhow::Result;
use hapdef::Run;
use hapdef_bench::stats::quantile;
use hapdef_report::{
    Figure, LineChart, MetricLog, NamedText, Report, ReportTable, Series, SkippedStage, TextCell,
    TextTable, write_report,
};

use super::run::{Measured, double_vs_paper, time_vs_paper};
use super::score::Row;
use super::targets;
use crate::run::facts;
use hapdef_bench::terminal_table;

const NOTE: &str = "Simulated: readings come from the scene's rig, another and perturbed mesh, with \
    noise and converter. Contacts are matched one to one; errors are those of matched contacts, \
    missed and spurious ones stand beside them, and \"within 10 mm\" counts a missed contact as \
    far. By superposition the number of contacts is estimated; the paper's pipeline is given it; with \
    exact virtual gauges it has the nominal limb's displacements under the true contacts in place of \
    what its first net makes of the readings. \
    Doubles: 30 N held, 0–34 N varied, 12–75 mm apart. Triples, quadruples and arrivals: 5 N to the \
    strongest, 20 mm apart. Friction: coefficients uniform in 0–.2 in any direction and a tip 8 mm \
    across, neither seen in calibration; the covariance is told the friction. Four arriving: the \
    contacts when all have come, a fifth of a second apart, and the time of the last frame; two at once: \
    in pairs; one released: the other three after it; one sliding: ten times while it does, by 20 mm at \
    100 mm/s, and at rest after it.";

/// Rows by superposition that are drawn.
const DRAWN: [&str; 5] =
    ["single", "double", "double, 300 presses", "triple, 16 gauges", "four arriving"];

/// Prints the figures and writes `compare/` under the scene's folder.
pub(super) fn write(run: &Run, out: &Path, test_seed: u64, measured: &Measured) -> Result<()> {
    let mut log = MetricLog::new(std::io::stdout(), facts::metric_context_of(test_seed));
    metrics(measured, &mut log)?;
    let table = table(measured);
    println!("{}", terminal_table(&table));
    let report = Report {
        title: format!("hapdef: superposition and the paper's pipeline, {}", run.scene.name),
        scene: run.scene.name.clone(),
        facts: facts_of(run, test_seed, measured),
        tables: vec![
            targets::table(measured)?,
            ReportTable {
                title: "Contacts, the same frames for all".into(),
                note: NOTE.into(),
                text: table,
                data: serde_json::to_value(&measured.rows)?,
            },
        ],
        figures: vec![errors(measured)?],
        metrics: log.records().to_vec(),
        seed: test_seed,
        skipped: skipped(measured),
        hashes: facts::input_hashes(run)?,
        ..Report::default()
    };
    let paths = write_report(&out.join(&run.scene.name).join("compare"), &report)?;
    log.append_to(&out.join("metrics.json"))?;
    for path in paths.iter().rev().take(3) {
        println!("{}", path.display());
    }
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

/// The names of the project's list of metrics.
fn metrics(measured: &Measured, log: &mut MetricLog<std::io::Stdout>) -> Result<()> {
    type Figure = (&'static str, &'static str, fn(&Row) -> f64, &'static str);
    let figures: [Figure; 14] = [
        ("single_mean_mm", "single", |r| r.mean_mm, "mm"),
        ("single_median_mm", "single", |r| r.median_mm, "mm"),
        ("single_mean_n", "single", |r| r.mean_n, "N"),
        ("double_mean_mm", "double", |r| r.mean_mm, "mm"),
        ("double_median_mm", "double", |r| r.median_mm, "mm"),
        ("double_mean_n", "double", |r| r.mean_n, "N"),
        ("double_within10_pct", "double", |r| r.within10_pct, "%"),
        ("double_count_pct", "double", |r| r.count_pct, "%"),
        ("double300_mean_mm", "double, 300 presses", |r| r.mean_mm, "mm"),
        ("friction_double_mean_mm", "double, friction and wide tip", |r| r.mean_mm, "mm"),
        ("triple16_mean_mm", "triple, 16 gauges", |r| r.mean_mm, "mm"),
        ("sequential4_mean_mm", "four arriving", |r| r.mean_mm, "mm"),
        ("sequential4_mean_n", "four arriving", |r| r.mean_n, "N"),
        ("sequential4_found_pct", "four arriving", |r| r.within10_pct, "%"),
    ];
    let mut number = |name: &str, value: Option<f64>, unit: &str, why: &str| -> Result<()> {
        let name = format!("compare.{name}");
        match value.filter(|v| v.is_finite()) {
            Some(value) => Ok(log.value(&name, value, unit)?),
            None => Ok(log.skipped(&name, why)?),
        }
    };
    for (name, row, of, unit) in figures {
        number(name, measured.row(row).map(of), unit, "no such row")?;
    }
    number("coverage95_pct", measured.coverage95_pct, "%", "no frame was sure")?;
    let why = "at no contact does the noise's bound exceed the map's error";
    number("bound_ratio", measured.bound_ratio, "1", why)?;
    let why = "--without-paper";
    number("double_vs_paper", double_vs_paper(measured), "1", why)?;
    number("time_vs_paper", time_vs_paper(measured), "1", why)
}

fn facts_of(run: &Run, test_seed: u64, measured: &Measured) -> Vec<NamedText> {
    let mut facts = facts::of_run(run);
    let named = |name: &str, text: String| NamedText { name: name.into(), text };
    let [many, few, none] = measured.map_errors.map(|e| e * 100.0);
    facts.push(named(
        "response map",
        format!(
            "relative error at presses it was not calibrated with, their noise included: {none:.1} \
             % computed, {few:.2} % with 300 presses, {many:.2} % with {}",
            measured.n_presses
        ),
    ));
    facts.push(named(
        "seeds",
        format!(
            "presses and frames {test_seed}, on which nothing was tuned; the rig's are the scene's"
        ),
    ));
    let share_us = |q| quantile(&measured.tracking_us, q);
    facts.push(named(
        "tracking",
        format!(
            "{} frames of {:.1} µs (median), {:.0} µs (99 %), {:.0} µs (99.99 %)",
            measured.tracking_us.len(),
            share_us(0.5),
            share_us(0.99),
            share_us(0.9999)
        ),
    ));
    facts
}

fn table(measured: &Measured) -> TextTable {
    let header = [
        "frames of",
        "n",
        "mean, mm",
        "median",
        "90 %",
        "within 10 mm",
        "mean, N",
        "missed",
        "spurious",
        "count right",
        "clean",
        "unsure",
        "in 95 %",
        "p50, µs",
        "p99, µs",
    ];
    let row = |r: &Row| {
        let percent = |v: f64| format!("{v:.1} %");
        let cells = [
            r.name.clone(),
            r.n_frames.to_string(),
            format!("{:.2}", r.mean_mm),
            format!("{:.2}", r.median_mm),
            format!("{:.2}", r.p90_mm),
            percent(r.within10_pct),
            format!("{:.2}", r.mean_n),
            percent(r.missed_pct),
            percent(r.spurious_pct),
            percent(r.count_pct),
            percent(r.clean_pct),
            percent(r.unsure_pct),
            r.coverage95_pct.map_or("–".into(), percent),
            format!("{:.0}", r.p50_us),
            format!("{:.0}", r.p99_us),
        ];
        cells.map(TextCell::plain).to_vec()
    };
    TextTable {
        header: header.map(str::to_owned).to_vec(),
        rows: measured.rows.iter().map(row).collect(),
    }
}
