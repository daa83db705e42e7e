//! A report against the committed docs/verification.md.

use std::collections::{BTreeMap, BTreeSet};

use crate::table::markdown;
use crate::{Case, Reference, Report, Verdict};

/// Values in the file have five digits; this is one unit in the last of the shortest.
const VALUE_TOLERANCE: f64 = 1.1e-4;

/// Errors below this move with the machine's rounding and with the file's digits.
const SMALL_ERROR: f64 = 1e-6;

/// Where the committed text and the report disagree, one sentence each; none where they agree.
///
/// Cases that were not run here are not compared. `all` are the cases the file should have.
pub fn differences(report: &Report, committed: &str, all: &[Case]) -> Vec<String> {
    let written = sections(committed);
    let fresh = markdown(report);
    let fresh = sections(&fresh);
    let mut faults = Vec::new();
    for case in &report.cases {
        if case.case.reference == Reference::Reported || matches!(case.verdict, Verdict::NotRun(_))
        {
            continue;
        }
        let id = case.case.id();
        match (fresh.get(id.as_str()), written.get(id.as_str())) {
            (Some(fresh), Some(written)) => compare(&id, fresh, written, &mut faults),
            _ => faults.push(format!("{id}: not in the file")),
        }
    }
    let known: BTreeSet<String> = all.iter().map(Case::id).collect();
    let stale = written.keys().filter(|id| !known.contains(**id));
    faults.extend(stale.map(|id| format!("{id}: in the file, but no case any more")));
    faults
}

type Section<'a> = Vec<&'a str>;

/// The lines below each `### id` heading.
fn sections(text: &str) -> BTreeMap<&str, Section<'_>> {
    let mut sections: BTreeMap<&str, Section<'_>> = BTreeMap::new();
    let mut current = None;
    for line in text.lines() {
        if let Some(id) = line.strip_prefix("### ") {
            current = Some(id);
            sections.insert(id, Vec::new());
        } else if let Some(lines) = current.and_then(|id| sections.get_mut(id))
            && !line.trim().is_empty()
        {
            lines.push(line);
        }
    }
    sections
}

fn compare(id: &str, fresh: &Section<'_>, written: &Section<'_>, faults: &mut Vec<String>) {
    if fresh.len() != written.len() {
        let (n, m) = (fresh.len(), written.len());
        faults.push(format!("{id}: {n} lines are expected, the file has {m}"));
        return;
    }
    for (fresh, written) in fresh.iter().zip(written) {
        let row = fresh.starts_with('|');
        if !(fresh == written || row && same_row(fresh, written)) {
            faults.push(format!("{id}: expected {fresh:?}, the file has {written:?}"));
        }
    }
}

/// Rows agree where mesh and sizes are the same and values to the digits that hold everywhere.
/// Error and order follow from the values.
fn same_row(a: &str, b: &str) -> bool {
    let cells = |row: &str| row.split('|').map(|c| c.trim().to_owned()).collect::<Vec<_>>();
    let (a, b) = (cells(a), cells(b));
    let ([_, mesh, nodes, equations, value, ..], [_, mesh_b, nodes_b, equations_b, value_b, ..]) =
        (a.as_slice(), b.as_slice())
    else {
        return false;
    };
    (mesh, nodes, equations) == (mesh_b, nodes_b, equations_b) && same_value(value, value_b)
}

fn same_value(a: &str, b: &str) -> bool {
    let number = |word: &str| {
        if word == "round-off" { Some(0.0) } else { word.parse().ok() }
    };
    let (Some(a), Some(b)): (Option<f64>, Option<f64>) = (number(a), number(b)) else {
        return a == b;
    };
    let size = a.abs().max(b.abs());
    size < SMALL_ERROR || (a - b).abs() <= size * VALUE_TOLERANCE || is_two_digits(a, b)
}

/// Whether two errors of three digits agree to one unit in their last digit.
fn is_two_digits(a: f64, b: f64) -> bool {
    let size = a.abs().max(b.abs());
    size < 0.1 && (a - b).abs() <= size * 1.1e-2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(a: &str, b: &str, same: bool) {
        assert_eq!(same_row(a, b), same, "{a} {b}");
    }

    #[test]
    fn rows_agree_to_their_digits() {
        let row = "| 4 cells | 10 | 20 | 92.485 | 0.23 % | 1.5 |";
        check(row, row, true);
        check(row, "| 4 cells | 10 | 20 | 92.486 | 0.24 % | 1.4 |", true);
        check(row, "| 4 cells | 10 | 20 | 92.585 | 0.12 % | 1.5 |", false);
        check(row, "| 4 cells | 10 | 21 | 92.485 | 0.23 % | 1.5 |", false);
        check("| m | 1 | 1 | round-off | | |", "| m | 1 | 1 | 3.1e-8 | | |", true);
        check("| m | 1 | 1 | round-off | | |", "| m | 1 | 1 | 3.1e-3 | | |", false);
    }
}
