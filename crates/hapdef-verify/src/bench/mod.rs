//! How fast the solver is, as ratios against other solvers in one run.
//!
//! Ratios against faer's plain call and CHOLMOD are ours over theirs, in processor seconds of one
//! thread on the same matrix and right-hand sides; ours include the residual of every load and the
//! collection of all wanted displacements. `fe.campaign_vs_ccx` is CalculiX's wall time for one
//! load times the number of loads, over our wall time from the deck on disk to the compliance.

mod clock;
mod others;
mod plain;
mod system;
mod wanted;

use std::collections::BTreeSet;
use std::io::Stdout;
use std::path::PathBuf;

use hapdef_mesh::{FeNodeId, SolidDeck, Tet10Mesh, read_deck};
use hapdef_report::{MetricLog, peak_rss_gib};
use hapdef_sim::{
    ComplianceParams, ElasticModel, ElasticParams, GaugeSite, GaugeStrain, IsotropicMaterial,
    NodalLoad, SolveInfo,
};
use nalgebra::{Point3, Vector3};

use self::clock::{Took, timed};
use self::system::System;
use crate::VerifyError;
use crate::ccx::ccx;
use crate::deck::build;
use crate::meshes::Blocks;
use crate::problem::n_threads;

/// What is measured.
#[derive(clap::Args)]
pub(crate) struct BenchOptions {
    /// The limb, a solid deck.
    #[arg(long, default_value = "fixtures/shin/shin.inp.gz")]
    deck: PathBuf,
    /// Loads of the campaign: unit forces at so many surface nodes, evenly spread.
    #[arg(long, default_value_t = 3255)]
    loads: usize,
    /// Threads where no other solver is compared with; all cores where left out.
    #[arg(long)]
    threads: Option<usize>,
    /// Leave the block of 300,000 equations out.
    #[arg(long)]
    skip_large: bool,
}

type Log = MetricLog<Stdout>;

/// Measures the solver on the deck.
pub(crate) fn run(options: &BenchOptions, log: &mut Log) -> Result<(), VerifyError> {
    let (deck, read) = timed(|| read_deck(&options.deck));
    let deck = deck?;
    let (model, built) = timed(|| build(&deck, options.threads.unwrap_or_else(n_threads)));
    let model = model?;
    let nodes = surface_nodes(&deck, options.loads);
    let loads = unit_loads(&nodes);
    let (solved, compliance) = timed(|| compliance(&model, &loads, &nodes));
    let forward_share = solved?.forward_factor_share;
    let info = model.info();
    for (name, value, unit) in [
        ("fe.nnz_l", info.nnz_l as f64, "1"),
        ("fe.order_s", info.order_s, "s"),
        ("fe.assemble_s", info.assemble_s, "s"),
        ("fe.factor_s", info.factor_s, "s"),
        ("fe.compliance_s", compliance.wall_s, "s"),
        ("fe.compliance_processor_s", compliance.processor_s, "s"),
        ("fe.compliance_rss_gib", peak_rss_gib().unwrap_or(f64::NAN), "GiB"),
        ("fe.forward_factor_share", forward_share, "1"),
    ] {
        log.value(name, value, unit)?;
    }
    let placed = gauges(&deck, &model, read, built, log)?;
    wanted::measure(&model, &loads, &nodes, &placed, log)?;
    campaign(&deck, nodes[0], loads.len(), [read, built, compliance], log)?;
    drop(model);
    against(&build(&deck, 1)?, &loads, &nodes, "fe", log)?;
    if !options.skip_large {
        large(log)?;
    }
    Ok(())
}

/// Up to `n` free nodes of the surface, evenly spread.
fn surface_nodes(deck: &SolidDeck, n: usize) -> Vec<FeNodeId> {
    let fixed: BTreeSet<FeNodeId> = deck.fixed_nodes.iter().copied().collect();
    let mut free = deck.mesh.boundary().nodes();
    free.retain(|node| !fixed.contains(node));
    let n = n.min(free.len());
    (0..n).map(|i| free[i * free.len() / n]).collect()
}

