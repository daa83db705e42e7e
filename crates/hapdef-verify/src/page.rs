//! The rows as a report with a page: docs/verification.md to look at.

use hapdef_bench::{Column, table};
use hapdef_report::{
    Figure, Headline, LineChart, NamedText, ReportError, ReportTable, Series, SkippedStage,
    Summary, TextTable,
};
use serde_json::Value;

use crate::table::{ELEMENT, ERROR, REFERENCE, TARGET, VALUE, markdown};
use crate::{CaseReport, Report, Verdict};

/// A problem is plotted where an element was tried on at least so many meshes.
const PLOTTED_MESHES: usize = 3;

/// The cases, the finest mesh of each in a table, convergence as plots; `data` is for machines.
pub fn verification_page(
    report: &Report,
    data: Value,
) -> Result<hapdef_report::Report, ReportError> {
    let counts = [
        ("judged", report.n_judged()),
        ("known misses", report.n_known_misses()),
        ("failed", report.n_failed()),
    ];
    let fact = |(name, n): (&str, usize)| NamedText { name: name.into(), text: n.to_string() };
    let mut figures = convergence(report)?;
    let picture = (!figures.is_empty()).then(|| figures.remove(0));
    Ok(hapdef_report::Report {
        title: "Is the elasticity solver right?".into(),
        summary: Some(first(report, picture)),
        facts: counts.map(fact).into(),
        tables: vec![ReportTable {
            title: "Cases, each on its finest mesh".into(),
            note: "Errors are relative to the reference; docs/verification.md says what is compared and \
                   where the reference stands, and lists every mesh."
                .into(),
            text: cases_table(report),
            data,
        }],
        figures,
        skipped: not_run(report),
        hashes: vec![NamedText::hash_of("table", &markdown(report))],
        ..hapdef_report::Report::default()
    })
}

/// What a reader sees first.
fn first(report: &Report, picture: Option<Figure>) -> Summary {
    let (n, n_failed) = (report.n_judged(), report.n_failed());
    let n_known = report.n_known_misses();
    let sentence = format!(
        "{} of {n} published benchmarks, closed forms and other programs' results are met; {n_known} are missed for \
         reasons that are known, {n_failed} for none.",
        n - n_failed - n_known
    );
    let worst = report.worst().map(|error| Headline {
        value: format!("{:.2} %", 100.0 * error),
        what: "largest error".into(),
        beside: "of a judged case, on its finest mesh".into(),
    });
    let count = |n: usize, what: &str, beside: &str| Headline {
        value: n.to_string(),
        what: what.into(),
        beside: beside.into(),
    };
    let judged = count(n, "cases judged", "each against a reference of its own");
    let failed = count(n_failed, "failed", "must be none");
    let numbers = [Some(judged), Some(failed), worst].into_iter().flatten().collect();
    Summary { sentence, numbers, picture, next: Vec::new() }
}

/// Cases that were not run, and why.
fn not_run(report: &Report) -> Vec<SkippedStage> {
    let skipped = report.cases.iter().filter_map(|report| match &report.verdict {
        Verdict::NotRun(reason) => {
            Some(SkippedStage { name: report.case.id(), reason: reason.clone() })
        }
        _ => None,
    });
    skipped.collect()
}

const COLUMNS: [Column<CaseReport>; 10] = [
    Column::new("case", |r| r.case.id()),
    Column::new("problem", |r| r.case.title.into()),
    ELEMENT,
    Column::new("unit", |r| r.case.unit.into()),
    REFERENCE,
    VALUE,
    ERROR,
    TARGET,
    Column::new("verdict", |r| r.verdict.word().into()),
    Column::new("why", |r| r.verdict.why().into()),
];

/// The cases; a verdict of those that pass stands out.
fn cases_table(report: &Report) -> TextTable {
    let mut text = table(&COLUMNS, &report.cases);
    for (row, case) in text.rows.iter_mut().zip(&report.cases) {
        row[8].strong = case.verdict == Verdict::Pass;
    }
    text
}

/// Error against equations, a plot for each problem.
fn convergence(report: &Report) -> Result<Vec<Figure>, ReportError> {
    let mut problems: Vec<(&str, Vec<Series>)> = Vec::new();
    for CaseReport { case, rows, .. } in &report.cases {
        let point = |row: &crate::Row| {
            let error = row.rel_err.filter(|e| *e > 0.0)?;
            Some((row.measured.n_equations as f64, error))
        };
        let points: Vec<(f64, f64)> = rows.iter().filter_map(point).collect();
        if points.len() < PLOTTED_MESHES {
            continue;
        }
        let name = format!("{} {}", case.element.word(), case.quantity);
        let series = Series { name, points };
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
