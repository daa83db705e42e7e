//! Pages of the documentation: a report without pictures and hashes, and what programs make of a page
//! below the words of people.

use std::fmt::Write as _;
use std::io::ErrorKind;
use std::path::Path;

use hapdef_report::{Report, ReportError, write_text};

/// What stands below this line of a page is made by a program.
const MADE: &str = "<!-- made by the command above, from here on -->\n\n";

/// Writes what a program makes of a page; the words above it stay.
///
/// # Errors
/// A file that can't be read or written.
pub fn write_made(path: &Path, made: &str) -> Result<(), ReportError> {
    let old = match std::fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        old => old.map_err(ReportError::io("reading", path))?,
    };
    let words = old.split_once(MADE).map_or("", |(words, _)| words);
    write_text(path, &[words, MADE, made].concat())
}

/// What a program made of a page.
///
/// # Errors
/// A file that can't be read.
pub fn read_made(path: &Path) -> Result<String, ReportError> {
    let text = std::fs::read_to_string(path).map_err(ReportError::io("reading", path))?;
    Ok(text.split_once(MADE).map(|(_, made)| made.to_owned()).unwrap_or(text))
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_of_people_stay() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.md");
        write_made(&page, "new\n").unwrap();
        assert_eq!(read_made(&page).unwrap(), "new\n");
        std::fs::write(&page, format!("# Words\n\n{MADE}old\n")).unwrap();
        write_made(&page, "new\n").unwrap();
        assert_eq!(std::fs::read_to_string(&page).unwrap(), format!("# Words\n\n{MADE}new\n"));
        assert!(write_made(folder.path(), "new\n").is_err());
    }
}
