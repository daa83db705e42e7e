//! The fixed-width blocks of an ANSYS deck: nblock, eblock and cmblock, each with its Fortran
//! format line (ANSYS Mechanical APDL command reference, NBLOCK, EBLOCK, CMBLOCK).

use super::DeckFault;
use super::inp_keyword::quoted;

/// The lines of a deck with their numbers, from 1.
pub(super) struct Lines<'a> {
    lines: Vec<&'a str>,
    next: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { lines: text.lines().collect(), next: 0 }
    }

    /// The next line and its number.
    pub(super) fn next(&mut self) -> Option<(usize, &'a str)> {
        let line = self.lines.get(self.next)?;
        self.next += 1;
        Some((self.next, line))
    }

    /// The number of the line read last.
    pub(super) fn line(&self) -> usize {
        self.next
    }

    /// The next line, which a block needs.
    pub(super) fn need(
        &mut self,
        expected: &str,
        found: &str,
    ) -> Result<(usize, &'a str), DeckFault> {
        let line = self.line();
        self.next().ok_or_else(|| DeckFault::Truncated {
            line,
            expected: expected.into(),
            found: found.into(),
        })
    }
}

/// A block's format, whole numbers and then reals: `(1i9,3e20.9e3)`, `(1i7,2i9,6e21.13)`, `(19i10)`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Format {
    /// Widths of the columns of whole numbers.
    integers: Vec<usize>,
    /// Widths of those of the reals that follow.
    pub(super) reals: Vec<usize>,
}

impl Format {
    /// Reads a format line.
    pub(super) fn read(lines: &mut Lines<'_>) -> Result<Self, DeckFault> {
        let expected = "a format such as (3i9,6e21.13e3) or (19i10)";
        let (line, text) = lines.need(expected, "no format line")?;
        Self::parse(text).ok_or_else(|| DeckFault::Unexpected {
            line,
            expected: expected.into(),
            found: quoted(text),
        })
    }

    fn parse(text: &str) -> Option<Self> {
        let inner = text.trim().strip_prefix('(')?.strip_suffix(')')?.to_lowercase();
        let mut format = Self::default();
        for part in inner.split(',').map(str::trim) {
            let at = part.find(['i', 'a', 'e'])?;
            let count = if at == 0 { 1 } else { part[..at].parse().ok()? };
            let rest = &part[at + 1..];
            let width: usize = rest.split('.').next()?.parse().ok()?;
            let is_real = part.as_bytes()[at] == b'e';
            let columns = if is_real { &mut format.reals } else { &mut format.integers };
            if !(1..=64).contains(&width) || !(1..=64 - columns.len()).contains(&count) {
                return None;
            }
            columns.extend(std::iter::repeat_n(width, count));
            if !is_real && !format.reals.is_empty() {
                return None;
            }
        }
        (!format.integers.is_empty()).then_some(format)
    }

    /// The integers of a line, as many as there are.
    pub(super) fn integers(&self, line: usize, text: &str) -> Result<Vec<i64>, DeckFault> {
        let end = self.integers.iter().sum::<usize>().min(text.len());
        let integers = column_text(line, text, 0, end)?;
        columns(integers, &self.integers)
            .map(|field| parse(line, field.trim(), "a whole number"))
            .collect()
    }

    /// The reals of a line; columns the line lacks or leaves blank are 0.
    pub(super) fn reals(&self, line: usize, text: &str) -> Result<Vec<f64>, DeckFault> {
        let start = self.integers.iter().sum::<usize>().min(text.len());
        let end = (start + self.reals.iter().sum::<usize>()).min(text.len());
        let mut reals = columns(column_text(line, text, start, end)?, &self.reals)
            .map(|field| real(line, field.trim()))
            .collect::<Result<Vec<f64>, _>>()?;
        reals.resize(self.reals.len(), 0.0);
        Ok(reals)
    }
}

fn column_text(line: usize, text: &str, start: usize, end: usize) -> Result<&str, DeckFault> {
    let trimmed = text.get(start..end).filter(|part| part.is_ascii());
    trimmed.map(str::trim_end).ok_or_else(|| DeckFault::Unexpected {
        line,
        expected: "plain digits in fixed columns".into(),
        found: quoted(text),
    })
}