fn unit_loads(nodes: &[FeNodeId]) -> Vec<NodalLoad> {
    let force = Vector3::new(2.0, -1.0, 2.0) / 3.0;
    nodes.iter().map(|&node| NodalLoad::nodal(node, force)).collect()
}

fn compliance(
    model: &ElasticModel,
    loads: &[NodalLoad],
    wanted: &[FeNodeId],
) -> Result<SolveInfo, VerifyError> {
    Ok(model.compliance(loads, wanted, &ComplianceParams::default())?.1)
}

/// Ten gauges for every force at every node, from the deck on disk; 240 adjoint solves after it.
/// Returns the gauges, none where they don't fit.
fn gauges(
    deck: &SolidDeck,
    model: &ElasticModel,
    read: Took,
    build: Took,
    log: &mut Log,
) -> Result<Vec<GaugeStrain>, VerifyError> {
    let faces = deck.mesh.boundary().faces;
    let site = |face: usize| {
        let corners = [0, 1, 2].map(|i| deck.mesh.position(faces[face].nodes[i]).coords);
        GaugeSite {
            position: Point3::from((corners[0] + corners[1] + corners[2]) / 3.0),
            axis: Vector3::new(1.0, 2.0, 0.5),
            length_m: 8e-3,
            width_m: 5e-3,
        }
    };
    let tries = (0..400).map(|i| site(i * faces.len() / 400));
    let fits = |site: &GaugeSite| GaugeStrain::new(&deck.mesh, &faces, site).is_ok();
    let sites: Vec<GaugeSite> = tries.filter(fits).take(10).collect();
    if sites.len() < 10 {
        log.skipped("fe.gauges_s", "fewer than ten places where a gauge fits")?;
        return Ok(Vec::new());
    }
    let place = |site| GaugeStrain::new(&deck.mesh, &faces, site);
    let (gauges, placed) = timed(|| sites.iter().map(place).collect::<Result<Vec<_>, _>>());
    let gauges = gauges?;
    let (response, adjoint) = timed(|| model.response(&gauges));
    response?;
    let stages = [read, build, placed, adjoint];
    let names = ["fe.deck_s", "fe.build_s", "fe.place_s", "fe.adjoint_s"];
    for (name, stage) in names.into_iter().zip(stages) {
        log.value(name, stage.wall_s, "s")?;
    }
    log.value("fe.gauges_s", stages.iter().map(|s| s.wall_s).sum(), "s")?;
    log.value("fe.gauges_processor_s", stages.iter().map(|s| s.processor_s).sum(), "s")?;
    let many: Vec<GaugeStrain> = gauges.iter().cycle().take(240).cloned().collect();
    let (response, virtual_gauges) = timed(|| model.response(&many));
    response?;
    log.value("fe.virtual_gauges_s", virtual_gauges.wall_s, "s")?;
    log.value("fe.virtual_gauges_processor_s", virtual_gauges.processor_s, "s")?;
    Ok(gauges)
}

/// One CalculiX run per load, on all cores, against one factorisation for all.
fn campaign(
    deck: &SolidDeck,
    node: FeNodeId,
    n_loads: usize,
    stages: [Took; 3],
    log: &mut Log,
) -> Result<(), VerifyError> {
    let one = SolidDeck {
        nodal_forces: vec![(node, Vector3::new(2.0, -1.0, 2.0) / 3.0)],
        face_tractions: Vec::new(),
        ..deck.clone()
    };
    match ccx(&one, n_threads()) {
        Ok((run_s, _)) => {
            let ours_s: f64 = stages.iter().map(|stage| stage.wall_s).sum();
            log.value("fe.ccx_run_s", run_s, "s")?;
            log.value("fe.campaign_vs_ccx", run_s * n_loads as f64 / ours_s, "1")?;
        }
        Err(VerifyError::NotRun { reason }) => log.skipped("fe.campaign_vs_ccx", &reason)?,
        Err(error @ VerifyError::Setup { .. }) => {
            log.skipped("fe.campaign_vs_ccx", &error.to_string())?;
        }
        Err(error) => return Err(error),
    }
    Ok(())
}

