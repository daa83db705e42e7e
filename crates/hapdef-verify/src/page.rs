//! The rows as a report with a page: docs/verification.md to look at.

use hapdef_report::{
    Figure, LineChart, NamedText, ReportError, ReportTable, Series, SkippedStage, TextCell,
    TextTable,
};
use serde_json::Value;

use crate::table::{against, error, markdown, target, value};
use crate::{CaseReport, Report, Verdict};

/// A problem is plotted where an element was tried on at least so many meshes.
const PLOTTED_MESHES: usize = 3;

/// The cases, the finest mesh of each in a table, convergence as plots; `data` is for machines.
///
/// # Errors
/// A plot that can't be drawn.
pub fn verification_page(
    report: &Report,
    data: Value,
) -> Result<hapdef_report::Report, ReportError> {
    let counts = [
        ("judged", report.n_judged()),
        ("known misses", report.n_known_misses()),
        ("failed", report.n_failed()),
    ];
    Ok(hapdef_report::Report {
        title: "Is the elasticity solver right?".into(),
        facts: facts(&counts),
        tables: vec![ReportTable {
            title: "Cases, each on its finest mesh".into(),
            note: "Errors are relative to the reference; docs/verification.md says what is compared and \
                   where the reference stands, and lists every mesh."
                .into(),
            text: cases_table(report),
            data,
        }],
        figures: convergence(report)?,
        skipped: not_run(report),
        hashes: vec![NamedText::hash_of("table", &markdown(report))],
        ..hapdef_report::Report::default()
    })
}

/// Cases that were not run, and why.
fn not_run(report: &Report) -> Vec<SkippedStage> {
    let skipped = report.cases.iter().filter_map(|case| match &case.verdict {
        Verdict::NotRun(reason) => {
            Some(SkippedStage { name: case.id.to_string(), reason: reason.clone() })
        }
        _ => None,
    });
    skipped.collect()
}

fn facts(counts: &[(&str, usize)]) -> Vec<NamedText> {
    let fact = |(name, n): &(&str, usize)| NamedText { name: (*name).into(), text: n.to_string() };
    counts.iter().map(fact).collect()
}

fn cases_table(report: &Report) -> TextTable {
    let header = [
        "case",
        "problem",
        "element",
        "unit",
        "reference",
        "value",
        "error",
        "target",
        "verdict",
        "why",
    ];
    let row = |case: &CaseReport| {
        let finest = case.rows.last();
        let why = match &case.verdict {
            Verdict::KnownMiss(why) | Verdict::Fail(why) | Verdict::NotRun(why) => why.clone(),
            Verdict::Pass | Verdict::Reported => String::new(),
        };
        let is_good = case.verdict == Verdict::Pass;
        cells(
            [
                case.id.into(),
                case.title.into(),
                case.element.into(),
                case.unit.into(),
                against(case.reference),
                finest.map_or("–".into(), |row| value(case.reference, row.measured.value)),
                finest.map_or("–".into(), error),
                target(case),
                case.verdict.word().into(),
                why,
            ],
            is_good.then_some(8),
        )
    };
    TextTable {
        header: header.map(str::to_owned).to_vec(),
        rows: report.cases.iter().map(row).collect(),
    }
}

/// Cells of a row; the one at `strong` stands out.
fn cells<const N: usize>(texts: [String; N], strong: Option<usize>) -> Vec<TextCell> {
    let cell = |(at, text)| TextCell { text, strong: strong == Some(at) };
    texts.into_iter().enumerate().map(cell).collect()
}

/// Error against equations, a plot for each problem.
fn convergence(report: &Report) -> Result<Vec<Figure>, ReportError> {
    let mut problems: Vec<(&str, Vec<Series>)> = Vec::new();
    for case in &report.cases {
        let point = |row: &crate::Row| {
            let error = row.rel_err.filter(|e| *e > 0.0)?;
            Some((row.measured.n_equations as f64, error))
        };
        let points: Vec<(f64, f64)> = case.rows.iter().filter_map(point).collect();
        if points.len() < PLOTTED_MESHES {
            continue;
        }
        let series = Series { name: format!("{} {}", case.element, case.quantity), points };
        match problems.iter_mut().find(|(title, _)| *title == case.title) {
            Some((_, all)) => all.push(series),
            None => problems.push((case.title, vec![series])),
        }
    }
    let figure = |(i, (title, series)): (usize, (&str, Vec<Series>))| {
        let chart = LineChart {
            title: title.into(),
            x_label: "equations".into(),
            y_label: "relative error".into(),
            log_x: true,
            log_y: true,
            dots: true,
            series,
        };
        Figure::lines(
            format!("convergence-{i}.svg"),
            format!("{title}: error against equations."),
            &chart,
        )
    };
    problems.into_iter().enumerate().map(figure).collect()
}
