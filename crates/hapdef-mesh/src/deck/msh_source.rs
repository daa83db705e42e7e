//! The numbers of a gmsh file, written as words or as bytes.

use super::DeckFault;
use super::inp_keyword::quoted;

/// A file's bytes from where the reader is.
pub(super) struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Are numbers bytes, lowest first, and not words?
    pub(super) is_binary: bool,
}

impl<'a> Source<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, is_binary: false }
    }

    /// The rest of this line without spaces around it; `None` at the end of the file.
    pub(super) fn line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.at += (end + 1).min(rest.len());
        Some(String::from_utf8_lossy(&rest[..end]).trim().to_owned())
    }

    /// Goes to the line after `$End` of section `name`.
    pub(super) fn leave(&mut self, name: &str) -> Result<(), DeckFault> {
        let mark = format!("$End{name}").into_bytes();
        let rest = &self.bytes[self.at..];
        let found = rest.windows(mark.len()).position(|window| window == mark);
        self.at += found.ok_or_else(|| self.cut_short(&format!("$End{name}")))?;
        self.line();
        Ok(())
    }

    /// A whole number of four bytes.
    pub(super) fn int(&mut self) -> Result<i64, DeckFault> {
        match self.is_binary {
            true => Ok(i32::from_le_bytes(self.take()?).into()),
            false => self.word("a whole number"),
        }
    }

    /// A count or tag of eight bytes.
    pub(super) fn size(&mut self) -> Result<u64, DeckFault> {
        match self.is_binary {
            true => Ok(u64::from_le_bytes(self.take()?)),
            false => self.word("a whole number from 0"),
        }
    }

    /// A finite number.
    pub(super) fn real(&mut self) -> Result<f64, DeckFault> {
        let value = match self.is_binary {
            true => f64::from_le_bytes(self.take()?),
            false => self.word("a number")?,
        };
        match value.is_finite() {
            true => Ok(value),
            false => Err(self.unexpected("a finite number", &value.to_string())),
        }
    }

    /// A node's or element's number.
    pub(super) fn tag(&mut self, value: u64) -> Result<u32, DeckFault> {
        let tag = u32::try_from(value).ok().filter(|tag| *tag > 0);
        tag.ok_or_else(|| self.unexpected("a number from 1 to 4294967295", &value.to_string()))
    }

    /// The line that was reached; in a binary file the place in bytes.
    pub(super) fn line_number(&self) -> usize {
        1 + self.bytes[..self.at.min(self.bytes.len())].iter().filter(|b| **b == b'\n').count()
    }

    pub(super) fn unexpected(&self, expected: &str, found: &str) -> DeckFault {
        let at = if self.is_binary { format!(" before byte {}", self.at) } else { String::new() };
        DeckFault::Unexpected {
            line: self.line_number(),
            expected: format!("{expected}{at}"),
            found: quoted(found),
        }
    }

    pub(super) fn cut_short(&self, expected: &str) -> DeckFault {
        DeckFault::Truncated {
            line: self.line_number(),
            expected: expected.into(),
            found: "the end of the file".into(),
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], DeckFault> {
        let bytes = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        let bytes = *bytes.ok_or_else(|| self.cut_short("another number"))?;
        self.at += N;
        Ok(bytes)
    }

    fn word<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, DeckFault> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let start = rest.iter().position(|b| !b.is_ascii_whitespace());
        let start = start.ok_or_else(|| self.cut_short(expected))?;
        let length = rest[start..].iter().position(u8::is_ascii_whitespace);
        let end = length.map_or(rest.len(), |length| start + length);
        let word = String::from_utf8_lossy(&rest[start..end]);
        let parsed = word.parse().map_err(|_| self.unexpected(expected, &word));
        self.at += end;
        parsed
    }
}
