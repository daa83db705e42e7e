//! Stage: the simulated hardware's answer to a newton at every surface node.

use std::path::{Path, PathBuf};

use hapdef_data::{DatasetReader, DatasetWriter, TensorSpec};
use hapdef_rig::{
    GainParams, MisplacementParams, NominalLimb, NominalLoads, RealLimb, RigParams, VariationParams,
};
use hapdef_sim::{GaugeSite, LimbLoad};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::keys;
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::limb::{Limb, place_gauges};
use crate::run::Run;
use crate::scene::{RigMesh, RigSpec, VariationSpec};
use crate::solid::{Solid, deck_hash};
use crate::work::{Work, WorkKind};

const RESPONSE_FILE: &str = "response.safetensors";
const TENSOR: &str = "strain";
const VERSION: u32 = 1;

/// How far a place on the limb's skin may be from that of the rig's own mesh, m: both follow the same
/// drawing, curved faces and rims each in their own way.
const MAX_OFF_SKIN_M: f64 = 1e-3;

/// Builds the rig's limb on its own mesh and records its response, `[n_surface, n_gauges]`, µε/N.
///
/// # Errors
/// [`HapdefError::Rig`] when the perturbed limb can't be meshed or solved.
pub fn rig(run: &Run, limb: &Limb, compliance: &Stage) -> Result<Stage, HapdefError> {
    let inputs = json!({ "version": VERSION, "limb": compliance.key, "rig": rig_key(run)? });
    run.cache.stage("rig", &inputs, |dir| {
        run.check_stop("the rig")?;
        run.say("solving the simulated real limb on its own, perturbed mesh");
        let real = real_limb(run, limb, &limb.sites)?;
        write_response(&dir.join(RESPONSE_FILE), &unit_responses(limb, &real)?, limb)?;
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
            "work": Work::elastic(WorkKind::Rig, &info.factor, limb.gauges.len()).done(run.threads),
        }))
    })
}

/// The rig's limb with `gauges` glued on, perturbed as the scene says: the limb's mesh refined, or
/// the rig's own, on which mount, skin and gauges are found anew.
///
/// # Errors
/// [`HapdefError::Rig`] when the perturbed limb can't be meshed or solved; [`HapdefError::NoDeck`]
/// and [`HapdefError::RigDeck`] for the rig's own deck.
pub fn real_limb(run: &Run, limb: &Limb, gauges: &[GaugeSite]) -> Result<RealLimb, HapdefError> {
    let own = rig_solid(run)?;
    let spec = run.scene.loads.clone().unwrap_or_default();
    let wanted: Vec<LimbLoad> = spec.loads().into_iter().map(|(load, _)| load).collect();
    let nominal = NominalLimb {
        mesh: own.as_ref().map_or(&limb.mesh, |own| &own.mesh),
        clamped: own.as_ref().map_or(&limb.clamped, |own| &own.clamped),
        material: limb.material,
        gauges,
        gauge_params: limb.gauge_params,
        skin: own.as_ref().map_or(&limb.skin, |own| &own.skin),
        tip_radius_m: run.scene.contact.tip_radius_m,
        loads: NominalLoads {
            loads: &wanted,
            flange: own.as_ref().map_or(&limb.flange, |own| &own.flange),
            flange_point_m: limb.loaded(&spec).flange_point_m,
            expansion_per_k: spec.expansion_per_k,
        },
    };
    Ok(RealLimb::build(&nominal, &rig_params(&run.scene.rig, limb.max_wall_m), run.threads)?)
}

/// The rig's own mesh, not refined, with mount and skin; none where it is the limb's refined.
///
/// # Errors
/// [`HapdefError::NoDeck`] when the deck can't be read, [`HapdefError::RigDeck`] when it can't be
/// used.
pub(crate) fn rig_solid(run: &Run) -> Result<Option<Solid>, HapdefError> {
    let Some(path) = rig_deck(run) else {
        return Ok(None);
    };
    Solid::of_deck(&run.scene, &path).map(Some).map_err(of_rig(&path))
}

