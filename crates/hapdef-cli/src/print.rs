//! What a program prints, in one place: text from outside commands no terminal, and a reader that has enough is
//! no error.

use std::fmt::Arguments;
use std::io::{Error, ErrorKind, IsTerminal, Write};
use std::sync::Mutex;

use hapdef_contact::{printable, printable_lines};
use serde::Serialize;

/// Bytes of lines that wait for standard output.
const MOST_WAITING: usize = 8 << 10;

/// Why standard output took no more.
static FAULT: Mutex<Option<Error>> = Mutex::new(None);

/// Prints lines on standard output. What is not plainly printable is shown by its escape; names from outside,
/// whose ends of lines would make lines of their own, go through [`printable`] before.
pub fn print_line(text: Arguments<'_>) {
    put(&printable_lines(&text.to_string()));
}

/// Prints a value as JSON on standard output, `is_pretty` over several lines.
///
/// # Errors
/// A key that is no text.
pub fn print_json(value: &impl Serialize, is_pretty: bool) -> serde_json::Result<()> {
    let as_text = if is_pretty { serde_json::to_string_pretty } else { serde_json::to_string };
    put(&plain_json(&as_text(value)?));
    Ok(())
}

/// Lines of JSON on their way to `0`, each written whole, shown as [`print_json`] shows them.
pub struct JsonLines<W>(pub W);

impl<W: Write> Write for JsonLines<W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Error> {
        match std::str::from_utf8(bytes) {
            Ok(text) if !bytes.is_ascii() || bytes.contains(&0x7f) => {
                self.0.write_all(plain_json(text).as_bytes())?;
            }
            _ => self.0.write_all(bytes)?,
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Error> {
        self.0.flush()
    }
}

/// Standard output for what is written as it is, from any thread. Its faults say that they are its own.
pub struct StandardOutput;

impl Write for StandardOutput {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Error> {
        std::io::stdout().write(bytes).map_err(own)
    }

    fn flush(&mut self) -> Result<(), Error> {
        std::io::stdout().flush().map_err(own)
    }
}

impl StandardOutput {
    /// Whether a person reads it at a terminal.
    #[must_use]
    pub fn is_terminal(&self) -> bool {
        std::io::stdout().is_terminal()
    }
}

/// Standard output for whole lines, which wait until there are some or [`Write::flush`] wants them out: those of
/// several writers never mix.
#[derive(Default)]
pub struct StandardLines {
    waiting: Vec<u8>,
}

impl Write for StandardLines {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Error> {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= MOST_WAITING {
            self.hand_over()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Error> {
        self.hand_over()?;
        StandardOutput.flush()
    }
}

impl StandardLines {
    /// A line that has not ended goes on waiting.
    fn hand_over(&mut self) -> Result<(), Error> {
        let n_whole = self.waiting.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        let written = std::io::stdout().lock().write_all(&self.waiting[..n_whole]);
        self.waiting.drain(..n_whole);
        written.map_err(own)
    }
}

/// Whether `error` comes of who reads standard output having closed it, as `head` does; a device or a file that is
/// gone is something else.
#[must_use]
pub fn is_end_of_reader(error: &(dyn std::error::Error + 'static)) -> bool {
    std::iter::successors(Some(error), |error| error.source()).any(|cause| {
        let io = cause.downcast_ref::<Error>();
        io.is_some_and(|io| io.kind() == ErrorKind::BrokenPipe && is_own(io))
    })
}

/// Prints lines on standard error, as [`print_line`] does. Where nobody reads them there is nobody to say it to.
pub fn note_line(text: Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "{}", printable_lines(&text.to_string()));
}

/// What was printed has reached who reads it, or they wanted no more.
///
/// # Errors
/// Standard output could not be written.
pub fn check_printed() -> Result<(), Error> {
    // A fault is kept, the first of all is the one to tell.
    let _ = StandardOutput.flush();
    FAULT.lock().map_or(None, |mut fault| fault.take()).map_or(Ok(()), Err)
}

/// A fault of standard output.
#[derive(Debug, thiserror::Error)]
#[error("standard output: {0}")]
struct OutputFault(Error);

fn put(text: &str) {
    // The fault is kept, and the work goes on.
    let _ = writeln!(StandardOutput, "{text}");
}

/// A fault of standard output as such; the first is kept, unless the reader has closed its end: it has enough.
fn own(error: Error) -> Error {
    let marked = |error: &Error| {
        let same = error.raw_os_error().map_or(error.kind().into(), Error::from_raw_os_error);
        Error::new(error.kind(), OutputFault(same))
    };
    if let Ok(mut fault) = FAULT.lock()
        && error.kind() != ErrorKind::BrokenPipe
    {
        fault.get_or_insert_with(|| marked(&error));
    }
    marked(&error)
}

fn is_own(error: &Error) -> bool {
    error.get_ref().is_some_and(|inner| inner.is::<OutputFault>())
}

/// JSON whose strings have escapes where [`printable`] has them; serde_json makes some of these only.
fn plain_json(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut units = [0; 2];
    for letter in text.chars() {
        let is_plain =
            letter == '\n' || printable(letter.encode_utf8(&mut [0; 4])).len() == letter.len_utf8();
        if is_plain {
            shown.push(letter);
            continue;
        }
        for unit in letter.encode_utf16(&mut units) {
            shown.push_str(&format!("\\u{unit:04x}"));
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("writing a table")]
    struct Outer(#[source] Error);

    #[test]
    fn only_a_reader_of_standard_output_that_has_enough_is_no_error() {
        let broken = || Error::from(ErrorKind::BrokenPipe);
        assert!(is_end_of_reader(&Outer(own(broken()))));
        assert!(!is_end_of_reader(&Outer(broken())));
        assert!(!is_end_of_reader(&Outer(Error::new(ErrorKind::BrokenPipe, "a device"))));
    }

    #[test]
    fn json_stays_what_it_says() {
        let text: String = (0..0x2_f000).filter_map(char::from_u32).collect();
        let json = plain_json(&serde_json::to_string(&text).unwrap());
        assert_eq!(json.chars().find(|c| c.is_control() || *c == '\u{202e}'), None);
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), text);
    }
}
