//! Stage: factor the limb once, solve one right-hand side per surface node.

use hapdef_bench::stats;
use hapdef_mesh::GaugeId;
use hapdef_report::peak_rss_gib;
use hapdef_sim::{LinearFunctional, NodalLoad};
use serde_json::json;

use super::keys;
use crate::cache::Stage;
use crate::compliance::ComplianceTable;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::WallSolver;
use crate::touch::LimbModel;
use crate::wall_shell::WallShell;
use crate::work::Work;

/// Name of the table in the stage's folder.
pub(crate) const COMPLIANCE_FILE: &str = "compliance.safetensors";

/// Raise when this stage's results change for unchanged inputs.
const VERSION: u32 = 1;

/// Makes the compliance table of the scene's limb.
///
/// Only what the networks read is kept: the surface nodes and the virtual gauges; only what the
/// scene may press is solved: one direction per surface node.
///
/// # Errors
/// [`HapdefError::Sim`] when the limb floats or the factorisation fails.
pub fn compliance(run: &Run, limb: &Limb) -> Result<Stage, HapdefError> {
    let mut inputs = json!({ "version": VERSION, "limb": keys::limb(&run.scene, &limb.deck_hash) });
    if limb.shell.is_some() {
        inputs["solver"] = json!(WallSolver::Shell);
    }
    run.cache.stage("compliance", &inputs, |dir| {
        run.say(&format!(
            "solving the limb: {} FE nodes, {} loads",
            limb.mesh.nodes().len(),
            limb.n_surface_nodes()
        ));
        let limb_model = LimbModel::build(limb, run.threads)?;
        let elastic_model = &limb_model.model;
        let loads = limb.unit_loads(run.scene.contact.tip_radius_m)?;
        let wanted = limb.wanted_nodes();
        let (compliance, solve) = limb_model.compliance(&loads, &wanted)?;
        let gauges = limb_model.gauges(&limb.sites, &limb.gauges)?;
        let gauges: Vec<LinearFunctional> = gauges.into_iter().flatten().collect();
        let (response, adjoint) = elastic_model.response(&gauges)?;
        let in_model: Vec<NodalLoad> = loads.iter().map(|load| limb_model.load(load)).collect();
        let table = ComplianceTable::new(limb.n_surface_nodes(), wanted.len(), compliance.data());
        table.write(&dir.join(COMPLIANCE_FILE))?;
        let factor = elastic_model.info();
        Ok(json!({
            "n_fe_nodes": factor.n_fe_nodes,
            "n_elements": limb.shell.as_ref().map_or(limb.mesh.elements().len(), WallShell::n_triangles),
            "n_equations": factor.n_equations,
            "nnz_l": factor.nnz_l,
            "solver": elastic_model.solver_info().to_string(),
            "condition": solve.condition,
            "forward_error_bound": solve.forward_error_bound(),
            "assemble_s": factor.assemble_s,
            "order_s": factor.order_s,
            "factor_s": factor.factor_s,
            "n_loads": loads.len(),
            "n_wanted_nodes": wanted.len(),
            "compliance_s": solve.elapsed_s,
            "worst_relative_residual": solve.worst_relative_residual,
            "peak_rss_gib": peak_rss_gib(),
            "adjoint_s": adjoint.elapsed_s,
            "median_best_gauge_ue_per_n": median_best_gauge(&response, &in_model, gauges.len()),
            "work": Work::compliance(
                factor, limb.n_surface_nodes(), limb.gauges.len(), wanted.len()
            ).done(run.threads),
            "median_self_compliance_um_per_n": stats::median(table.self_compliance_um_per_n()),
        }))
    })
}

/// The same, read into memory.
///
/// # Errors
/// As [`compliance`], and [`HapdefError::Data`] for a damaged table.
pub fn compliance_table(run: &Run, limb: &Limb) -> Result<ComplianceTable, HapdefError> {
    let path = compliance(run, limb)?.dir.join(COMPLIANCE_FILE);
    ComplianceTable::read(&path, limb.n_surface_nodes())
}

/// Median over the surface nodes of the strongest gauge's strain per newton, µε/N.
fn median_best_gauge(
    response: &hapdef_sim::GaugeResponse,
    loads: &[NodalLoad],
    n_gauges: usize,
) -> f64 {
    let best = |load| {
        (0..n_gauges)
            .map(|g| response.reading(GaugeId::from_index(g), load).abs() * 1e6)
            .fold(0.0_f64, f64::max)
    };
    stats::median(loads.iter().map(best))
}
