//! Rows as metrics, page and file; the rows of several tables as one page.

use std::io::Write;
use std::path::{Path, PathBuf};

use hapdef_report::{
    Headline, MetricContext, MetricLog, NamedText, Report, ReportError, ReportTable, Summary,
    write_report, write_text,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::column::{Column, Digits};
use super::document::{Table, shown};
use super::row::{Row, Verdict};
use crate::page::{read_made, write_made};

/// The rows and their origin, beside a table's page.
const ROWS_FILE: &str = "rows.json";

/// Columns of all tables as one.
const ALL: [Column; 7] = [
    Column::LAYER,
    Column::LAYER_CASE,
    Column::EXTREME,
    Column::MUST_HOLD,
    Column::MEASURED_OF_LIMIT,
    Column::SAID,
    Column::VERDICT,
];

/// What rows rest on besides the code that makes them.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    /// The scene's name; empty without one.
    pub scene: String,
    /// Hashes of what is read.
    pub hashes: Vec<NamedText>,
}

/// Where rows go.
#[derive(Clone, Copy, Debug)]
pub struct Outputs<'a> {
    /// The metrics' file; pages are in folders beside it.
    pub metrics: &'a Path,
    /// Where the table is written.
    pub write: Option<&'a Path>,
    /// The file that the table is compared with.
    pub check: Option<&'a Path>,
}

/// What came of a table.
#[derive(Clone, Debug, Default)]
pub struct Published {
    /// The page.
    pub page: PathBuf,
    /// Where the file and fresh rows disagree, one sentence each.
    pub differences: Vec<String>,
    /// Rows that are wrong or not what was expected.
    pub n_failed: usize,
}

/// Rows, and by what they were made.
#[derive(Serialize, Deserialize)]
struct Made {
    context: MetricContext,
    scene: String,
    hashes: Vec<(String, String)>,
    rows: Vec<Row>,
}

impl Table {
    /// Prints and keeps the metrics, writes the page and the table, and compares the table.
    ///
    /// # Errors
    /// Files that can't be read or written.
    pub fn publish<W: Write>(
        &self,
        rows: &[Row],
        inputs: Inputs,
        (out, context): (W, MetricContext),
        outputs: Outputs<'_>,
    ) -> Result<Published, ReportError> {
        let text = self.markdown(rows);
        let mut hashes = inputs.hashes;
        hashes.push(NamedText::hash_of("table", &text));
        let seed = context.seed;
        let made = Made {
            context: context.clone(),
            scene: inputs.scene.clone(),
            hashes: hashes.iter().map(|hash| (hash.name.clone(), hash.text.clone())).collect(),
            rows: rows.to_vec(),
        };
        let report = Report {
            title: self.title.into(),
            scene: inputs.scene,
            seed,
            facts: counts(rows),
            tables: vec![table(self.note, self.columns, rows)],
            hashes,
            ..Report::default()
        };
        let folder = outputs.metrics.with_file_name(self.folder);
        let page = publish(rows, report, MetricLog::new(out, context), outputs.metrics, &folder)?;
        let path = folder.join(ROWS_FILE);
        let json = serde_json::to_string_pretty(&made).map_err(ReportError::json(&path))?;
        write_text(&path, &json)?;
        if let Some(path) = outputs.write {
            write_made(path, &text)?;
        }
        let differences = match outputs.check {
            Some(path) => self.differences(&text, &read_made(path)?),
            None => Vec::new(),
        };
        Ok(Published { page, differences, n_failed: n_failed(rows) })
    }
}

