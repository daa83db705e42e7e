//! One mesh of a convergence study.

use std::time::Instant;

use hapdef_mesh::{FeNodeId, GaugeId, SkinRegion, Tet10Mesh, farthest_nodes, refine_unfolded};
use hapdef_sim::{ElasticModel, ElasticParams, GaugeStrain, NodalLoad};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::ConvergenceParams;
use crate::error::HapdefError;
use crate::limb::Limb;

/// A mesh, what it cost, and what it answered.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct MeshLevel {
    /// FE nodes.
    pub n_fe_nodes: usize,
    /// Elements.
    pub n_elements: usize,
    /// Equations.
    pub n_equations: usize,
    /// Elements of the coarser mesh that were straightened because they folded.
    pub n_straightened: usize,
    /// Seconds to mesh, assemble, order and factor.
    pub build_s: f64,
    /// Seconds for one adjoint solve per gauge.
    pub adjoint_s: f64,
    /// Gauge strains for a newton on the tip `[n_presses][n_gauges]`, µε/N.
    pub reading_ue_per_n: Vec<Vec<f64>>,
    /// Displacement under the tip along the force, weighted with the tip's pressure
    /// `[n_presses]`, µm/N.
    pub tip_um_per_n: Vec<f64>,
    /// Displacement of the node under a point force, magnitude `[n_presses]`, µm/N.
    pub point_um_per_n: Vec<f64>,
}

/// The meshes of a study, made one from the other.
pub(super) struct Levels<'a> {
    pub(super) limb: &'a Limb,
    pub(super) params: &'a ConvergenceParams,
    presses: Vec<(FeNodeId, Vector3<f64>)>,
}

struct Refined {
    mesh: Tet10Mesh,
    clamped: Vec<FeNodeId>,
    skin: SkinRegion,
    n_straightened: usize,
}

impl<'a> Levels<'a> {
    pub(super) fn new(limb: &'a Limb, params: &'a ConvergenceParams) -> Self {
        let chosen = farthest_nodes(&limb.mesh, &limb.skin.nodes, params.n_presses);
        let direction = |node: &FeNodeId| {
            let at = limb.skin.nodes.iter().position(|n| n == node)?;
            Some((*node, limb.directions[at]))
        };
        Self { limb, params, presses: chosen.iter().filter_map(direction).collect() }
    }

    pub(super) fn solve(&self, say: &dyn Fn(&str)) -> Result<Vec<MeshLevel>, HapdefError> {
        let mut mesh = self.own();
        let mut levels = Vec::new();
        loop {
            say(&format!("solving the mesh of {} FE nodes", mesh.mesh.nodes().len()));
            levels.push(self.level(&mesh)?);
            if levels.len() > self.params.refinements {
                return Ok(levels);
            }
            mesh = finer(&mesh)?;
        }
    }

    /// The mesh of the scene.
    fn own(&self) -> Refined {
        let Limb { mesh, clamped, skin, .. } = self.limb;
        let (mesh, clamped, skin) = (mesh.clone(), clamped.clone(), skin.clone());
        Refined { mesh, clamped, skin, n_straightened: 0 }
    }

    /// A newton of the tip at each press, on the mesh of the scene.
    ///
    /// # Errors
    /// [`HapdefError::Sim`].
    pub(super) fn own_tip_loads(&self) -> Result<Vec<NodalLoad>, HapdefError> {
        self.tip_loads(&self.own())
    }

    fn level(&self, refined: &Refined) -> Result<MeshLevel, HapdefError> {
        let started = Instant::now();
        let mesh = &refined.mesh;
        let elastic = ElasticParams {
            n_threads: self.params.n_threads,
            ..ElasticParams::new(self.limb.material, refined.clamped.clone())
        };
        let elastic_model = ElasticModel::build(mesh, &elastic)?;
        let build_s = started.elapsed().as_secs_f64();
        let faces = mesh.boundary().faces;
        let place = |site| GaugeStrain::with_params(mesh, &faces, site, &self.limb.gauge_params);
        let gauges: Vec<GaugeStrain> =
            self.limb.sites.iter().map(place).collect::<Result<_, _>>()?;
        let (response, adjoint) = elastic_model.response(&gauges)?;
        let tip_loads = self.tip_loads(refined)?;
        let reading = |load: &NodalLoad| {
            let of = |gauge| response.reading(GaugeId::from_index(gauge), load) * 1e6;
            (0..gauges.len()).map(of).collect()
        };
        let mut tip_um_per_n = Vec::new();
        let mut point_um_per_n = Vec::new();
        for (load, (node, direction)) in tip_loads.iter().zip(&self.presses) {
            let (under_tip, _) = elastic_model.solve(load)?;
            tip_um_per_n.push(load.work_j(&under_tip)? * 1e6);
            let point = NodalLoad::nodal(*node, *direction);
            let (under_point, _) = elastic_model.solve(&point)?;
            point_um_per_n.push(under_point[node.index()].norm() * 1e6);
        }
        Ok(MeshLevel {
            n_fe_nodes: mesh.nodes().len(),
            n_elements: mesh.elements().len(),
            n_equations: elastic_model.info().n_equations,
            n_straightened: refined.n_straightened,
            build_s,
            adjoint_s: adjoint.elapsed_s,
            reading_ue_per_n: tip_loads.iter().map(reading).collect(),
            tip_um_per_n,
            point_um_per_n,
        })
    }

    /// A newton of the tip at each press; old nodes keep their number when a mesh is refined, and
    /// the tip stays where the scene's mesh has the node.
    fn tip_loads(&self, refined: &Refined) -> Result<Vec<NodalLoad>, HapdefError> {
        let load = |(node, direction): &(FeNodeId, Vector3<f64>)| {
            let centre = self.limb.mesh.position(*node);
            let radius_m = self.params.tip_radius_m;
            NodalLoad::patch(&refined.mesh, &refined.skin, &centre, radius_m, direction)
        };
        Ok(self.presses.iter().map(load).collect::<Result<_, _>>()?)
    }
}

fn finer(coarse: &Refined) -> Result<Refined, HapdefError> {
    let refined = refine_unfolded(&coarse.mesh)?;
    Ok(Refined {
        clamped: refined.node_set(&coarse.clamped),
        skin: SkinRegion::new(&refined.mesh, refined.faces(&coarse.skin.faces))?,
        n_straightened: refined.n_straightened,
        mesh: refined.mesh,
    })
}
