//! The program's part of the stability tables.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use hapdef::touch::response_map;
use hapdef::{Limb, SceneArgs};
use hapdef_report::{
    MetricLog, NamedText, Report, ReportTable, StabilityCase, StabilityDocument, TextCell,
    TextTable, log_stability, stability_counts, write_report,
};
use hapdef_repro::{
    INVERSE_DOCUMENT, InverseWorld, NETS_DOCUMENT, PARTS_DOCUMENT, StabilityRow, inverse_rows,
    nets_rows, parts_rows, stability_line,
};
use serde_json::json;

use super::facts;

/// Arguments of `stability`.
#[derive(clap::Args)]
pub(crate) struct StabilityArgs {
    #[command(flatten)]
    table: TableArgs,
}

/// Arguments of `stability-inverse`.
#[derive(clap::Args)]
pub(crate) struct InverseArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    table: TableArgs,
}

#[derive(clap::Args)]
struct TableArgs {
    /// Write the table to this file.
    #[arg(long)]
    write: Option<PathBuf>,
    /// Fail where this file says something else.
    #[arg(long)]
    check: Option<PathBuf>,
    /// The metrics' file.
    #[arg(long, env = "HAPDEF_METRICS", default_value = "target/hapdef/metrics.json")]
    metrics: PathBuf,
    /// Seed of what rows draw; that of the tables in docs/ is 0.
    #[arg(long, default_value_t = 0)]
    test_seed: u64,
}

/// A table's page.
struct Names {
    title: &'static str,
    /// Its folder, beside the metrics' file.
    folder: &'static str,
    document: &'static StabilityDocument,
}

const NETS: Names = Names {
    title: "Training, baselines and inference at their extremes",
    folder: "stability-nets",
    document: &NETS_DOCUMENT,
};

const PARTS: Names = Names {
    title: "Meshes, datasets, compliance, k-Max, decoder, clock and recordings at their extremes",
    folder: "stability-parts",
    document: &PARTS_DOCUMENT,
};

const INVERSE: Names = Names {
    title: "Contacts by superposition at their extremes",
    folder: "stability-inverse",
    document: &INVERSE_DOCUMENT,
};

impl TableArgs {
    /// Prints a row as it is done; a check tells only what differs.
    fn show(&self, row: &StabilityRow) {
        if self.check.is_none() {
            println!("{}", stability_line(row));
        }
    }
}

/// Runs the rows of nets and baselines.
pub(crate) fn run(args: &StabilityArgs) -> Result<()> {
    let rows = nets_rows(args.table.test_seed, |row| args.table.show(row));
    finish(&args.table, &NETS, Inputs::default(), &rows)
}

/// Runs the rows of the parts around them.
pub(crate) fn run_parts(args: &StabilityArgs) -> Result<()> {
    let rows = parts_rows(args.table.test_seed, |row| args.table.show(row));
    finish(&args.table, &PARTS, Inputs::default(), &rows)
}

/// Runs the rows of superposition on a scene's limb.
pub(crate) fn run_inverse(args: &InverseArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let map = response_map(&limb, run.scene.contact.tip_radius_m, run.threads)?;
    let held = limb.clamped.iter().map(|node| limb.mesh.position(*node));
    let world = Arc::new(InverseWorld::new(map, held.collect(), args.table.test_seed)?);
    let rows = inverse_rows(&world, |row| args.table.show(row));
    let inputs = Inputs { scene: run.scene.name.clone(), hashes: facts::input_hashes(&run)? };
    finish(&args.table, &INVERSE, inputs, &rows)
}

/// What rows rest on besides the code that makes them.
#[derive(Default)]
struct Inputs {
    scene: String,
    hashes: Vec<NamedText>,
}

fn finish(args: &TableArgs, names: &Names, inputs: Inputs, rows: &[StabilityRow]) -> Result<()> {
    let text = names.document.markdown(rows);
    let mut log = MetricLog::new(std::io::stdout(), facts::metric_context_of(args.test_seed));
    log_stability(rows, &mut log)?;
    log.append_to(&args.metrics)?;
    write_page(args, names, inputs, rows, (&text, &log))?;
    if let Some(path) = &args.write {
        super::search::write(path, &text)?;
    }
    if let Some(path) = &args.check {
        check(path, names.document, &text)?;
    }
    let n_failed = rows.iter().filter(|row| row.is_failed()).count();
    if n_failed > 0 {
        bail!("{n_failed} of {} rows failed", rows.len());
    }
    Ok(())
}

fn write_page(
    args: &TableArgs,
    names: &Names,
    inputs: Inputs,
    rows: &[StabilityRow],
    (text, log): (&str, &MetricLog<std::io::Stdout>),
) -> Result<()> {
    let mut hashes = inputs.hashes;
    hashes.push(NamedText {
        name: "table".into(),
        text: blake3::hash(text.as_bytes()).to_hex().to_string(),
    });
    let report = Report {
        title: names.title.into(),
        scene: inputs.scene,
        seed: args.test_seed,
        facts: stability_counts(rows),
        tables: vec![table(rows)],
        metrics: log.records().to_vec(),
        hashes,
        ..Report::default()
    };
    let pages = write_report(&args.metrics.with_file_name(names.folder), &report)?;
    if let Some(page) = pages.last() {
        println!("page: {}", page.display());
    }
    Ok(())
}

/// Fails where a committed file says something else than fresh rows.
fn check(path: &Path, document: &StabilityDocument, text: &str) -> Result<()> {
    let committed =
        std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
    let faults = document.differences(text, &committed);
    if faults.is_empty() {
        return Ok(());
    }
    bail!("{} is stale:\n  {}", path.display(), faults.join("\n  "))
}

/// The rows for people and for machines.
fn table(rows: &[StabilityRow]) -> ReportTable {
    let header = NETS_DOCUMENT.columns.iter().copied().map(str::to_owned);
    let cells = |row: &StabilityRow| {
        let short = |value: f64| format!("{value:.1e}");
        let figure = row.outcome.as_ref().ok();
        let said = match &row.outcome {
            Ok(_) => row.said().to_owned(),
            Err(refusal) => refusal.text.clone(),
        };
        let mut cells = [
            row.method.to_owned(),
            row.extreme.clone(),
            row.must_hold.to_owned(),
            figure.map_or_else(String::new, |f| short(f.limit)),
            figure.map_or_else(String::new, |f| short(f.measured)),
            said,
            row.verdict().word().to_owned(),
        ]
        .map(TextCell::plain);
        cells[6].strong = !row.is_failed();
        cells.to_vec()
    };
    let data = rows.iter().map(|row| {
        let figure = row.outcome.as_ref().ok();
        json!({
            "method": row.method,
            "extreme": row.extreme,
            "must_hold": row.must_hold,
            "measured": figure.map(|f| f.measured),
            "limit": figure.map(|f| f.limit),
            "said": row.said(),
            "text": row.outcome.as_ref().err().map(|refusal| &refusal.text),
            "verdict": row.verdict().word(),
            "failed": row.is_failed(),
        })
    });
    ReportTable {
        title: "Rows".into(),
        note: "Measured: the figure that must not exceed the limit.".into(),
        text: TextTable { header: header.collect(), rows: rows.iter().map(cells).collect() },
        data: data.collect(),
    }
}
