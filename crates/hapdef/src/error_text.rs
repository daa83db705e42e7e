//! An error and its causes in one line.

use std::error::Error;

use hapdef_contact::printable;

/// The error's text, then the texts of its causes that are not in it already.
#[must_use]
pub fn error_text(error: &(dyn Error + 'static)) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        let words = inner.to_string();
        if !text.contains(&words) {
            text.push_str(": ");
            text.push_str(&words);
        }
        cause = inner.source();
    }
    // What is on further lines stays there, indented: a name with an end of line makes no line of its own.
    let lines: Vec<String> = text.lines().map(|line| printable(line.trim_start())).collect();
    lines.join("\n  ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("reading {0}")]
    struct Quiet(&'static str, #[source] std::io::Error);

    #[derive(Debug, thiserror::Error)]
    #[error("first: {0}")]
    struct Loud(#[source] Quiet);

    #[test]
    fn every_cause_is_said_once() {
        let error = Loud(Quiet("a.json", std::io::Error::other("no such file")));
        assert_eq!(error_text(&error), "first: reading a.json: no such file");
    }
}