/// `model`, on one thread, against faer's plain call, CHOLMOD and the dense product.
fn against(
    model: &ElasticModel,
    loads: &[NodalLoad],
    wanted: &[FeNodeId],
    prefix: &str,
    log: &mut Log,
) -> Result<(), VerifyError> {
    let name = |what: &str| format!("{prefix}.{what}");
    let (solved, solve) = timed(|| compliance(model, loads, wanted));
    solved?;
    let (order_s, factor_s) = (model.info().order_s, model.info().factor_s);
    let flops = 4.0 * model.info().nnz_l as f64 * loads.len() as f64;
    let dense = plain::dense_flops();
    log.value(&name("solve_1_processor_s"), solve.processor_s, "s")?;
    log.value(&name("factor_1_s"), factor_s, "s")?;
    log.value(&name("dense_gflops"), dense / 1e9, "GFLOP/s")?;
    log.value(&name("limit_ratio"), solve.processor_s * dense / flops, "1")?;
    let system = System::of(model, loads)?;
    match others::cholmod(&system) {
        Ok(runs) => {
            for (ordering, run) in runs {
                for (what, value, unit) in [
                    ("nnz_l", run.nnz_l, "1"),
                    ("factor_s", run.factor_s, "s"),
                    ("solve_s", run.solve_s, "s"),
                    ("residual", run.relative_residual, "1"),
                ] {
                    log.value(&name(&format!("cholmod_{ordering}_{what}")), value, unit)?;
                }
                let order = name(&format!("order_vs_cholmod_{ordering}"));
                log.value(&order, order_s / run.analyse_s, "1")?;
            }
            let best = |of: fn(&others::Cholmod) -> f64| {
                runs.iter().map(|(_, run)| of(run)).fold(f64::INFINITY, f64::min)
            };
            log.value(&name("factor_vs_cholmod"), factor_s / best(|r| r.factor_s), "1")?;
            log.value(&name("solve_vs_cholmod"), solve.processor_s / best(|r| r.solve_s), "1")?;
        }
        Err(VerifyError::NotRun { reason }) => {
            log.skipped(&name("factor_vs_cholmod"), &reason)?;
            log.skipped(&name("solve_vs_cholmod"), &reason)?;
        }
        Err(error) => return Err(error),
    }
    let plain = plain::plain(&system)?;
    let factor = (order_s + factor_s) / plain.factor.wall_s;
    log.value(&name("order_and_factor_vs_faer"), factor, "1")?;
    Ok(log.value(&name("solve_vs_faer"), solve.processor_s / plain.solve.processor_s, "1")?)
}

/// A thick plate of 304,920 equations, 240 loads.
fn large(log: &mut Log) -> Result<(), VerifyError> {
    let mesh: Tet10Mesh =
        Blocks::default().block([60, 60, 3], |p| Point3::new(p.x, p.y, 0.05 * p.z)).finish()?;
    let clamped = mesh.nodes_where(|p| p.x < 1e-9);
    let wanted = mesh.nodes_where(|p| p.x > 0.5 && p.z > 0.05 - 1e-9);
    let material = IsotropicMaterial::new(2e9, 0.35, 1000.0)?;
    let params = ElasticParams { n_threads: 1, ..ElasticParams::new(material, clamped) };
    let model = ElasticModel::build(&mesh, &params)?;
    let step = (wanted.len() / 240).max(1);
    let wanted: Vec<FeNodeId> = wanted.into_iter().step_by(step).take(240).collect();
    log.value("fe.large.n_equations", model.info().n_equations as f64, "1")?;
    log.value("fe.large.nnz_l", model.info().nnz_l as f64, "1")?;
    against(&model, &unit_loads(&wanted), &wanted, "fe.large", log)
}