/// FE nodes and elements of the rig's own mesh, on which mount, contact region and gauges have been
/// found, without solving anything; none where the rig's mesh is the limb's refined.
///
/// # Errors
/// [`HapdefError::NoDeck`] when its deck can't be read, [`HapdefError::RigDeck`] when something is
/// not found on it, and [`HapdefError::RigDeckIsLimb`] when it is the limb's mesh itself.
pub fn check_rig_mesh(run: &Run, limb: &Limb) -> Result<Option<[usize; 2]>, HapdefError> {
    let (Some(path), Some(own)) = (rig_deck(run), rig_solid(run)?) else {
        return Ok(None);
    };
    let is_cut_as_often = run.scene.rig.mesh.refinements() == run.scene.geometry.refinements;
    if own.hash == limb.deck_hash && is_cut_as_often {
        return Err(HapdefError::RigDeckIsLimb { path });
    }
    place_gauges(&run.scene, &limb.sites, &own.mesh, &own.boundary).map_err(of_rig(&path))?;
    Ok(Some([own.mesh.nodes().len(), own.mesh.elements().len()]))
}

/// Path of the rig's own deck, if it has one.
fn rig_deck(run: &Run) -> Option<PathBuf> {
    match &run.scene.rig.mesh {
        RigMesh::Refined { .. } => None,
        RigMesh::Deck { solid_deck, .. } => Some(run.scene_dir.join(solid_deck)),
    }
}

/// Says that an error concerns the rig's own deck at `path`.
fn of_rig(path: &Path) -> impl Fn(HapdefError) -> HapdefError {
    let path = path.to_path_buf();
    move |error| match error {
        HapdefError::NoDeck { path, source, .. } => {
            HapdefError::NoDeck { field: "rig.mesh.solid_deck", path, source }
        }
        other => HapdefError::RigDeck { path: path.clone(), source: Box::new(other) },
    }
}

/// What sets the rig's limb apart, its own deck's bytes included, for the keys of stages.
///
/// # Errors
/// [`HapdefError::NoDeck`] when the deck can't be read.
pub(crate) fn rig_key(run: &Run) -> Result<Value, HapdefError> {
    let own_deck = rig_deck(run).map(|path| deck_hash(&path).map_err(of_rig(&path))).transpose()?;
    Ok(keys::rig(&run.scene, own_deck.as_deref()))
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
    Ok(rows?.into_iter().flatten().map(|strain| strain as f32).collect())
}

fn write_response(path: &Path, rows: &[f32], limb: &Limb) -> Result<(), HapdefError> {
    let spec = TensorSpec::f32(TENSOR, limb.gauges.len(), "µε/N");
    let mut writer = DatasetWriter::create(path, limb.n_surface_nodes(), &[spec])?;
    writer.append(TENSOR, rows)?;
    writer.finish()?;
    Ok(())
}

fn rig_params(rig: &RigSpec, max_wall_m: f64) -> RigParams {
    let variation = |spec: &VariationSpec| VariationParams {
        fraction: spec.fraction,
        correlation_length_m: spec.correlation_length_m,
        seed: spec.seed,
    };
    let max_off_skin_m = match rig.mesh {
        RigMesh::Refined { .. } => None,
        RigMesh::Deck { .. } => Some(MAX_OFF_SKIN_M),
    };
    RigParams {
        refinements: rig.mesh.refinements(),
        max_off_skin_m,
        stiffness: variation(&rig.stiffness),
        thickness: variation(&rig.thickness),
        max_wall_m,
        misplacement: MisplacementParams {
            shift_m: rig.misplacement.shift_m,
            turn_rad: rig.misplacement.turn_deg.to_radians(),
            seed: rig.misplacement.seed,
        },
        gain: GainParams { fraction: rig.gain.fraction, seed: rig.gain.seed },
    }
}
