//! The program: stages from the cache, baselines beside them, the report.

pub(crate) mod facts;
mod figures;
mod samples;
mod search;
mod stability;
mod svr;
mod table1;
mod tactile;

use std::time::Instant;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};
use hapdef::convergence::{Convergence, ConvergenceParams};
use hapdef::stages::{self, EvalReport};
use hapdef::{ContactStats, Limb, Pipeline, Run, SceneArgs, Stage, Until};
use hapdef_repro::{
    MetricLog, OwnAccuracy, Report, ReportTable, Table1, Table2, TextCell, TextTable, message_1,
    message_2, write_report,
};

use crate::bench::{self, BenchNetsArgs};

/// The tables and figures of Sun & Martius 2019 for a scene.
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    hapdef-repro report fixtures/shin/scene.json --profile quick"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Runs what is missing and writes the report: Markdown, JSON, HTML, figures.
    Report(SceneArgs),
    /// The baselines and a net on a real tactile skin that nobody here built.
    Tactile(tactile::TactileArgs),
    /// Settings of a method by Bayesian optimisation on validation samples; goes on where it was.
    Search(search::SearchArgs),
    /// Joins the trials of several shards.
    SearchMerge(search::MergeArgs),
    /// The paper's settings beside the search's best, on test samples.
    SearchCompare(search::CompareArgs),
    /// Nets and baselines with data and settings at their extremes.
    Stability(stability::StabilityArgs),
    /// Times of the networks on one core, against ONNX Runtime and PyTorch where Python has them.
    BenchNets(BenchNetsArgs),
}

/// Does what the arguments say.
pub(crate) fn run(cli: &Cli) -> Result<()> {
    match &cli.command {
        Command::Report(args) => report(args),
        Command::Tactile(args) => tactile::run(args),
        Command::Search(args) => search::search(args),
        Command::SearchMerge(args) => search::merge(args),
        Command::SearchCompare(args) => search::compare(args),
        Command::Stability(args) => stability::run(args),
        Command::BenchNets(args) => bench::run(args),
    }
}

/// The tables and figures of a scene.
fn report(args: &SceneArgs) -> Result<()> {
    let start = Instant::now();
    let run = args.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let done = Pipeline::run(&run, &limb, Until::Eval)?;
    let (_, scores) = done.eval.as_ref().context("the scene was not scored")?;
    let (table1, table1_stage) = table1::table1(&run, &done)?;
    let (svr, svr_stage) = svr::svr(&run, &done)?;
    let (mesh_check, mesh_stage) = mesh_check(&run, &limb)?;
    let table2 = table2(scores, &svr);
    let mut report = Report {
        title: format!("hapdef: {}", run.scene.name),
        scene: run.scene.name.clone(),
        facts: facts::facts(&run, &done, &svr, &mesh_check),
        verdicts: vec![message_1(&table1), message_2(&table1)],
        tables: tables(&table1, &table2, scores)?,
        figures: figures::figures(&run, &limb, &done, &table1)?,
        stages: facts::stage_times(&done, &[&table1_stage, &svr_stage, &mesh_stage]),
        skipped: facts::skipped(&run),
        hashes: facts::hashes(&run, &limb, &done),
        ..Report::default()
    };
    let mut log = MetricLog::new(std::io::stdout(), facts::metric_context(&run));
    let wall_s = facts::since_demo_s().unwrap_or_else(|| start.elapsed().as_secs_f64());
    log_metrics(&mut log, &table1, &table2, &done, wall_s)?;
    report.metrics = log.records().to_vec();
    let folder = args.out.join(&run.scene.name).join("report");
    let paths = write_report(&folder, &report)?;
    figures::write_surface(&folder.join("rigidity.glb"), &limb, &done)?;
    log.append_to(&args.out.join("metrics.json"))?;
    print_summary(&report);
    for path in paths.iter().rev().take(3) {
        println!("{}", path.display());
    }
    Ok(())
}

/// Whether the limb's mesh is fine enough.
fn mesh_check(run: &Run, limb: &Limb) -> Result<(Convergence, Stage)> {
    let (stage, study) = stages::mesh_check(run, limb, &ConvergenceParams::default())?;
    Ok((study, stage))
}

/// Table 2: HapDef 2018's support vectors, the direct net, the chain on one and two contacts.
fn table2(scores: &EvalReport, svr: &svr::SvrScore) -> Table2 {
    let column = |name: &str, stats: &ContactStats| OwnAccuracy {
        name: name.into(),
        location_m: (stats.n > 0).then_some(stats.mean_mm * 1e-3),
        magnitude_n: (stats.n > 0).then_some(stats.mean_n),
    };
    let single = &scores.single;
    let mut ours = vec![
        column("HapDef 2018", &svr.stats),
        column("direct FNN", &single.direct),
        column("HapDefX single", &single.hapdefx),
    ];
    if let Some(double) = &scores.double {
        ours.push(column("HapDefX double", &double.lenient_spread));
    }
    Table2 { ours }
}

