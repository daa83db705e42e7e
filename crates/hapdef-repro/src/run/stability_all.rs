//! The tables of extremes of all parts as one: layer, case, extreme, what must hold, what came out.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use hapdef_report::{MetricLog, NamedText, Report, ReportTable, TextCell, TextTable, write_report};
use serde::Deserialize;

use super::facts;

/// Arguments of `stability-all`.
#[derive(clap::Args)]
pub(crate) struct AllArgs {
    /// The metrics' file; the pages of the parts are in folders beside it.
    #[arg(
        long,
        env = "HAPDEF_METRICS",
        default_value = "target/hapdef/metrics.json"
    )]
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

const COLUMNS: [&str; 7] = [
    "layer",
    "case",
    "extreme",
    "must hold",
    "measured",
    "said",
    "verdict",
];

/// What is read of a part's page.
#[derive(Deserialize)]
struct Page {
    made: Made,
    tables: Vec<PageTable>,
}

#[derive(Deserialize)]
struct Made {
    commit: String,
    time: String,
}

#[derive(Deserialize)]
struct PageTable {
    text: PageText,
    data: Vec<PageRow>,
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

#[derive(Deserialize)]
struct PageRow {
    verdict: String,
    failed: bool,
}

/// Joins the parts' pages, and says what all rows come to.
pub(crate) fn run(args: &AllArgs) -> Result<()> {
    let (mut rows, mut data, mut facts) = (Vec::new(), Vec::new(), Vec::new());
    for (folder, layer) in PARTS {
        let page = read(&args.metrics.with_file_name(folder))?;
        let n_before = rows.len();
        for table in &page.tables {
            rows.extend(
                table
                    .text
                    .rows
                    .iter()
                    .map(|row| cells(&table.text.header, row, layer)),
            );
            data.extend(
                table
                    .data
                    .iter()
                    .map(|row| (row.verdict.clone(), row.failed)),
            );
        }
        facts.push(NamedText {
            name: folder.into(),
            text: format!(
                "{} rows, commit {}, {}",
                rows.len() - n_before,
                page.made.commit,
                page.made.time
            ),
        });
    }
    let mut log = MetricLog::new(std::io::stdout(), facts::metric_context_of(0));
    let n_failed = data.iter().filter(|(_, failed)| *failed).count();
    let is_wrong = |verdict: &str| verdict.eq_ignore_ascii_case("silently wrong");
    let n_wrong = data.iter().filter(|(verdict, _)| is_wrong(verdict)).count();
    log.value("stability.rows", data.len() as f64, "1")?;
    log.value("stability.failed", n_failed as f64, "1")?;
    log.value("stability.silently_wrong", n_wrong as f64, "1")?;
    log.append_to(&args.metrics)?;
    let text = TextTable {
        header: COLUMNS.map(str::to_owned).to_vec(),
        rows,
    };
    let hash = blake3::hash(text.to_markdown().as_bytes());
    let report = Report {
        title: "Every layer at its extremes".into(),
        facts,
        tables: vec![ReportTable {
            title: "Rows".into(),
            note: "Measured: the figure, of the most that it may be.".into(),
            text,
            data: serde_json::Value::Null,
        }],
        metrics: log.records().to_vec(),
        hashes: vec![NamedText {
            name: "table".into(),
            text: hash.to_hex().to_string(),
        }],
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
        (
            case,
            "the error is within the bound told",
            [of("error"), of("bound")],
        )
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
    let verdict = TextCell {
        text: of("verdict").to_owned(),
        strong: true,
    };
    let plain = [
        &layer,
        &case,
        of("extreme"),
        must_hold,
        &measured,
        of("said"),
    ];
    plain
        .map(TextCell::plain)
        .into_iter()
        .chain([verdict])
        .collect()
}
