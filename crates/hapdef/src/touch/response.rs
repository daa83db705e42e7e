//! The response map of a scene's limb.

use hapdef_inverse::{OtherLoads, ResponseMap, Skin, SkinFaces, SkinParams, TipMeans};
use hapdef_mesh::{FeNodeId, GaugeId};
use hapdef_sim::GaugeResponse;
use nalgebra::Vector3;

use super::learned_loads::scene_loads;
use super::model::LimbModel;
use super::other_loads;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;

/// Readings of the scene's gauges per newton, µε/N, smooth over the touchable skin, under a tip of
/// `tip_radius_m`: one factorisation and one adjoint solve for each gauge.
///
/// Normal forces act along the scene's direction of contacts.
///
/// # Errors
/// [`HapdefError::Sim`] when the limb floats or can't be solved.
pub fn response_map(
    limb: &Limb,
    tip_radius_m: f64,
    threads: usize,
) -> Result<ResponseMap, HapdefError> {
    let model = LimbModel::build(limb, threads)?;
    let gauges = model.gauges(&limb.sites, &limb.gauges)?;
    let (adjoint, _) = model.fields(&gauges)?;
    TouchedSkin::new(limb, tip_radius_m)?.map(gauges.len(), &adjoint)
}

/// The same for a scene, with its loads that are no contacts: those it learned, else by the same solves.
///
/// # Errors
/// As [`response_map`]; [`HapdefError::LearnedLoads`], [`HapdefError::ShellTemperature`].
pub fn response_with_loads(
    run: &Run,
    limb: &Limb,
) -> Result<(ResponseMap, OtherLoads), HapdefError> {
    let model = LimbModel::build(limb, run.threads)?;
    let gauges = model.gauges(&limb.sites, &limb.gauges)?;
    let (response, _) = model.response(&gauges)?;
    let loads = scene_loads(run, |spec, error| {
        other_loads::of_response(&model, &gauges, &response, spec, error)
    })?;
    let skin = TouchedSkin::new(limb, run.scene.contact.tip_radius_m)?;
    Ok((skin.map(gauges.len(), &model.fields_of(&gauges, &response))?, loads))
}

/// Adjoint fields at `nodes` `[n_nodes, n_gauges]`, µε/N.
pub(super) fn node_values(nodes: &[FeNodeId], response: &GaugeResponse) -> Vec<Vector3<f64>> {
    let at = |node: FeNodeId| {
        (0..response.n_gauges())
            .map(move |gauge| response.field(GaugeId::from_index(gauge))[node.index()] * 1e6)
    };
    nodes.iter().copied().flat_map(at).collect()
}

/// A limb's touchable skin under a tip, for the maps of several fields.
pub(super) struct TouchedSkin {
    skin: Skin,
    tips: TipMeans,
}

impl TouchedSkin {
    pub(super) fn new(limb: &Limb, tip_radius_m: f64) -> Result<Self, HapdefError> {
        let skin = touchable_skin(limb)?;
        let tips = TipMeans::new(&skin, tip_radius_m)?;
        Ok(Self { skin, tips })
    }

    /// The map of adjoint fields on the skin `[n_surface, n_gauges]`.
    pub(super) fn map(
        &self,
        n_gauges: usize,
        adjoint: &[Vector3<f64>],
    ) -> Result<ResponseMap, HapdefError> {
        let skin = self.skin.clone();
        Ok(ResponseMap::under_tips(skin, n_gauges, adjoint, &self.tips)?)
    }
}

/// The scene's skin with the directions of contacts as its normals.
///
/// # Errors
/// [`HapdefError::Inverse`] for a skin with a face of no area.
pub fn touchable_skin(limb: &Limb) -> Result<Skin, HapdefError> {
    let place = |node| limb.skin.nodes.partition_point(|other| *other < node) as u32;
    let faces: Vec<[u32; 6]> = limb.skin.faces.iter().map(|f| f.nodes.map(place)).collect();
    let outward: Vec<Vector3<f64>> = limb.directions.iter().map(|d| -d).collect();
    Ok(Skin::new(
        limb.surface_points(),
        SkinFaces::Quadratic(&faces),
        Some(&outward),
        &SkinParams::default(),
    )?)
}
