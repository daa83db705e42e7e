//! The elastic models ahead: the limb's own and the rig's.

use hapdef_mesh::{FeNodeId, Tet10Mesh, refine_unfolded};
use hapdef_sim::{ElasticModel, ElasticParams, FactorInfo};

use super::{PlanStep, Skip};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::stages::rig_solid;
use crate::touch::model_estimate;

/// What a factorisation of the limb would take.
pub(super) fn limb_estimate(run: &Run, limb: &Limb) -> Result<FactorInfo, HapdefError> {
    model_estimate(limb, run.threads)
}

/// The same of the rig's mesh.
pub(super) fn rig_estimate(run: &Run, limb: &Limb) -> Result<FactorInfo, HapdefError> {
    let (mesh, clamped) = match rig_solid(run)? {
        Some(own) => (own.mesh, own.clamped),
        None => (limb.mesh.clone(), limb.clamped.clone()),
    };
    let times = run.scene.rig.mesh.refinements();
    refined_estimate(run, limb, mesh, clamped, times)
}

/// The same of the limb's mesh, every element cut into eight `times` over.
pub(super) fn fine_estimate(run: &Run, limb: &Limb, times: u32) -> Result<FactorInfo, HapdefError> {
    let (mesh, clamped) = (limb.mesh.clone(), limb.clamped.clone());
    refined_estimate(run, limb, mesh, clamped, times)
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

/// A mesh refined and ordered.
fn refined_estimate(
    run: &Run,
    limb: &Limb,
    mut mesh: Tet10Mesh,
    mut clamped: Vec<FeNodeId>,
    times: u32,
) -> Result<FactorInfo, HapdefError> {
    for _ in 0..times {
        let refined = refine_unfolded(&mesh)?;
        clamped = refined.node_set(&clamped);
        mesh = refined.mesh;
    }
    ordered(run, limb, &mesh, clamped)
}

fn ordered(
    run: &Run,
    limb: &Limb,
    mesh: &Tet10Mesh,
    clamped: Vec<FeNodeId>,
) -> Result<FactorInfo, HapdefError> {
    let params =
        ElasticParams { n_threads: run.threads, ..ElasticParams::new(limb.material, clamped) };
    Ok(ElasticModel::estimate(mesh, &params)?)
}
