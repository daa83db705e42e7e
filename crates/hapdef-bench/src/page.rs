//! A report in Markdown for a page of the documentation: no pictures, no hashes.

use std::fmt::Write as _;

use hapdef_report::Report;

/// The lines of a page behind its heading: scene, facts but those of a `hidden` name, commit and time; tables
/// with their notes; what was left out.
#[must_use]
pub fn page_markdown(report: &Report, hidden: &str) -> String {
    let mut text = format!("- scene: {}\n", report.scene);
    for fact in report.facts.iter().filter(|fact| fact.name != hidden) {
        let _ = writeln!(text, "- {}: {}", fact.name, fact.text);
    }
    if let Some(metric) = report.metrics.first() {
        let context = &metric.context;
        let _ = writeln!(text, "- commit: {}\n- time: {}", context.commit, context.time);
    }
    for table in &report.tables {
        let _ = write!(text, "\n## {}\n\n{}", table.title, table.text.to_markdown());
        if !table.note.is_empty() {
            let _ = writeln!(text, "\n{}", table.note);
        }
    }
    if !report.skipped.is_empty() {
        text.push_str("\n## Left out\n\n");
    }
    for stage in &report.skipped {
        let _ = writeln!(text, "- {}: {}", stage.name, stage.reason);
    }
    text
}
