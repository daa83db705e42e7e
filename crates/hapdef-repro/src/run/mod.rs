//! The program: stages from the cache, baselines beside them, the report.

mod ablation;
mod ablation_table;
pub(crate) mod chain;
mod claims;
mod cli;
mod contents;
pub(crate) mod dataset;
mod examples;
pub(crate) mod facts;
mod figures;
pub(crate) mod fit;
mod frames;
pub(crate) mod kept;
mod made;
mod patches;
pub(crate) mod presses;
mod ridge;
mod robustness;
pub(crate) mod scores;
mod search;
mod singles;
pub(crate) mod summary;
mod svr;
mod table1;
mod tactile;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use hapdef::{Limb, Pipeline, Run, Until};
use hapdef_report::{MetricLog, Report, write_report, write_text};

use self::ablation_table::Ablations;
pub(crate) use self::cli::Cli;
use self::cli::{CheckResultsArgs, Command, GoldenArgs, ReportArgs, ReproArgs};
use self::made::Made;
use crate::report::{Golden, check_results, results_markdown};
use crate::tables::table1_claims;
use crate::{bench, compare, frontier};

/// Does what the arguments say.
pub(crate) fn run(cli: &Cli) -> Result<()> {
    match &cli.command {
        Command::Tactile(args) => tactile::run(args),
        Command::Search(args) => search::search(args),
        Command::SearchMerge(args) => search::merge(args),
        Command::SearchCompare(args) => search::compare(args),
        Command::Robustness(args) => robustness::run_nets(args),
        Command::RobustnessInverse(args) => robustness::run_inverse(args),
        Command::RobustnessParts(args) => robustness::run_parts(args),
        Command::RobustnessAll(args) => robustness::run_all(args),
        Command::BenchNets(args) => bench::run(args),
        Command::FrontierNets(args) => bench::run_frontier(args),
        Command::Frontier(args) => frontier::run(args),
        Command::Compare(args) => compare::run(args),
        Command::FrontierInverse(args) => compare::run_frontier(args),
        Command::BenchInverse(args) => compare::run_bench(args),
        Command::Report(args) => report(args, Extent::Demo).map(drop),
        Command::Repro(args) => repro(args),
        Command::Golden(args) => golden(args),
        Command::CheckResults(args) => check_results_page(args),
    }
}

fn repro(args: &ReproArgs) -> Result<()> {
    let extent = match args.tables_only {
        true => Extent::Tables,
        false => Extent::Everything,
    };
    let report = report(&args.run, extent)?;
    if let Some(path) = &args.page {
        write_text(path, &results_markdown(&report))?;
    }
    if let Some(path) = &args.metrics {
        let json = serde_json::to_string_pretty(&report.metrics).context("metrics as JSON")?;
        write_text(path, &format!("{json}\n"))?;
    }
    Ok(())
}

fn check_results_page(args: &CheckResultsArgs) -> Result<()> {
    let run = args.training.prepare(&args.scene)?;
    let report = serde_json::from_str(&read(&args.report)?).context("the report")?;
    let page = read(&args.page)?;
    check_results(&page, &report, &facts::amounts(&run))?;
    println!("{} is about what the code makes", args.page.display());
    Ok(())
}

fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))
}

fn golden(args: &GoldenArgs) -> Result<()> {
    let report = serde_json::from_str(&read(&args.report)?).context("the report")?;
    if args.write {
        return Ok(Golden::of(&report)?.write(&args.golden)?);
    }
    let golden = Golden::read(&args.golden)?;
    let n = golden.compare(&report)?;
    println!("{n} golden values within their tolerances");
    Ok(())
}

fn report(args: &ReportArgs, extent: Extent) -> Result<Report> {
    let start = Instant::now();
    let run = args.training.prepare(&args.scene)?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let done = Pipeline::run(&run, &limb, Until::Eval)?;
    let made = Made::of(&run, &limb, &done, extent == Extent::Everything)?;
    let (report, log) = assemble(&made, extent, start)?;
    let folder = args.scene.results.join(&run.scene.name).join("report");
    let paths = write_report(&folder, &report)?;
    figures::write_surface(&folder.join("rigidity.glb"), &limb, &done)?;
    log.append_to(&args.scene.results.join("metrics.json"))?;
    summary::print(&report);
    for path in paths.iter().rev().take(3) {
        println!("{}", path.display());
    }
    Ok(report)
}

/// How much of the paper is made.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Extent {
    /// The demo's report.
    Demo,
    /// The same as a reproduction, with its metrics.
    Tables,
    /// With what needs nets of its own.
    Everything,
}

/// Everything that the report says, and its metrics.
fn assemble(
    made: &Made<'_>,
    extent: Extent,
    start: Instant,
) -> Result<(Report, MetricLog<std::io::Stdout>)> {
    let run = made.run;
    let table2 = contents::table2(made);
    let mut claims = table1_claims(&made.table1);
    claims.extend(claims::claims(made));
    let mut stages = facts::stage_times(made.done, &made.stages);
    let n_cached = stages.iter().filter(|stage| stage.cached).count();
    let wall_s = start.elapsed().as_secs_f64();
    let mut log = facts::log(run.scene.seed);
    match extent {
        Extent::Demo => summary::log_demo(&mut log, made, &table2, wall_s)?,
        _ => summary::log_repro(&mut log, made, &claims, n_cached, wall_s)?,
    }
    // the times of a frame in each ablation are no stages
    stages.extend(made.ablations.iter().flat_map(Ablations::times));
    let mut figures = figures::figures(made)?;
    let report = Report {
        summary: summary::first(&run.profile.name, &claims, &table2, &mut figures),
        title: format!("hapdef: {}", run.scene.name),
        scene: run.scene.name.clone(),
        profile: run.profile.name.clone(),
        seed: run.scene.seed,
        facts: facts::facts(made),
        tables: contents::tables(made, &table2, &claims)?,
        figures,
        limbs: vec![figures::limb_view(made.limb, made.done)?],
        stages,
        skipped: facts::skipped(run, extent == Extent::Everything),
        hashes: facts::hashes(run, made.limb, made.done),
        metrics: log.records().to_vec(),
    };
    Ok((report, log))
}

/// The run's own cache key for work of this crate: the keys of what it reads.
fn keys_of(run: &Run, done: &Pipeline) -> serde_json::Value {
    let nets = done.nets.iter().flat_map(|nets| &nets.nets).map(|net| net.stage.key.as_str());
    let data = done.data.iter().flat_map(|data| &data.simulated).map(|stage| stage.key.as_str());
    serde_json::json!({
        "nets": nets.collect::<Vec<_>>(),
        "datasets": data.collect::<Vec<_>>(),
        "seed": run.scene.seed,
    })
}
