//! What a program prints, in one place: text from outside commands no terminal, and a reader that has enough is
//! no error.

use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Write};
use std::sync::Mutex;

use hapdef_contact::{printable, printable_lines};
use serde::Serialize;

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

/// Prints lines on standard error, as [`print_line`] does. Where nobody reads them there is nobody to say it to.
pub fn note_line(text: Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "{}", printable_lines(&text.to_string()));
}

/// What was printed has reached who reads it, or they wanted no more.
///
/// # Errors
/// Standard output could not be written.
pub fn check_printed() -> Result<(), Error> {
    keep(std::io::stdout().flush());
    let fault = FAULT.lock().map_or(None, |mut fault| fault.take());
    fault.map_or(Ok(()), |e| Err(Error::new(e.kind(), format!("standard output: {e}"))))
}

fn put(text: &str) {
    keep(writeln!(std::io::stdout(), "{text}"));
}

/// Keeps the first fault; a reader that has closed its end has enough, and the work goes on.
fn keep(done: Result<(), Error>) {
    if let (Err(error), Ok(mut fault)) = (done, FAULT.lock())
        && error.kind() != ErrorKind::BrokenPipe
    {
        fault.get_or_insert(error);
    }
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

    #[test]
    fn json_stays_what_it_says() {
        let text: String = (0..0x2_f000).filter_map(char::from_u32).collect();
        let json = plain_json(&serde_json::to_string(&text).unwrap());
        assert_eq!(json.chars().find(|c| c.is_control() || *c == '\u{202e}'), None);
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), text);
    }
}