/// The columns of `text`, as many as it reaches into.
fn columns<'a>(text: &'a str, widths: &[usize]) -> impl Iterator<Item = &'a str> {
    let mut rest = text;
    widths.iter().map_while(move |width| {
        let column;
        (column, rest) = rest.split_at((*width).min(rest.len()));
        (!column.is_empty()).then_some(column)
    })
}

fn real(line: usize, field: &str) -> Result<f64, DeckFault> {
    if field.is_empty() {
        return Ok(0.0);
    }
    let value: f64 = parse(line, &field.replace(['d', 'D'], "e"), "a number")?;
    match value.is_finite() {
        true => Ok(value),
        false => Err(unexpected(line, "a finite number", field)),
    }
}

fn parse<T: std::str::FromStr>(line: usize, field: &str, expected: &str) -> Result<T, DeckFault> {
    field.parse().map_err(|_| unexpected(line, expected, field))
}

fn unexpected(line: usize, expected: &str, found: &str) -> DeckFault {
    DeckFault::Unexpected { line, expected: expected.into(), found: quoted(found) }
}

/// A positive 32-bit number of a node, element or property.
pub(super) fn label(line: usize, value: i64) -> Result<u32, DeckFault> {
    u32::try_from(value)
        .ok()
        .filter(|label| *label > 0)
        .ok_or_else(|| unexpected(line, "a number from 1 to 4294967295", &value.to_string()))
}

/// Is this the line that ends a block: `-1`, or `N,R5.3,LOC,-1,` in older decks?
fn ends_block(text: &str) -> bool {
    let text = text.trim();
    text == "-1"
        || (text.starts_with(['N', 'n', 'E', 'e']) && text.trim_end_matches(',').ends_with("-1"))
}

/// The data lines of a block up to its end mark, or to the next command where there is none: each
/// number and text.
pub(super) fn block<'a>(
    lines: &mut Lines<'a>,
    what: &str,
    count: Option<usize>,
) -> Result<Vec<(usize, &'a str)>, DeckFault> {
    let mut data = Vec::new();
    while let Some((line, text)) = lines.next() {
        if ends_block(text) {
            return Ok(data);
        }
        let is_command =
            text.trim_start().starts_with(|c: char| c.is_ascii_alphabetic() || c == '/');
        if is_command {
            lines.next -= 1;
            return Ok(data);
        }
        data.push((line, text));
    }
    if count.is_some_and(|count| data.len() >= count) {
        return Ok(data);
    }
    let announced = count.map_or_else(String::new, |count| format!(" of {count} {what} announced"));
    Err(DeckFault::Truncated {
        line: lines.line(),
        expected: "-1 at the end of the block".into(),
        found: format!("after {} lines of {what}{announced}", data.len()),
    })
}

/// The members of a cmblock: `count` integers, a negative one closing a range.
pub(super) fn component(lines: &mut Lines<'_>, count: usize) -> Result<Vec<u32>, DeckFault> {
    let format = Format::read(lines)?;
    let mut entries: Vec<(usize, i64)> = Vec::new();
    while entries.len() < count {
        let found = format!("{} of {count} members", entries.len());
        let (line, text) = lines.need("members of the component", &found)?;
        let row = format.integers(line, text)?;
        if row.is_empty() || entries.len() + row.len() > count {
            let found = format!("{} more after {}", row.len(), entries.len());
            return Err(unexpected(line, &format!("{count} members in all"), &found));
        }
        entries.extend(row.into_iter().map(|entry| (line, entry)));
    }
    expand_ranges(&entries)
}

fn expand_ranges(entries: &[(usize, i64)]) -> Result<Vec<u32>, DeckFault> {
    let mut members: Vec<u32> = Vec::new();
    for &(line, entry) in entries {
        if entry > 0 {
            members.push(label(line, entry)?);
            continue;
        }
        let last = label(line, entry.saturating_neg())?;
        match members.last() {
            Some(&first) if first < last && fits(&members, last - first) => {
                members.extend(first + 1..=last);
            }
            _ => {
                let found = entry.to_string();
                return Err(unexpected(line, "a range end above the entry before it", &found));
            }
        }
    }
    Ok(members)
}

/// Do `more` members fit? The limit bounds the memory that a damaged deck can ask for.
fn fits(members: &[u32], more: u32) -> bool {
    members.len() + (more as usize) < 10_000_000
}