fn tables(table1: &Table1, table2: &Table2, scores: &EvalReport) -> Result<Vec<ReportTable>> {
    let data = |value: serde_json::Result<serde_json::Value>| value.context("table as JSON");
    Ok(vec![
        ReportTable {
            title: "Table 1: displacement error of the map, µm (ours / paper)".into(),
            note: "Mean absolute error over all surface nodes and test samples. LR: linear \
                   regression; k-NN: k = 6, weights 1/distance, on standardised inputs; FNN: F_R. \
                   Training errors are over at most 2,000 training samples; k-NN leaves the \
                   sample itself out."
                .into(),
            text: table1.to_text(),
            data: data(serde_json::to_value(table1.records()))?,
        },
        ReportTable {
            title: "Table 2: accuracy on the simulated rig (ours / paper)".into(),
            note: "Means over the contacts that were found (the next table says how many). HapDef \
                   2018: support-vector regression. Double contacts are scored by \
                   the paper's lenient rule with its T + 1 exchange: each of the top two points to \
                   the closest true contact. The human figures are the paper's, not measured here."
                .into(),
            text: table2.to_text(),
            data: data(serde_json::to_value(table2))?,
        },
        ReportTable {
            title: "Contacts in detail".into(),
            note: "Errors are means over the contacts that were found; \
                   those that were not have none. One-to-one: every found contact is matched \
                   with one true contact."
                .into(),
            text: contact_table(scores),
            data: data(serde_json::to_value(scores))?,
        },
        ReportTable {
            title: "Map on the rig: fraction of variance unexplained (ours / paper)".into(),
            note: "From the rig's readings through F_T and F_R, against the simulated map of the \
                   same forces."
                .into(),
            text: fvu_table(scores),
            data: data(serde_json::to_value(scores))?,
        },
    ])
}

fn contact_table(scores: &EvalReport) -> TextTable {
    let mut rows = vec![
        ("direct FNN, single", &scores.single.direct),
        ("HapDefX, single", &scores.single.hapdefx),
    ];
    if let Some(double) = &scores.double {
        rows.push(("HapDefX, double, lenient", &double.lenient));
        rows.push(("HapDefX, double, lenient, T + 1", &double.lenient_spread));
        rows.push(("HapDefX, double, one-to-one, T + 1", &double.one_to_one));
    }
    let header = [
        "",
        "found",
        "mean, mm",
        "median, mm",
        "p90, mm",
        "beyond 10 mm",
        "mean, N",
    ];
    let row = |(name, s): &(&str, &ContactStats)| {
        let cells = [
            (*name).to_owned(),
            format!("{} of {}", s.n, s.n_expected),
            format!("{:.2}", s.mean_mm),
            format!("{:.2}", s.median_mm),
            format!("{:.2}", s.p90_mm),
            format!("{:.0} %", s.share_beyond_10mm * 100.0),
            format!("{:.2}", s.mean_n),
        ];
        cells.map(TextCell::plain).to_vec()
    };
    TextTable {
        header: header.map(str::to_owned).to_vec(),
        rows: rows.iter().map(row).collect(),
    }
}

fn fvu_table(scores: &EvalReport) -> TextTable {
    let percent = |value: f64| format!("{:.1} %", value * 100.0);
    let mut rows = vec![("single", scores.single.map, hapdef_repro::PAPER_FVU_SINGLE)];
    if let Some(double) = &scores.double {
        rows.push(("double", double.map, hapdef_repro::PAPER_FVU_DOUBLE));
    }
    let row = |(name, map, paper): &(&str, hapdef::MapError, f64)| {
        let cells = [
            (*name).to_owned(),
            percent(map.fvu),
            percent(*paper),
            format!("{:.2}", map.mean_abs_um),
            format!("{:.2}", map.rms_um),
        ];
        cells.map(TextCell::plain).to_vec()
    };
    TextTable {
        header: [
            "contacts",
            "FVU",
            "paper",
            "mean |error|, µm",
            "RMS error, µm",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows: rows.iter().map(row).collect(),
    }
}

fn log_metrics(
    log: &mut MetricLog<std::io::Stdout>,
    table1: &Table1,
    table2: &Table2,
    done: &Pipeline,
    wall_s: f64,
) -> Result<()> {
    let (cells1, cells2) = (table1.cells(), table2.cells());
    log.value("demo.wall_s", wall_s, "s")?;
    log.value("demo.table1_cells", cells1.measured as f64, "1")?;
    log.value("demo.table2_cells", cells2.measured as f64, "1")?;
    let n_nan = cells1.nan + cells2.nan;
    log.value("demo.nan_cells", n_nan as f64, "1")?;
    let info = &done.compliance.record.info;
    for (name, key, unit) in [
        ("fe.nnz_l", "nnz_l", "1"),
        ("fe.factor_s", "factor_s", "s"),
        ("fe.compliance_s", "compliance_s", "s"),
        ("fe.compliance_rss_gib", "peak_rss_gib", "GiB"),
    ] {
        match info[key].as_f64() {
            Some(value) => log.value(name, value, unit)?,
            None => log.skipped(name, "the stage's record lacks it")?,
        }
    }
    Ok(())
}

fn print_summary(report: &Report) {
    for table in &report.tables {
        println!("\n{}\n{}", table.title, terminal_table(&table.text));
    }
    for verdict in &report.verdicts {
        println!("{}: {}", verdict.claim, verdict.fate());
    }
    println!();
}

fn terminal_table(text: &TextTable) -> comfy_table::Table {
    let mut table = comfy_table::Table::new();
    table
        .load_style(comfy_table::presets::NOTHING)
        .set_header(&text.header);
    for row in &text.rows {
        table.add_row(row.iter().map(|cell| cell.text.as_str()));
    }
    table
}

/// The run's own cache key for work of this crate: the keys of what it reads.
fn keys_of(run: &Run, done: &Pipeline) -> serde_json::Value {
    let nets = done
        .nets
        .iter()
        .flat_map(|nets| &nets.nets)
        .map(|net| net.stage.key.as_str());
    let data = done
        .data
        .iter()
        .flat_map(|data| &data.simulated)
        .map(|stage| stage.key.as_str());
    serde_json::json!({
        "nets": nets.collect::<Vec<_>>(),
        "datasets": data.collect::<Vec<_>>(),
        "seed": run.scene.seed,
    })
}
