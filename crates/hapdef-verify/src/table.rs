//! The report as a table for people and as docs/verification.md.

use std::fmt::Write as _;

use hapdef_bench::{Column, or_dash, table, terminal_table};

use crate::{Case, CaseReport, Reference, Report, Row, Verdict};

/// Relative errors below this are round-off and differ from machine to machine.
const ROUND_OFF: f64 = 1e-9;

/// The meshes of a case; times depend on the machine.
const MESHES: [Column<Row>; 7] = [
    Column::new("mesh", |row| row.measured.mesh.clone()),
    Column::new("nodes", |row| row.measured.n_nodes.to_string()),
    Column::new("equations", |row| row.measured.n_equations.to_string()),
    Column::new("value", value),
    Column::new("error", error),
    Column::new("order", order),
    Column::new("seconds", |row| format!("{:.2}", row.elapsed_s)),
];

const SUMMARY: [Column<CaseReport>; 8] = [
    Column::new("case", |r| format!("[{}](#{})", r.case.title, anchor(&r.case))),
    ELEMENT,
    VALUE,
    REFERENCE,
    ERROR,
    Column::new("order", |r| finest(r, order)),
    TARGET,
    Column::new("verdict", |r| r.verdict.word().to_owned()),
];

pub(crate) const ELEMENT: Column<CaseReport> =
    Column::new("element", |r| r.case.element.word().to_owned());
pub(crate) const VALUE: Column<CaseReport> = Column::new("value", |r| finest(r, value));
pub(crate) const REFERENCE: Column<CaseReport> =
    Column::new("reference", |r| against(r.case.reference));
pub(crate) const ERROR: Column<CaseReport> = Column::new("error", |r| finest(r, error));
pub(crate) const TARGET: Column<CaseReport> = Column::new("target", |r| target(&r.case));

/// What stands of the finest mesh.
fn finest(report: &CaseReport, text: fn(&Row) -> String) -> String {
    or_dash(report.rows.last().map(text))
}

/// A case and its meshes for a terminal, with times.
pub fn people_table(report: &CaseReport) -> String {
    let CaseReport { case, rows, verdict } = report;
    let (id, element, unit) = (case.id(), case.element.word(), unit(case.unit));
    let against = against(case.reference);
    let mut text = format!(
        "{} {id} [{element}]: {}, {unit}, reference {against}\n",
        verdict.word(),
        case.title
    );
    if !rows.is_empty() {
        let _ = writeln!(text, "{}", terminal_table(&table(&MESHES, rows)));
    }
    if !verdict.why().is_empty() {
        let _ = writeln!(text, " {}", verdict.why());
    }
    text
}

/// What docs/verification.md says of the cases.
pub fn markdown(report: &Report) -> String {
    let mut text = format!(
        "{} cases are judged, {} of them miss their target for a known reason, {} fail; {} were not run.\n\n",
        report.n_judged(),
        report.n_known_misses(),
        report.n_failed(),
        report.count(|verdict| matches!(verdict, Verdict::NotRun(_)))
    );
    known_misses(&mut text, report);
    let shown = || report.cases.iter().filter(|case| committed(case));
    text.push_str(&table(&SUMMARY, shown()).to_markdown());
    text.push_str("\n## Meshes\n");
    for case in shown() {
        details(&mut text, case);
    }
    text
}

fn known_misses(text: &mut String, report: &Report) {
    if report.n_known_misses() == 0 {
        return;
    }
    text.push_str(
        "Known misses; CI fails if one grows, and if one vanishes until its mark is gone:\n\n",
    );
    for CaseReport { case, rows, verdict } in &report.cases {
        if let (Verdict::KnownMiss(why), Some(last)) = (verdict, rows.last()) {
            let (element, anchor) = (case.element.word(), anchor(case));
            let (error, target) = (error(last), target(case));
            let _ = writeln!(
                text,
                "- [{}, {element}](#{anchor}): {error} against a target of {target}: {why}.",
                case.title
            );
        }
    }
    text.push('\n');
}

/// The heading's place in the page.
fn anchor(case: &Case) -> String {
    case.id().replace('.', "")
}

/// Reported values depend on the machine.
fn committed(report: &CaseReport) -> bool {
    report.case.reference != Reference::Reported
}

fn details(text: &mut String, CaseReport { case, rows, verdict }: &CaseReport) {
    let Case { title, quantity, source, .. } = case;
    let (id, unit, against) = (case.id(), unit(case.unit), against(case.reference));
    let _ = writeln!(text, "\n### {id}\n\n{title}: {quantity}, {unit}.");
    let _ = writeln!(text, "Reference {against}: {source}.\n");
    let _ = match verdict {
        Verdict::Fail(reason) => writeln!(text, "**Misses its target**: {reason}.\n"),
        Verdict::KnownMiss(why) => writeln!(text, "Misses its target (known): {why}.\n"),
        Verdict::NotRun(reason) => writeln!(text, "Not run: {reason}."),
        Verdict::Pass | Verdict::Reported => Ok(()),
    };
    if !rows.is_empty() {
        text.push_str(&table(&MESHES[..6], rows).to_markdown());
    }
}

fn unit(unit: &str) -> String {
    if unit == "1" { "no unit".to_owned() } else { format!("in {unit}") }
}

fn value(row: &Row) -> String {
    let value = row.measured.value;
    match row.reference {
        Reference::Zero if value.abs() < ROUND_OFF => "round-off".to_owned(),
        Reference::Zero => format!("{value:.2e}"),
        _ => digits(value),
    }
}

fn against(reference: Reference) -> String {
    match reference {
        Reference::Exact(r) | Reference::Published(r) => digits(r),
        Reference::Zero => "0".to_owned(),
        Reference::Reported => "–".to_owned(),
    }
}

/// Five significant digits.
fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) {
        let before = if size >= 1.0 { size.log10().floor() as usize + 1 } else { 0 };
        let leading = if size < 1.0 && size > 0.0 { (-size.log10()).floor() as usize } else { 0 };
        format!("{value:.*}", (5 + leading).saturating_sub(before))
    } else {
        format!("{value:.4e}")
    }
}

fn error(row: &Row) -> String {
    or_dash(row.rel_err.map(|e| match e {
        e if e < ROUND_OFF => "round-off".to_owned(),
        e if e < 1e-4 => format!("{e:.1e}"),
        e => format!("{:.2} %", e * 100.0),
    }))
}

fn order(row: &Row) -> String {
    or_dash(row.order.map(|order| format!("{order:.1}")))
}

fn target(case: &Case) -> String {
    let error = case.target.rel_err;
    let percent =
        if error < 1e-3 { format!("{error:.0e}") } else { format!("{} %", error * 100.0) };
    match case.target.order {
        Some(order) => format!("{percent}, order ≥ {order}"),
        None => percent,
    }
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn five_digits_whatever_the_size() {
        let shown = [-5.38, 0.0321, 92.7, 1.8248e-5, 0.0, 123456.0].map(digits);
        assert_eq!(shown, ["-5.3800", "0.032100", "92.700", "1.8248e-5", "0.00000", "123456"]);
    }
}
