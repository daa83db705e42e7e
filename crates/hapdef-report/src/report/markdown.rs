//! The report as Markdown.

use super::{Report, record_tables};

/// The report as Markdown, pictures by their files.
pub(super) fn page(report: &Report) -> String {
    let mut text = format!("# {}\n", report.title);
    if let Some(summary) = &report.summary {
        text.push_str(&summary.markdown());
    }
    for table in &report.tables {
        text.push_str(&format!("\n## {}\n\n{}", table.title, table.text.to_markdown()));
        if !table.note.is_empty() {
            text.push_str(&format!("\n{}\n", table.note));
        }
    }
    if !report.figures.is_empty() {
        text.push_str("\n## Figures\n");
    }
    for figure in &report.figures {
        text.push_str(&format!("\n![]({})\n\n{}\n", figure.file, figure.caption));
    }
    text.push_str("\n## What this rests on\n\n");
    if !report.scene.is_empty() {
        text.push_str(&format!("- scene: {}\n", report.scene));
    }
    for fact in &report.facts {
        text.push_str(&format!("- {}: {}\n", fact.name, fact.text));
    }
    for (title, table) in record_tables(report) {
        text.push_str(&format!("\n## {title}\n\n{}", table.to_markdown()));
    }
    text
}
