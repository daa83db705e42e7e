//! Tables of methods at their extremes: what a row shows, and the committed file against fresh rows.

use std::fmt::{Debug, Write as _};

use crate::error::ReportError;
use crate::metrics::MetricLog;
use crate::report::NamedText;

/// What a row shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StabilityVerdict {
    /// What must hold, holds.
    Accurate,
    /// A typed error.
    Refused,
    /// Neither.
    SilentlyWrong,
}

/// A typed error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StabilityRefusal {
    /// The variant, such as `RowNotFinite`.
    pub kind: String,
    /// What it says.
    pub text: String,
}

/// What should come of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StabilityWanted {
    /// What must hold, holds.
    Result,
    /// An error.
    Refusal {
        /// The variant; any if empty.
        kind: &'static str,
        /// Words of its text.
        words: &'static str,
    },
    /// What must hold, holds, or any typed error.
    Either,
}

/// A row of a table: a method at an extreme, and what came of it.
pub trait StabilityCase {
    /// What is measured.
    type Figures;

    /// Figures, or a typed error.
    fn outcome(&self) -> Result<&Self::Figures, &StabilityRefusal>;

    /// Whether the figures show that what must hold, holds.
    fn holds(&self, figures: &Self::Figures) -> bool;

    /// What should have come out.
    fn wanted(&self) -> StabilityWanted;

    /// A cell for each column of the table.
    fn cells(&self) -> Vec<String>;

    /// The words of a refusal as they go to the file, with the row's name before them.
    fn words(&self, refusal: &StabilityRefusal) -> String;

    /// Accurate, refused or wrong.
    fn verdict(&self) -> StabilityVerdict {
        match self.outcome() {
            Err(_) => StabilityVerdict::Refused,
            Ok(figures) if self.holds(figures) => StabilityVerdict::Accurate,
            Ok(_) => StabilityVerdict::SilentlyWrong,
        }
    }

    /// Whether the row is wrong, or not what it should be.
    fn is_failed(&self) -> bool {
        let as_wanted = match (self.wanted(), self.outcome()) {
            (StabilityWanted::Either, _) | (StabilityWanted::Result, Ok(_)) => true,
            (StabilityWanted::Refusal { kind, words }, Err(refusal)) => {
                (kind.is_empty() || refusal.kind == kind) && refusal.text.contains(words)
            }
            _ => false,
        };
        !as_wanted || self.verdict() == StabilityVerdict::SilentlyWrong
    }

    /// `ok`, or the kind of error.
    fn said(&self) -> &str {
        match self.outcome() {
            Ok(_) => "ok",
            Err(refusal) => &refusal.kind,
        }
    }
}

impl StabilityWanted {
    /// An error of any kind whose text has these words.
    #[must_use]
    pub fn saying(words: &'static str) -> Self {
        Self::Refusal { kind: "", words }
    }
}

impl StabilityVerdict {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Accurate, Self::Refused, Self::SilentlyWrong];

    /// The word that the table shows.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Accurate => "accurate",
            Self::Refused => "refused",
            Self::SilentlyWrong => "SILENTLY WRONG",
        }
    }
}

impl StabilityRefusal {
    /// Of an enum's variant, named as `Debug` names it.
    #[must_use]
    pub fn new(variant: &impl Debug, text: String) -> Self {
        let name = format!("{variant:?}");
        let is_letter = |c: &char| c.is_ascii_alphanumeric();
        Self { kind: name.chars().take_while(is_letter).collect(), text }
    }
}

/// How many rows have which verdict.
pub fn stability_counts<C: StabilityCase>(rows: &[C]) -> Vec<NamedText> {
    let count = |verdict: StabilityVerdict| NamedText {
        name: verdict.word().to_owned(),
        text: count_of(rows, verdict).to_string(),
    };
    StabilityVerdict::ALL.map(count).to_vec()
}

