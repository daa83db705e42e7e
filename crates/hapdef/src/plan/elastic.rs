//! The elastic models ahead: the limb's own and the rig's.

use std::time::Instant;

use hapdef_mesh::{FeNodeId, Tet10Mesh, refine_unfolded};
use hapdef_sim::{ElasticModel, ElasticParams, FactorEstimate};

use super::{PlanStep, Skip};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::stages::rig_solid;

/// What a factorisation of the limb would take, and how long its ordering took, s.
pub(super) fn limb_estimate(run: &Run, limb: &Limb) -> Result<(FactorEstimate, f64), HapdefError> {
    ordered(run, limb, &limb.mesh, limb.clamped.clone())
}

/// The same of the rig's mesh, reading or refining it included.
pub(super) fn rig_estimate(run: &Run, limb: &Limb) -> Result<(FactorEstimate, f64), HapdefError> {
    let start = Instant::now();
    let (mesh, clamped) = match rig_solid(run)? {
        Some(own) => (own.mesh, own.clamped),
        None => (limb.mesh.clone(), limb.clamped.clone()),
    };
    let times = run.scene.rig.mesh.refinements();
    refined_estimate(run, limb, mesh, clamped, times, start)
}

/// The same of the limb's mesh, every element cut into eight `times` over, the cutting included.
pub(super) fn fine_estimate(
    run: &Run,
    limb: &Limb,
    times: u32,
) -> Result<(FactorEstimate, f64), HapdefError> {
    let (mesh, clamped) = (limb.mesh.clone(), limb.clamped.clone());
    refined_estimate(run, limb, mesh, clamped, times, Instant::now())
}

/// Right-hand sides that the scene leaves out: nodes that are held or not touched, directions that
/// no contact pushes.
pub(super) fn left_out_loads(limb: &Limb) -> [PlanStep; 2] {
    let (n, n_surface) = (limb.mesh.nodes().len(), limb.n_surface_nodes());
    let mut clamped = limb.clamped.clone();
    clamped.sort_unstable();
    clamped.dedup();
    [
        PlanStep::skipped(
            Skip::UntouchedNodes,
            "loads on nodes that nothing touches",
            "nodes held by the mount or outside contact.region become no right-hand sides",
            &[("nodes", n - n_surface), ("clamped nodes", clamped.len())],
        ),
        PlanStep::skipped(
            Skip::TangentialLoads,
            "tangential loads",
            "normal forces only: one right-hand side for each surface node instead of three",
            &[("right-hand sides", 2 * n_surface)],
        ),
    ]
}

/// A mesh refined and ordered, the time since `start`.
fn refined_estimate(
    run: &Run,
    limb: &Limb,
    mut mesh: Tet10Mesh,
    mut clamped: Vec<FeNodeId>,
    times: u32,
    start: Instant,
) -> Result<(FactorEstimate, f64), HapdefError> {
    for _ in 0..times {
        let refined = refine_unfolded(&mesh)?;
        clamped = refined.node_set(&clamped);
        mesh = refined.mesh;
    }
    let (estimate, _) = ordered(run, limb, &mesh, clamped)?;
    Ok((estimate, start.elapsed().as_secs_f64()))
}

fn ordered(
    run: &Run,
    limb: &Limb,
    mesh: &Tet10Mesh,
    clamped: Vec<FeNodeId>,
) -> Result<(FactorEstimate, f64), HapdefError> {
    let params =
        ElasticParams { n_threads: run.threads, ..ElasticParams::new(limb.material, clamped) };
    let start = Instant::now();
    let estimate = ElasticModel::estimate(mesh, &params)?;
    Ok((estimate, start.elapsed().as_secs_f64()))
}
