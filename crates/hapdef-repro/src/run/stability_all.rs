//! The tables of extremes of all parts as one: layer, case, extreme, what must hold, what came out.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use hapdef_report::{MetricLog, NamedText, Report, ReportTable, TextCell, TextTable, write_report};
use serde::Deserialize;
use serde_json::Value;

use super::facts;

/// Arguments of `stability-all`.
#[derive(clap::Args)]
pub(crate) struct AllArgs {
    /// The metrics' file; the pages of the parts are in folders beside it.
    #[arg(long, env = "HAPDEF_METRICS", default_value = "target/hapdef/metrics.json")]
    metrics: PathBuf,
}

/// The parts' folders, and the layer of their rows; where there is none, each row names its own.
const PARTS: [(&str, Option<&str>); 4] = [
    ("stability-fe", Some("elements, factor, solve")),
    ("stability-nets", Some("training, inference")),
    ("stability-inverse", Some("superposition, calibration")),
    ("stability-parts", None),
];

const FOLDER: &str = "stability";

const COLUMNS: [&str; 7] = ["layer", "case", "extreme", "must hold", "measured", "said", "verdict"];

/// What is read of a part's page.
#[derive(Deserialize)]
struct Page {
    made: Made,
    /// Empty where a part has no limb of a scene.
    scene: String,
    tables: Vec<PageTable>,
    hashes: Vec<Hash>,
}

#[derive(Deserialize)]
struct Made {
    commit: String,
    seed: u64,
    time: String,
}

#[derive(Deserialize)]
struct Hash {
    name: String,
    text: String,
}

#[derive(Deserialize)]
struct PageTable {
    text: PageText,
    data: Vec<Value>,
}

#[derive(Deserialize)]
struct PageText {
    header: Vec<String>,
    rows: Vec<Vec<PageCell>>,
}

#[derive(Deserialize)]
struct PageCell {
    text: String,
}

/// Joins the parts' pages, and says what all rows come to.
pub(crate) fn run(args: &AllArgs) -> Result<()> {
    let (mut rows, mut data) = (Vec::new(), Vec::new());
    let (mut facts, mut hashes, mut seed) = (Vec::new(), Vec::new(), 0);
    for (folder, layer) in PARTS {
        let page = read(&args.metrics.with_file_name(folder))?;
        let n_before = rows.len();
        for table in &page.tables {
            rows.extend(table.text.rows.iter().map(|row| cells(&table.text.header, row, layer)));
            data.extend(table.data.iter().cloned());
        }
        seed = seed.max(page.made.seed);
        hashes.extend(page.hashes.iter().map(|hash| NamedText {
            name: format!("{folder}: {}", hash.name),
            text: hash.text.clone(),
        }));
        let of_scene = match page.scene.as_str() {
            "" => String::new(),
            scene => format!(" on {scene}"),
        };
        facts.push(NamedText {
            name: folder.into(),
            text: format!(
                "{} rows{of_scene}, seed {}, commit {}, {}",
                rows.len() - n_before,
                page.made.seed,
                page.made.commit,
                page.made.time
            ),
        });
    }
    let mut log = MetricLog::new(std::io::stdout(), facts::metric_context_of(seed));
    let n_failed = data.iter().filter(|row| row["failed"] == true).count();
    let is_wrong = |row: &&Value| {
        let verdict = row["verdict"].as_str();
        verdict.is_some_and(|verdict| verdict.eq_ignore_ascii_case("silently wrong"))
    };
    let n_wrong = data.iter().filter(is_wrong).count();
    log.value("stability.rows", data.len() as f64, "1")?;
    log.value("stability.failed", n_failed as f64, "1")?;
    log.value("stability.silently_wrong", n_wrong as f64, "1")?;
    log.append_to(&args.metrics)?;
    let text = TextTable { header: COLUMNS.map(str::to_owned).to_vec(), rows };
    let hash = blake3::hash(text.to_markdown().as_bytes());
    hashes.push(NamedText { name: "table".into(), text: hash.to_hex().to_string() });
    let report = Report {
        title: "Every layer at its extremes".into(),
        seed,
        facts,
        tables: vec![ReportTable {
            title: "Rows".into(),
            note: "Measured: the figure, of the most that it may be.".into(),
            text,
            data: data.into(),
        }],
        metrics: log.records().to_vec(),
        hashes,
        ..Report::default()
    };
    let pages = write_report(&args.metrics.with_file_name(FOLDER), &report)?;
    if let Some(page) = pages.last() {
        println!("page: {}", page.display());
    }
    Ok(())
}

fn read(folder: &Path) -> Result<Page> {
    let path = folder.join("report.json");
    let text = std::fs::read(&path)
        .with_context(|| format!("{}: `cargo xtask stability` writes it", path.display()))?;
    serde_json::from_slice(&text).with_context(|| path.display().to_string())
}

/// A part's row in the columns of all.
fn cells(header: &[String], row: &[PageCell], layer: Option<&str>) -> Vec<TextCell> {
    let of = |name: &str| {
        let place = header.iter().position(|column| column == name);
        place.map_or("", |place| row[place].text.as_str())
    };
    let (case, must_hold, measured) = if header.iter().any(|column| column == "bound") {
        let case = format!("{}, {}", of("case"), of("path"));
        (case, "the error is within the bound told", [of("error"), of("bound")])
    } else {
        let case = of("method").to_owned();
        (case, of("must hold"), [of("measured"), of("limit")])
    };
    let measured = match measured {
        ["", _] => String::new(),
        [measured, limit] => format!("{measured} of {limit}"),
    };
    let (layer, case) = match layer {
        Some(layer) => (layer.to_owned(), case),
        None => (case, String::new()),
    };
    let verdict = TextCell { text: of("verdict").to_owned(), strong: true };
    let plain = [&layer, &case, of("extreme"), must_hold, &measured, of("said")];
    plain.map(TextCell::plain).into_iter().chain([verdict]).collect()
}
