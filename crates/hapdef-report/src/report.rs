//! The report of a run: Markdown, JSON, and one HTML page that needs nothing else.

mod markdown;
mod summary;

use std::io::Write;
use std::path::{Path, PathBuf};

use hapdef_mesh::atomic_write;
use serde::Serialize;

pub use self::summary::Summary;
use crate::argument::ArgumentError;
use crate::error::ReportError;
pub use crate::figure::{Figure, FigureContent};
use crate::metrics::{MetricContext, MetricOutcome, MetricRecord};
pub use crate::named_text::NamedText;
use crate::page::{Block, LimbView, Page};
use crate::text::{TextTable, text_table};

/// A stage that ran.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageTime {
    /// The stage.
    pub name: String,
    /// Wall-clock time of the run that made it, s.
    pub elapsed_s: f64,
    /// Whether the result came from the cache.
    pub cached: bool,
}

/// A stage that did not run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SkippedStage {
    /// The stage.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// A table of results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportTable {
    /// Heading.
    pub title: String,
    /// What the reader needs to know; may be empty.
    pub note: String,
    /// For people.
    pub text: TextTable,
    /// For machines.
    pub data: serde_json::Value,
}

/// Everything that goes into a report.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Heading.
    pub title: String,
    /// Name of the scene; empty without one.
    pub scene: String,
    /// How much was made: `quick` or `full`.
    pub profile: String,
    /// Seed of the training side.
    pub seed: u64,
    /// What the run rests on: profile, seed, commit, machine, sample counts, thinning.
    pub facts: Vec<NamedText>,
    /// What comes first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub summary: Option<Summary>,
    /// Tables, in order.
    pub tables: Vec<ReportTable>,
    /// Figures, in order.
    pub figures: Vec<Figure>,
    /// Limbs to be turned, on the page only.
    #[serde(skip)]
    pub limbs: Vec<LimbView>,
    /// Metrics.
    pub metrics: Vec<MetricRecord>,
    /// Stages that ran.
    pub stages: Vec<StageTime>,
    /// Stages that did not.
    pub skipped: Vec<SkippedStage>,
    /// Hashes of scene, limb, datasets, nets, or of the results where nothing is read; not empty.
    pub hashes: Vec<NamedText>,
}

/// A report, and by what code, on what machine and when it was written.
#[derive(Serialize)]
struct Written<'a> {
    made: &'a MetricContext,
    #[serde(flatten)]
    report: &'a Report,
}

/// Writes the figures and the numbers that they draw, `report.json`, `report.md` and `report.html`
/// into `folder`, which is made when absent; commit, machine and time are added. Each file appears whole or not at all. Returns the
/// paths, the page last.
///
/// # Errors
/// [`ReportError::NoHashes`]; a figure whose file name is no plain name with the ending of its content or is used twice,
/// found before anything is written; then files that can't be written.
pub fn write_report(folder: &Path, report: &Report) -> Result<Vec<PathBuf>, ReportError> {
    let pictures = report.summary.iter().filter_map(|summary| summary.picture.as_ref());
    let figures: Vec<&Figure> = pictures.chain(&report.figures).collect();
    check_figures(&figures)?;
    if report.hashes.is_empty() {
        let title = report.title.clone();
        return Err(ReportError::NoHashes { title });
    }
    let made = match report.metrics.first() {
        Some(metric) => metric.context.clone(),
        None => MetricContext::here(report.seed),
    };
    std::fs::create_dir_all(folder).map_err(ReportError::io("making folder", folder))?;
    let written = Written { made: &made, report };
    let json = serde_json::to_vec_pretty(&written)
        .map_err(ReportError::json(&folder.join("report.json")))?;
    let mut paths = Vec::new();
    let mut write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        atomic_write(&path, |file| file.write_all(bytes))
            .map_err(ReportError::io("writing", &path))?;
        paths.push(path);
        Ok::<(), ReportError>(())
    };
    for figure in figures {
        match &figure.content {
            FigureContent::Svg(text) => write(&figure.file, text.as_bytes())?,
            FigureContent::Png(bytes) => write(&figure.file, bytes)?,
        }
        if let Some(name) = figure.data_file() {
            write(&name, figure.data.to_string().as_bytes())?;
        }
    }
    write("report.json", &json)?;
    let shown = with_facts_of(&made, report);
    write("report.md", markdown::page(&shown).as_bytes())?;
    write("report.html", page(&shown).html().as_bytes())?;
    Ok(paths)
}

