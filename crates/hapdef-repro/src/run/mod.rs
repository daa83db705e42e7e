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
mod patches;
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
use hapdef::convergence::ConvergenceParams;
use hapdef::stages;
use hapdef::{Limb, Pipeline, Run, Stage, Until};
use hapdef_cli::SceneArgs;
use hapdef_report::{MetricLog, Report, write_report, write_text};

use self::ablation_table::{Ablations, ablation_table};
pub(crate) use self::cli::Cli;
use self::cli::{CheckResultsArgs, Command, GoldenArgs, ReproArgs};
use self::frames::Frames;
use self::patches::SizePoint;
use self::ridge::RidgeRows;
use self::singles::Singles;
use self::summary::Printed;
use self::svr::SvrScore;
use crate::report::{Golden, check_results, results_markdown};
use crate::tables::{Table1, table1_claims};
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
    let report = report(&args.scene, extent)?;
    if let Some(path) = &args.results {
        write_text(path, &results_markdown(&report))?;
    }
    if let Some(path) = &args.metrics {
        let json = serde_json::to_string_pretty(&report.metrics).context("metrics as JSON")?;
        write_text(path, &format!("{json}\n"))?;
    }
    Ok(())
}

fn check_results_page(args: &CheckResultsArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let report = serde_json::from_str(&read(&args.report)?).context("the report")?;
    let page = read(&args.results)?;
    check_results(&page, &report, &facts::amounts(&run))?;
    println!("{} is about what the code makes", args.results.display());
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

fn report(args: &SceneArgs, extent: Extent) -> Result<Report> {
    let start = Instant::now();
    let run = args.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let done = Pipeline::run(&run, &limb, Until::Eval)?;
    let (report, log) = assemble(&run, &limb, &done, extent, start)?;
    let folder = args.out.join(&run.scene.name).join("report");
    let paths = write_report(&folder, &report)?;
    figures::write_surface(&folder.join("rigidity.glb"), &limb, &done)?;
    log.append_to(&args.out.join("metrics.json"))?;
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

/// What was measured, before it is judged and drawn.
struct Parts {
    table1: Vec<Table1>,
    svr: SvrScore,
    /// Whether the limb's mesh is fine enough, in words.
    mesh_check: String,
    singles: Singles,
    frames: Frames,
    sizes: Option<Vec<SizePoint>>,
    /// Rows that only the whole reproduction has.
    ablations: Option<Ablations>,
    ridge: Option<RidgeRows>,
    stages: Vec<Stage>,
}

/// Runs every stage of this crate that is not in the cache.
fn measure(run: &Run, limb: &Limb, done: &Pipeline, with_nets: bool) -> Result<Parts> {
    let (table1, table1_stage) = table1::table1(run, done)?;
    let (svr, svr_stage) = svr::svr(run, done)?;
    let (mesh_check, mesh_stage) = mesh_check(run, limb)?;
    let (singles, singles_stage) = singles::singles(run, limb, done, &svr)?;
    let (frames, frames_stage) = frames::frames(run, limb, done)?;
    let mut parts = Parts {
        table1,
        svr,
        mesh_check,
        singles,
        frames,
        sizes: None,
        ablations: None,
        ridge: None,
        stages: vec![table1_stage, svr_stage, mesh_stage, singles_stage, frames_stage],
    };
    if with_nets {
        let (answers, stages) = ablation::ablations(run, limb, done)?;
        parts.singles.ablations.extend(answers);
        parts.stages.extend(stages);
        let (rows, stages) = ablation_table(run, limb, done)?;
        parts.ablations = Some(rows);
        parts.stages.extend(stages);
        let (rows, stage) = ridge::ridge(run, done)?;
        parts.ridge = Some(rows);
        parts.stages.push(stage);
        if !parts.frames.rig_double.is_empty() {
            let (points, stages) = patches::sweep(run, done)?;
            parts.stages.extend(stages);
            parts.sizes = Some(points);
        }
    }
    Ok(parts)
}

/// Everything that the report says, and its metrics.
fn assemble(
    run: &Run,
    limb: &Limb,
    done: &Pipeline,
    extent: Extent,
    start: Instant,
) -> Result<(Report, MetricLog<std::io::Stdout>)> {
    let (_, scores) = done.eval.as_ref().context("the scene was not scored")?;
    let with_nets = extent == Extent::Everything;
    let parts = measure(run, limb, done, with_nets)?;
    let chain = chain::chain(run, limb, done)?;
    let both = scores::Scores::of(&chain, &parts.frames)?;
    let table2 = contents::table2(scores, &parts.svr.stats);
    let sizes = parts.sizes.as_deref();
    let mut claims = table1_claims(&parts.table1);
    claims.extend(claims::claims(&claims::Measured {
        scores,
        singles: &parts.singles,
        both: &both,
        doubles: &parts.frames.rig_double,
        sizes,
        strongest_n: run.scene.contact.force_range_n[1],
    }));
    let figures = figures::figures(&figures::Shown {
        run,
        limb,
        done,
        chain: &chain,
        table1: &parts.table1[0],
        singles: &parts.singles,
        frames: &parts.frames,
        examples: &examples::examples(run, limb, done)?,
        sizes,
    })?;
    let mut tables = vec![contents::claims_table(&claims)?];
    tables.extend(contents::tables(&parts.table1, &table2, scores, &both, sizes)?);
    let mut report = Report {
        title: format!("hapdef: {}", run.scene.name),
        scene: run.scene.name.clone(),
        profile: run.profile.name.clone(),
        seed: run.scene.seed,
        facts: facts::facts(run, done, &parts.svr, &parts.mesh_check),
        tables,
        figures,
        limbs: vec![figures::limb_view(limb, done)?],
        stages: facts::stage_times(done, &parts.stages),
        skipped: facts::skipped(run, with_nets),
        hashes: facts::hashes(run, limb, done),
        ..Report::default()
    };
    add_reproduction(&mut report, &parts)?;
    let mut log = facts::log(run.scene.seed);
    let printed = Printed {
        table1: &parts.table1[0],
        table2: &table2,
        claims: &claims,
        done,
        n_cached: report.stages.iter().filter(|stage| stage.cached).count(),
        wall_s: facts::since_demo_s().unwrap_or_else(|| start.elapsed().as_secs_f64()),
    };
    summary::log(&mut log, &printed, extent != Extent::Demo)?;
    report.metrics = log.records().to_vec();
    Ok((report, log))
}

/// The tables that only the whole reproduction has, and the times of their frames.
fn add_reproduction(report: &mut Report, parts: &Parts) -> Result<()> {
    if let Some(ridge) = &parts.ridge {
        report.tables.push(ridge.table(&parts.table1[0])?);
    }
    if let Some(ablations) = &parts.ablations {
        report.tables.push(ablations.table()?);
        report.stages.extend(ablations.times());
    }
    Ok(())
}

/// Whether the limb's mesh is fine enough, in words.
fn mesh_check(run: &Run, limb: &Limb) -> Result<(String, Stage)> {
    let (stage, study) = stages::mesh_check(run, limb, &ConvergenceParams::default())?;
    Ok((study.in_words(limb), stage))
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