/// Logs how many rows there are, failed, and are silently wrong.
///
/// # Errors
/// Of the log.
pub fn log_stability<C: StabilityCase, W: std::io::Write>(
    rows: &[C],
    log: &mut MetricLog<W>,
) -> Result<(), ReportError> {
    let n_failed = rows.iter().filter(|row| row.is_failed()).count();
    let n_wrong = count_of(rows, StabilityVerdict::SilentlyWrong);
    log.value("stability.rows", rows.len() as f64, "1")?;
    log.value("stability.failed", n_failed as f64, "1")?;
    log.value("stability.silently_wrong", n_wrong as f64, "1")
}

fn count_of<C: StabilityCase>(rows: &[C], verdict: StabilityVerdict) -> usize {
    rows.iter().filter(|row| row.verdict() == verdict).count()
}

/// A table in docs/, made from rows.
#[derive(Clone, Copy, Debug)]
pub struct StabilityDocument {
    /// Title and explanation, up to the table.
    pub preamble: &'static str,
    /// Names of the columns.
    pub columns: &'static [&'static str],
    /// Columns whose figures depend on rounding: shown, and not compared.
    pub rounded_columns: &'static [&'static str],
    /// Refusals whose words hold numbers that rounding moves; the file names their kind only.
    pub rounded_refusals: &'static [&'static str],
}

impl StabilityDocument {
    /// The file's text.
    #[must_use]
    pub fn markdown<C: StabilityCase>(&self, rows: &[C]) -> String {
        let mut text = self.preamble.to_owned();
        let [accurate, refused, wrong] = StabilityVerdict::ALL.map(|v| count_of(rows, v));
        let _ = writeln!(
            text,
            "{} rows: {accurate} accurate, {refused} refused, {wrong} silently wrong.\n",
            rows.len()
        );
        let rule = "---|".repeat(self.columns.len());
        let _ = writeln!(text, "| {} |\n|{rule}", self.columns.join(" | "));
        for row in rows {
            let _ = writeln!(text, "| {} |", row.cells().join(" | "));
        }
        text.push_str("\n## What refusals say\n\n");
        for row in rows {
            if let Err(refusal) = row.outcome()
                && !self.rounded_refusals.contains(&refusal.kind.as_str())
            {
                let _ = writeln!(text, "- {}", row.words(refusal));
            }
        }
        text
    }

    /// Where the committed text and the one of fresh rows disagree, one sentence each.
    #[must_use]
    pub fn differences(&self, fresh: &str, committed: &str) -> Vec<String> {
        let (fresh, committed) = (self.comparable(fresh), self.comparable(committed));
        let missing = fresh.iter().filter(|row| !committed.contains(row));
        let stale = committed.iter().filter(|row| !fresh.contains(row));
        missing
            .map(|row| format!("not in the file: {row}"))
            .chain(stale.map(|row| format!("in the file, but not so any more: {row}")))
            .collect()
    }

    /// Every line; rows without the figures that depend on rounding.
    fn comparable(&self, text: &str) -> Vec<String> {
        let strip = |line: &str| {
            let inner = line.strip_prefix('|').and_then(|rest| rest.strip_suffix('|'));
            let cells = inner.map(|inner| inner.split('|').map(str::trim).collect::<Vec<_>>());
            match cells.filter(|cells| cells.len() == self.columns.len()) {
                Some(cells) => {
                    let named = self.columns.iter().zip(cells);
                    let kept = named.filter(|(name, _)| !self.rounded_columns.contains(name));
                    kept.map(|(_, cell)| cell).collect::<Vec<_>>().join(" | ")
                }
                None => line.to_owned(),
            }
        };
        let lines = text.lines().filter(|line| !line.trim().is_empty());
        lines.map(strip).collect()
    }
}

/// The order of magnitude of a figure for a table; `least` and its word for what is below.
#[must_use]
pub fn magnitude_text(value: f64, (least, word): (f64, &str)) -> String {
    if value.is_nan() {
        "NaN".to_owned()
    } else if value < least {
        word.to_owned()
    } else if value.is_finite() {
        format!("1e{}", value.log10().round())
    } else {
        "∞".to_owned()
    }
}

#[cfg(test)]
mod tests;
