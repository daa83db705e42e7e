//! A table: its trials run, its file in docs/, and that file against fresh rows.

use std::fmt::Write as _;

use hapdef_report::{TextTable, text_table};

use super::column::{Column, Digits};
use super::row::{Row, Verdict};
use super::trial::{Trial, Trials};

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
    /// Runs trials in their order; each row goes to `progress` as it comes.
    #[must_use]
    pub fn rows<W, E>(&self, trials: Trials<W, E>, mut progress: impl FnMut(&Row)) -> Vec<Row> {
        let run = |trial: Trial| {
            let outcome = (trial.run)();
            let verdict = Verdict::of(&outcome);
            let failed = verdict == Verdict::SilentlyWrong || !trial.expected.is_met_by(&outcome);
            let row = Row {
                layer: self.layer.to_owned(),
                case: trial.case.to_owned(),
                path: trial.path.map(str::to_owned),
                extreme: trial.extreme,
                must_hold: trial.must_hold.to_owned(),
                outcome,
                verdict,
                failed,
            };
            progress(&row);
            row
        };
        trials.all.into_iter().map(run).collect()
    }

    /// The rows in the file.
    #[must_use]
    pub fn markdown(&self, rows: &[Row]) -> String {
        let [accurate, refused, wrong] = Verdict::ALL.map(|verdict| verdict.count(rows));
        let n = rows.len();
        let mut text = format!(
            "{n} rows: {accurate} accurate, {refused} refused, {wrong} silently wrong.\n\n"
        );
        let digits = Digits::Magnitude(self.least);
        text.push_str(&shown(self.columns, rows, digits).to_markdown());
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
                    let kept = of_column.filter(|(column, _)| !column.is_rounded);
                    kept.map(|(_, cell)| cell).collect::<Vec<_>>().join(" | ")
                }
                None => line.to_owned(),
            }
        };
        let lines = text.lines().filter(|line| !line.trim().is_empty());
        lines.map(strip).collect()
    }
}

/// The cells of rows.
pub(super) fn shown(columns: &[Column], rows: &[Row], digits: Digits) -> TextTable {
    let cells = |row| columns.iter().map(move |column| (column.cell)(row, digits));
    text_table(columns.iter().map(|column| column.name), rows.iter().map(cells))
}
