//! How a program ends: an error and its causes in one line, exit code 2.

use std::error::Error;
use std::process::ExitCode;

/// Exit code for everything that a person can correct.
const FAILED: u8 = 2;

/// The exit code of a program that ended with `result`; prints the error, if there is one.
#[expect(clippy::print_stderr, reason = "standard error is where a program says what is wrong")]
pub fn exit_code(result: Result<(), Box<dyn Error + Send + Sync>>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", error_text(error.as_ref()));
            ExitCode::from(FAILED)
        }
    }
}

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
    text
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
