//! One mesh of a convergence study.

use std::time::Instant;

use hapdef_mesh::{FeNodeId, HeldSolid, farthest_nodes};
use hapdef_sim::{
    ElasticModel, ElasticParams, GaugeSite, GaugeStrain, IsotropicMaterial, NodalLoad, PressedSkin,
    SolverKind, Supports,
};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::ConvergenceParams;
use super::answers::Answers;
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

/// Presses on the meshes of a limb, made one from the other.
pub(crate) struct Levels<'a> {
    pub(crate) limb: &'a Limb,
    pub(crate) material: IsotropicMaterial,
    pub(crate) sites: Vec<GaugeSite>,
    /// Nodes of the limb's skin and the forces' directions there.
    pub(crate) presses: Vec<(FeNodeId, Vector3<f64>)>,
    pub(crate) tip_radius_m: f64,
    /// Presses whose displacement under the tip is solved.
    pub(crate) n_tips: usize,
    /// The same at most where a mesh is too large to be factored: each press then takes an iteration.
    pub(crate) n_iterated_tips: usize,
    /// Presses that are done with a point, too.
    pub(crate) n_points: usize,
    pub(crate) n_threads: usize,
}

impl<'a> Levels<'a> {
    pub(super) fn new(limb: &'a Limb, params: &ConvergenceParams) -> Self {
        let chosen = farthest_nodes(&limb.mesh, &limb.skin.nodes, params.n_presses);
        let direction = |node: &FeNodeId| {
            let at = limb.skin.nodes.iter().position(|n| n == node)?;
            Some((*node, limb.directions[at]))
        };
        let presses: Vec<_> = chosen.iter().filter_map(direction).collect();
        Self {
            limb,
            material: limb.material,
            sites: limb.sites.clone(),
            tip_radius_m: params.tip_radius_m,
            n_tips: presses.len(),
            n_iterated_tips: presses.len(),
            n_points: presses.len(),
            n_threads: params.n_threads,
            presses,
        }
    }

    /// The limb's own mesh and `refinements` finer ones.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] and [`HapdefError::Sim`] where one can't be made or solved.
    pub(crate) fn solve(
        &self,
        refinements: usize,
        say: &dyn Fn(&str),
    ) -> Result<Vec<MeshLevel>, HapdefError> {
        let mut mesh = self.limb.held_solid();
        let (mut levels, mut n_straightened) = (Vec::new(), 0);
        loop {
            say(&format!("solving the mesh of {} FE nodes", mesh.mesh.nodes().len()));
            levels.push(self.level(&mesh, n_straightened)?);
            if levels.len() > refinements {
                return Ok(levels);
            }
            let finer = mesh.refined()?;
            n_straightened = finer.n_straightened - mesh.n_straightened;
            mesh = finer;
        }
    }

    /// A newton of the tip at each press, on the mesh of the scene.
    ///
    /// # Errors
    /// [`HapdefError::Sim`].
    pub(super) fn own_tip_loads(&self) -> Result<Vec<NodalLoad>, HapdefError> {
        self.tip_loads(&self.limb.held_solid())
    }

    fn level(&self, solid: &HeldSolid, n_straightened: usize) -> Result<MeshLevel, HapdefError> {
        let started = Instant::now();
        let mesh = &solid.mesh;
        let elastic = ElasticParams {
            supports: Supports::of_rigid_body(&solid.flange),
            n_threads: self.n_threads,
            ..ElasticParams::new(self.material, solid.clamped.clone())
        };
        let elastic_model = ElasticModel::build(mesh, &elastic)?;
        let build_s = started.elapsed().as_secs_f64();
        let faces = mesh.boundary().faces;
        let place = |site| GaugeStrain::with_params(mesh, &faces, site, &self.limb.gauge_params);
        let gauges: Vec<GaugeStrain> = self.sites.iter().map(place).collect::<Result<_, _>>()?;
        let n_tips = match elastic_model.solver_info().kind {
            SolverKind::Direct => self.n_tips,
            SolverKind::Iterative => self.n_tips.min(self.n_iterated_tips),
        };
        let answers = Answers::of(&elastic_model, &gauges, &self.tip_loads(solid)?, n_tips)?;
        let under_point = |(node, direction): &(FeNodeId, Vector3<f64>)| {
            let (moved, _) = elastic_model.solve(&NodalLoad::nodal(*node, *direction))?;
            Ok::<_, HapdefError>(moved[node.index()].norm() * 1e6)
        };
        Ok(MeshLevel {
            n_fe_nodes: mesh.nodes().len(),
            n_elements: mesh.elements().len(),
            n_equations: elastic_model.info().n_equations,
            n_straightened,
            build_s,
            adjoint_s: answers.adjoint_s,
            reading_ue_per_n: answers.reading_ue_per_n,
            tip_um_per_n: answers.tip_um_per_n,
            point_um_per_n: self.presses[..self.n_points]
                .iter()
                .map(under_point)
                .collect::<Result<_, _>>()?,
        })
    }

    /// A newton of the tip at each press; old nodes keep their number when a mesh is refined, and
    /// the tip stays where the scene's mesh has the node.
    fn tip_loads(&self, solid: &HeldSolid) -> Result<Vec<NodalLoad>, HapdefError> {
        let skin = PressedSkin::new(&solid.mesh, &solid.skin)?;
        let load = |(node, direction): &(FeNodeId, Vector3<f64>)| {
            skin.load(&self.limb.mesh.position(*node), self.tip_radius_m, direction)
        };
        Ok(self.presses.iter().map(load).collect::<Result<_, _>>()?)
    }
}
