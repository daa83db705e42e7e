//! Stage: the simulated hardware's answer to a newton at every surface node.

use std::path::Path;

use hapdef_data::{DatasetReader, DatasetWriter, TensorSpec};
use hapdef_rig::{
    GainParams, MisplacementParams, NominalLimb, RealLimb, RigParams, VariationParams,
};
use hapdef_sim::GaugeSite;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::cache::Stage;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::{RigMesh, RigSpec, VariationSpec};

const RESPONSE_FILE: &str = "response.safetensors";
const TENSOR: &str = "strain";
const VERSION: u32 = 1;

/// Builds the rig's limb on its own mesh and records its response, `[n_surface, n_gauges]`, µε/N.
///
/// # Errors
/// [`HapdefError::Rig`] when the perturbed limb can't be meshed or solved.
pub fn rig(run: &Run, limb: &Limb, compliance: &Stage) -> Result<Stage, HapdefError> {
    run.cache.stage("rig", &inputs(run, compliance), |dir| {
        run.check_stop("the rig")?;
        run.say("solving the simulated real limb on its refined, perturbed mesh");
        let real = real_limb(run, limb, &limb.sites)?;
        write_response(
            &dir.join(RESPONSE_FILE),
            &unit_responses(limb, &real)?,
            limb,
        )?;
        let info = real.info();
        Ok(json!({
            "simulated": true,
            "n_fe_nodes": info.n_fe_nodes,
            "n_elements": info.n_elements,
            "n_straightened_elements": info.n_straightened,
            "n_held_nodes": info.n_held_nodes,
            "n_equations": info.factor.n_equations,
            "nnz_l": info.factor.nnz_l,
            "factor_s": info.factor.factor_s,
            "worst_relative_residual": info.solve.worst_relative_residual,
        }))
    })
}

/// The rig's limb with `gauges` glued on, perturbed as the scene says.
///
/// # Errors
/// [`HapdefError::Rig`] when the perturbed limb can't be meshed or solved.
pub fn real_limb(run: &Run, limb: &Limb, gauges: &[GaugeSite]) -> Result<RealLimb, HapdefError> {
    let nominal = NominalLimb {
        mesh: &limb.mesh,
        clamped: &limb.clamped,
        material: limb.material,
        gauges,
        gauge_params: limb.gauge_params,
        skin: &limb.skin,
        tip_radius_m: run.scene.contact.tip_radius_m,
    };
    Ok(RealLimb::build(
        &nominal,
        &rig_params(&run.scene.rig),
        run.threads,
    )?)
}

/// Reads the response `[n_surface, n_gauges]`, µε/N.
pub(crate) fn read_response(stage_dir: &Path, limb: &Limb) -> Result<Vec<f32>, HapdefError> {
    let mut reader = DatasetReader::open(&stage_dir.join(RESPONSE_FILE))?;
    let mut rows = vec![0.0; limb.n_surface_nodes() * limb.gauges.len()];
    reader.read_rows(TENSOR, 0..limb.n_surface_nodes(), &mut rows)?;
    Ok(rows)
}

fn unit_responses(limb: &Limb, real: &RealLimb) -> Result<Vec<f32>, HapdefError> {
    let points = limb.surface_points();
    let rows: Result<Vec<Vec<f64>>, _> = points
        .par_iter()
        .zip(&limb.directions)
        .map(|(point, direction)| real.response_ue_per_n(point, direction))
        .collect();
    Ok(rows?
        .into_iter()
        .flatten()
        .map(|strain| strain as f32)
        .collect())
}

fn write_response(path: &Path, rows: &[f32], limb: &Limb) -> Result<(), HapdefError> {
    let spec = TensorSpec::f32(TENSOR, limb.gauges.len(), "µε/N");
    let mut writer = DatasetWriter::create(path, limb.n_surface_nodes(), &[spec])?;
    writer.append(TENSOR, rows)?;
    writer.finish()?;
    Ok(())
}

fn inputs(run: &Run, compliance: &Stage) -> Value {
    let rig = &run.scene.rig;
    json!({
        "version": VERSION,
        "limb": compliance.key,
        "mesh": rig.mesh,
        "stiffness": rig.stiffness,
        "thickness": rig.thickness,
        "max_wall_m": rig.max_wall_m,
        "misplacement": rig.misplacement,
        "gain": rig.gain,
    })
}

fn rig_params(rig: &RigSpec) -> RigParams {
    let variation = |spec: &VariationSpec| VariationParams {
        fraction: spec.fraction,
        correlation_length_m: spec.correlation_length_m,
        seed: spec.seed,
    };
    let RigMesh::Refined { times } = rig.mesh;
    RigParams {
        refinements: times,
        stiffness: variation(&rig.stiffness),
        thickness: variation(&rig.thickness),
        max_wall_m: rig.max_wall_m,
        misplacement: MisplacementParams {
            shift_m: rig.misplacement.shift_m,
            turn_rad: rig.misplacement.turn_deg.to_radians(),
            seed: rig.misplacement.seed,
        },
        gain: GainParams {
            fraction: rig.gain.fraction,
            seed: rig.gain.seed,
        },
    }
}
