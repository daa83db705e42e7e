//! Abaqus and CalculiX syntax: keyword cards with parameters and data lines.

use std::str::FromStr;

use super::DeckFault;

/// One keyword with its parameters and data.
#[derive(Debug)]
pub(super) struct Card<'a> {
    /// Where the keyword stands.
    pub(super) line: usize,
    /// The keyword in upper case without `*`, inner spaces single: `NODE`, `SOLID SECTION`.
    pub(super) name: String,
    parameters: Vec<(String, String)>,
    /// The data lines: line number and comma-separated fields, trimmed; an empty last field (a
    /// line that ends with a comma) is left out.
    pub(super) data: Vec<DataLine<'a>>,
}

/// A data line's number and fields.
pub(super) type DataLine<'a> = (usize, Vec<&'a str>);

/// All cards of a deck, in order. Lines that start with `**` and empty lines are comments.
pub(super) fn cards(text: &str) -> Result<Vec<Card<'_>>, DeckFault> {
    let mut cards: Vec<Card<'_>> = Vec::new();
    let mut open_keyword = false;
    for (i, raw) in text.lines().enumerate() {
        let (line, content) = (i + 1, raw.trim());
        if content.is_empty() || content.starts_with("**") {
            continue;
        }
        if open_keyword && let Some(card) = cards.last_mut() {
            card.add_parameters(content);
            open_keyword = content.ends_with(',');
        } else if let Some(keyword) = content.strip_prefix('*') {
            cards.push(Card::new(line, keyword));
            open_keyword = content.ends_with(',');
        } else {
            let card = cards.last_mut().ok_or_else(|| DeckFault::Unexpected {
                line,
                expected: "a keyword that starts with `*`".into(),
                found: quoted(content),
            })?;
            card.data.push((line, fields(content)));
        }
    }
    Ok(cards)
}

impl Card<'_> {
    fn new(line: usize, keyword: &str) -> Self {
        let (name, rest) = keyword.split_once(',').unwrap_or((keyword, ""));
        let name = name.split_whitespace().collect::<Vec<_>>().join(" ").to_uppercase();
        let mut card = Self { line, name, parameters: Vec::new(), data: Vec::new() };
        card.add_parameters(rest);
        card
    }

    fn add_parameters(&mut self, text: &str) {
        for field in text.split(',').map(str::trim).filter(|field| !field.is_empty()) {
            let (key, value) = field.split_once('=').unwrap_or((field, ""));
            let (key, value) = (key.trim().to_uppercase(), value.trim().trim_matches('"'));
            let value = if key == "INPUT" { value.to_owned() } else { value.to_uppercase() };
            self.parameters.push((key, value));
        }
    }

    /// A parameter's value, in upper case unless it is a file's name; empty if it has none.
    pub(super) fn parameter(&self, key: &str) -> Option<&str> {
        self.parameters.iter().find(|(k, _)| k == key).map(|(_, value)| value.as_str())
    }

    /// A parameter that must be there with a value.
    pub(super) fn required(&self, key: &str) -> Result<&str, DeckFault> {
        self.parameter(key).filter(|value| !value.is_empty()).ok_or_else(|| DeckFault::Unexpected {
            line: self.line,
            expected: format!("parameter {key}= of *{}", self.name),
            found: "none".into(),
        })
    }

    /// Refuses every parameter that is not in `known`.
    pub(super) fn only(&self, known: &[&str], why: &'static str) -> Result<(), DeckFault> {
        match self.parameters.iter().find(|(key, _)| !known.contains(&key.as_str())) {
            Some((key, _)) => Err(self.unsupported(format!("*{}, {key}", self.name), why)),
            None => Ok(()),
        }
    }

    pub(super) fn unsupported(&self, command: String, why: &'static str) -> DeckFault {
        DeckFault::Unsupported { line: self.line, command, why }
    }
}

/// Field `i` of a data line as a number.
pub(super) fn number<T: FromStr>(
    (line, fields): &DataLine<'_>,
    i: usize,
    expected: &'static str,
) -> Result<T, DeckFault> {
    let field = fields.get(i).copied().unwrap_or("");
    field.parse().map_err(|_| DeckFault::Unexpected {
        line: *line,
        expected: format!("{expected} in field {}", i + 1),
        found: quoted(field),
    })
}

/// Field `i` of a data line as a finite number; 0 if it is empty or not there.
pub(super) fn real_or_zero(data: &DataLine<'_>, i: usize) -> Result<f64, DeckFault> {
    match data.1.get(i) {
        None | Some(&"") => Ok(0.0),
        Some(_) => real(data, i),
    }
}

/// Field `i` of a data line as a finite number.
pub(super) fn real(data: &DataLine<'_>, i: usize) -> Result<f64, DeckFault> {
    let value: f64 = match data.1.get(i) {
        // Fortran writes a double's exponent with D
        Some(field) if field.contains(['d', 'D']) => {
            field.replace(['d', 'D'], "e").parse().map_err(|_| not_finite(data.0, field))?
        }
        _ => number(data, i, "a number")?,
    };
    if value.is_finite() { Ok(value) } else { Err(not_finite(data.0, data.1[i])) }
}

fn not_finite(line: usize, field: &str) -> DeckFault {
    DeckFault::Unexpected { line, expected: "a finite number".into(), found: quoted(field) }
}

/// Text as it stands in an error: in quotes and not too long.
pub(super) fn quoted(text: &str) -> String {
    let short: String = text.chars().take(60).collect();
    if short.len() < text.len() { format!("`{short}…`") } else { format!("`{short}`") }
}

fn fields(content: &str) -> Vec<&str> {
    let mut fields: Vec<_> = content.split(',').map(str::trim).collect();
    if fields.last().is_some_and(|last| last.is_empty()) {
        fields.pop();
    }
    fields
}