/// The report with what made it among its facts.
fn with_facts_of(made: &MetricContext, report: &Report) -> Report {
    let mut report = report.clone();
    for (name, text) in [("commit", &made.commit), ("machine", &made.machine), ("time", &made.time)]
    {
        report.facts.retain(|fact| fact.name != name);
        report.facts.push(NamedText { name: name.into(), text: text.clone() });
    }
    report
}

/// Writes a text file, whole or not at all; its folder must exist.
///
/// # Errors
/// [`ReportError::Io`] when the disk refuses.
pub fn write_text(path: &Path, text: &str) -> Result<(), ReportError> {
    atomic_write(path, |file| file.write_all(text.as_bytes()))
        .map_err(ReportError::io("writing", path))
}

/// Stem of the report's own files.
const REPORT: &str = "report";

fn check_figures(figures: &[&Figure]) -> Result<(), ArgumentError> {
    for (index, figure) in figures.iter().enumerate() {
        let (ending, expected) = match figure.content {
            FigureContent::Svg(_) => {
                (".svg", "letters, digits, _ and -, then .svg; not report.svg")
            }
            FigureContent::Png(_) => {
                (".png", "letters, digits, _ and -, then .png; not report.png")
            }
        };
        let stem = figure.file.strip_suffix(ending).unwrap_or_default();
        let plain = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
        let refuse = |expected| {
            let (what, name) = ("figure file", figure.file.clone());
            Err(ArgumentError::Name { what, name, expected })
        };
        if stem.is_empty() || stem == REPORT || !stem.chars().all(plain) {
            return refuse(expected);
        }
        let name = |figure: &Figure| figure.file.rsplit_once('.').map(|(stem, _)| stem.to_owned());
        if figures[..index].iter().any(|f| name(f) == name(figure)) {
            return refuse("each figure needs a file of its own");
        }
    }
    Ok(())
}

fn page(report: &Report) -> Page {
    let scene = (!report.scene.is_empty())
        .then(|| NamedText { name: "scene".into(), text: report.scene.clone() });
    let mut blocks = report.summary.as_ref().map(Summary::blocks).unwrap_or_default();
    for table in &report.tables {
        blocks.push(Block::Heading(table.title.clone()));
        blocks.push(Block::Table(table.text.clone()));
        if !table.note.is_empty() {
            blocks.push(Block::Note(table.note.clone()));
        }
    }
    if !report.figures.is_empty() || !report.limbs.is_empty() {
        blocks.push(Block::Heading("Figures".into()));
    }
    blocks.extend(report.limbs.iter().cloned().map(Block::Limb));
    blocks.extend(report.figures.iter().cloned().map(Block::Figure));
    for (title, table) in record_tables(report) {
        blocks.extend([Block::Heading(title.into()), Block::Table(table)]);
    }
    Page {
        title: report.title.clone(),
        facts: scene.into_iter().chain(report.facts.clone()).collect(),
        blocks,
    }
}

/// Seconds, in tenths; short times in tenths of a millisecond.
#[must_use]
pub fn seconds_text(seconds: f64) -> String {
    if seconds < 0.05 { format!("{seconds:.4}") } else { format!("{seconds:.1}") }
}

/// Stages, skipped stages, metrics and hashes as tables; empty ones are left out.
fn record_tables(report: &Report) -> Vec<(&'static str, TextTable)> {
    let stages = report.stages.iter().map(|s| {
        let from = if s.cached { "cache" } else { "run" };
        vec![s.name.clone(), seconds_text(s.elapsed_s), from.to_owned()]
    });
    let skipped = report.skipped.iter().map(|s| vec![s.name.clone(), s.reason.clone()]);
    let metrics = report.metrics.iter().map(|m| {
        let (value, unit) = match &m.outcome {
            MetricOutcome::Value { value, unit } => (value.to_string(), unit.clone()),
            MetricOutcome::Skipped { skipped } => ("skipped".to_owned(), skipped.clone()),
        };
        vec![m.name.clone(), value, unit]
    });
    let hashes = report.hashes.iter().map(|h| vec![h.name.clone(), h.text.clone()]);
    let tables = [
        ("Stages", text_table(["stage", "seconds", "from"], stages)),
        ("Skipped", text_table(["stage", "why"], skipped)),
        ("Metrics", text_table(["name", "value", "unit or reason"], metrics)),
        ("Hashes", text_table(["what", "hash"], hashes)),
    ];
    tables.into_iter().filter(|(_, table)| !table.rows.is_empty()).collect()
}

#[cfg(test)]
mod tests;
