//! A table: its trials run, its file in docs/, and that file against fresh rows.

use std::fmt::Write as _;

use super::column::{Column, Digits};
use super::row::{Refusal, Row, Trial, Verdict};
use crate::text::{TextCell, TextTable};

/// A table of rows.
#[derive(Clone, Copy, Debug)]
pub struct Table {
    /// Its folder of results.
    pub folder: &'static str,
    /// The page's title.
    pub title: &'static str,
    /// What the page says below the rows.
    pub note: &'static str,
    /// The layer of its rows; empty where the case of each names it.
    pub layer: &'static str,
    /// Title and explanation of the file in docs/, up to the table.
    pub preamble: &'static str,
    /// The columns.
    pub columns: &'static [Column],
    /// Numbers below this are shown as the word.
    pub least: (f64, &'static str),
    /// Refusals whose words hold numbers that rounding moves; the file names their kind only.
    pub rounded_refusals: &'static [&'static str],
    /// What the file keeps of a word of a refusal.
    pub word: fn(&str) -> String,
}

impl Table {
    /// Runs trials in their order. Each row goes to `progress` as it comes; `refusal` makes a row's
    /// refusal of an error.
    ///
    /// # Errors
    /// Those that `refusal` gives back, because the trial's own set-up is wrong.
    pub fn rows<E, F>(
        &self,
        trials: impl IntoIterator<Item = Trial<E>>,
        refusal: impl Fn(E) -> Result<Refusal, F>,
        mut progress: impl FnMut(&Row),
    ) -> Result<Vec<Row>, F> {
        let run = |trial: Trial<E>| {
            let outcome = match (trial.run)() {
                Ok(measured) => Ok(measured),
                Err(error) => Err(refusal(error)?),
            };
            let row = Row::new(self.layer, &trial, outcome);
            progress(&row);
            Ok(row)
        };
        trials.into_iter().map(run).collect()
    }

    /// The file's text.
    #[must_use]
    pub fn markdown(&self, rows: &[Row]) -> String {
        let mut text = self.preamble.to_owned();
        let [accurate, refused, wrong] = Verdict::ALL.map(|verdict| verdict.count(rows));
        let _ = writeln!(
            text,
            "{} rows: {accurate} accurate, {refused} refused, {wrong} silently wrong.\n",
            rows.len()
        );
        let names: Vec<_> = self.columns.iter().map(|column| column.name()).collect();
        let rule = "---|".repeat(self.columns.len());
        let _ = writeln!(text, "| {} |\n|{rule}", names.join(" | "));
        for row in rows {
            let cells = self.columns.iter().map(|c| c.cell(row, Digits::Magnitude(self.least)));
            let _ = writeln!(text, "| {} |", cells.collect::<Vec<_>>().join(" | "));
        }
        text.push_str("\n## What refusals say\n\n");
        for row in rows {
            if let Err(refusal) = &row.outcome
                && !self.rounded_refusals.contains(&refusal.kind.as_str())
            {
                let words: Vec<_> = refusal.text.split(' ').map(self.word).collect();
                let path = row.path.as_ref().map_or_else(String::new, |path| format!(" ({path})"));
                let _ =
                    writeln!(text, "- {}, {}{path}: {}", row.case, row.extreme, words.join(" "));
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

    /// Every line; rows without the numbers that depend on rounding.
    fn comparable(&self, text: &str) -> Vec<String> {
        let strip = |line: &str| {
            let inner = line.strip_prefix('|').and_then(|rest| rest.strip_suffix('|'));
            let cells = inner.map(|inner| inner.split('|').map(str::trim).collect::<Vec<_>>());
            match cells.filter(|cells| cells.len() == self.columns.len()) {
                Some(cells) => {
                    let of_column = self.columns.iter().zip(cells);
                    let kept = of_column.filter(|(column, _)| !column.is_rounded());
                    kept.map(|(_, cell)| cell).collect::<Vec<_>>().join(" | ")
                }
                None => line.to_owned(),
            }
        };
        let lines = text.lines().filter(|line| !line.trim().is_empty());
        lines.map(strip).collect()
    }
}

/// Rows on a page; the verdict of a row that did not fail stands out.
pub(super) fn page_table(columns: &[Column], rows: &[Row]) -> TextTable {
    let cells = |row: &Row| {
        let cell = |column: &Column| TextCell {
            text: column.cell(row, Digits::Two),
            strong: *column == Column::Verdict && !row.failed,
        };
        columns.iter().map(cell).collect()
    };
    TextTable {
        header: columns.iter().map(|column| column.name().to_owned()).collect(),
        rows: rows.iter().map(cells).collect(),
    }
}