/// The rows of the tables in `folders`, published before beside the metrics' file, as one page in
/// `folder`. Metrics carry the largest of their seeds.
///
/// # Errors
/// Files that can't be read or written.
pub fn publish_all<W: Write>(
    folders: &[&str],
    folder: &str,
    out: W,
    metrics: &Path,
) -> Result<Published, ReportError> {
    let (mut rows, mut facts, mut hashes, mut seed) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for part in folders {
        let made = read(&metrics.with_file_name(part).join(ROWS_FILE))?;
        let context = made.context;
        seed = seed.max(context.seed);
        let of_scene = match made.scene.as_str() {
            "" => String::new(),
            scene => format!(" on {scene}"),
        };
        let text = format!(
            "{} rows{of_scene}, seed {}, commit {}, {}",
            made.rows.len(),
            context.seed,
            context.commit,
            context.time
        );
        facts.push(NamedText { name: (*part).into(), text });
        let own = made.hashes.into_iter();
        hashes.extend(own.map(|(name, text)| NamedText { name: format!("{part}: {name}"), text }));
        rows.extend(made.rows);
    }
    let table = table("Measured: the metric, of the most that it may be.", &ALL, &rows);
    hashes.push(NamedText::hash_of("table", &table.text.to_markdown()));
    let report = Report {
        title: "Robustness of every layer".into(),
        seed,
        facts,
        tables: vec![table],
        hashes,
        ..Report::default()
    };
    let log = MetricLog::new(out, MetricContext::here(seed));
    let page = publish(&rows, report, log, metrics, &metrics.with_file_name(folder))?;
    Ok(Published { page, n_failed: n_failed(&rows), ..Published::default() })
}

/// Logs how many rows there are, failed, and are silently wrong; writes the page.
fn publish<W: Write>(
    rows: &[Row],
    mut report: Report,
    mut log: MetricLog<W>,
    metrics: &Path,
    folder: &Path,
) -> Result<PathBuf, ReportError> {
    let n_wrong = Verdict::SilentlyWrong.count(rows);
    log.value("stability.rows", rows.len() as f64, "1")?;
    log.value("stability.failed", n_failed(rows) as f64, "1")?;
    log.value("stability.silently_wrong", n_wrong as f64, "1")?;
    log.append_to(metrics)?;
    report.metrics = log.records().to_vec();
    report.summary = Some(first(rows));
    Ok(write_report(folder, &report)?.pop().unwrap_or_default())
}

/// What a reader sees first.
fn first(rows: &[Row]) -> Summary {
    let (n, n_failed) = (rows.len(), n_failed(rows));
    let sentence = match n_failed {
        0 => format!("None of {n} extreme cases gives a wrong answer without saying so."),
        failed => format!("{failed} of {n} extreme cases fail; they stand in the table."),
    };
    let meaning = |verdict: Verdict| match verdict {
        Verdict::Accurate => "what must hold, holds",
        Verdict::Refused => "an error that says why",
        Verdict::SilentlyWrong => "must be none",
    };
    let number = |verdict: Verdict| Headline {
        value: verdict.count(rows).to_string(),
        what: verdict.word().to_owned(),
        beside: meaning(verdict).to_owned(),
    };
    Summary { sentence, numbers: Verdict::ALL.map(number).into(), picture: None, next: Vec::new() }
}

fn n_failed(rows: &[Row]) -> usize {
    rows.iter().filter(|row| row.failed).count()
}

/// How many rows have which verdict.
fn counts(rows: &[Row]) -> Vec<NamedText> {
    let count = |verdict: Verdict| NamedText {
        name: verdict.word().to_owned(),
        text: verdict.count(rows).to_string(),
    };
    Verdict::ALL.map(count).to_vec()
}

/// Rows on a page; the verdict of a row that did not fail stands out.
fn table(note: &str, columns: &[Column], rows: &[Row]) -> ReportTable {
    let mut text = shown(columns, rows, Digits::Two);
    let verdicts = columns.iter().position(|column| column.name == Column::VERDICT.name);
    for (cells, row) in text.rows.iter_mut().zip(rows) {
        if let Some(column) = verdicts {
            cells[column].strong = !row.failed;
        }
    }
    let data = Value::Array(rows.iter().map(Row::json).collect());
    ReportTable { title: "Rows".into(), note: note.into(), text, data }
}

fn read(path: &Path) -> Result<Made, ReportError> {
    let text = std::fs::read(path)
        .map_err(ReportError::io("`cargo xtask robustness` writes it; reading", path))?;
    serde_json::from_slice(&text).map_err(ReportError::json(path))
}
