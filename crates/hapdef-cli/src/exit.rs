//! How a program ends: an error and its causes in one line, exit code 2.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use hapdef::error_text;
use hapdef_contact::printable;

use crate::note_line;

/// Exit code for everything that a person can correct.
const FAILED: u8 = 2;

/// The exit code of a program that ended with `result`; prints the error, if there is one.
pub fn exit_code(result: Result<(), Box<dyn Error + Send + Sync>>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            note_line(format_args!("error: {}", error_text(error.as_ref())));
            ExitCode::from(FAILED)
        }
    }
}

/// A path as it is printed: its name may have been chosen by somebody else.
pub fn shown(path: impl AsRef<Path>) -> String {
    printable(&path.as_ref().to_string_lossy())
}
