//! The limb behind the gauges: refined, perturbed, solved once per gauge.

use std::collections::BTreeSet;
use std::time::Instant;

use hapdef_mesh::{FeNodeId, GaugeId, MeshError, SkinRegion, TET10_EDGES, Tet10Mesh, Tri6Face};
use hapdef_sim::{
    ElasticModel, ElasticParams, FactorInfo, GaugeParams, GaugeResponse, GaugeSite,
    IsotropicMaterial, NodalLoad, SolveInfo,
};
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::RigError;
use crate::field::SmoothField;
use crate::misplace::misplaced_gauges;
use crate::params::{GainParams, RigParams};
use crate::unfold::{Refined, refine_unfolded};
use crate::warp::vary_thickness;

/// The limb as it is drawn, before anything is perturbed.
pub struct NominalLimb<'a> {
    /// The training side's mesh.
    pub mesh: &'a Tet10Mesh,
    /// Nodes held fast.
    pub clamped: &'a [FeNodeId],
    /// Nominal material.
    pub material: IsotropicMaterial,
    /// Nominal gauge sites.
    pub gauges: &'a [GaugeSite],
    /// How much of a gauge may miss the wall.
    pub gauge_params: GaugeParams,
    /// The touchable skin.
    pub skin: &'a SkinRegion,
    /// Radius of the probing tip, m.
    pub tip_radius_m: f64,
}

/// What building the rig's limb took.
#[derive(Clone, Debug)]
pub struct RealLimbInfo {
    /// FE nodes of the rig's mesh.
    pub n_fe_nodes: usize,
    /// Elements of the rig's mesh.
    pub n_elements: usize,
    /// Elements of the training mesh whose edges were straightened because a part of them would
    /// have been inside out.
    pub n_straightened: usize,
    /// Nodes that kept their place when the thickness was varied, because an element at them would
    /// have turned inside out.
    pub n_held_nodes: usize,
    /// The factorisation.
    pub factor: FactorInfo,
    /// The adjoint solves.
    pub solve: SolveInfo,
    /// Wall-clock time of it all, s.
    pub elapsed_s: f64,
}

/// The simulated "real" limb: answers with strain where the hardware would.
pub struct RealLimb {
    mesh: Tet10Mesh,
    skin: SkinRegion,
    response: GaugeResponse,
    gains: Vec<f64>,
    tip_radius_m: f64,
    info: RealLimbInfo,
}

impl RealLimb {
    /// Refines and perturbs the nominal limb, factors it, and solves one adjoint per gauge.
    ///
    /// # Errors
    /// [`RigError`] when the perturbed mesh is refused, a gauge finds no place, or the solve fails.
    pub fn build(
        nominal: &NominalLimb<'_>,
        params: &RigParams,
        n_threads: usize,
    ) -> Result<Self, RigError> {
        let start = Instant::now();
        let (refined, clamped) = refined(nominal, params.refinements)?;
        let n_straightened = refined.n_straightened;
        let mesh = refined.mesh;
        let skin = refined_skin(&mesh, nominal.skin, params.refinements)?;
        let varied = vary_thickness(&mesh, &skin, &params.thickness, params.max_wall_m)?;
        let mesh = varied.mesh;
        let gauges = misplaced_gauges(
            &mesh,
            &mesh.boundary().faces,
            nominal.gauges,
            &nominal.gauge_params,
            &params.misplacement,
        )?;
        let elastic = ElasticParams {
            element_stiffness_scale: Some(stiffness_scale(&mesh, params)),
            n_threads,
            ..ElasticParams::new(nominal.material, clamped)
        };
        let elastic_model = ElasticModel::build(&mesh, &elastic)?;
        let (response, solve) = elastic_model.gauge_response(&gauges)?;
        let info = RealLimbInfo {
            n_fe_nodes: mesh.nodes().len(),
            n_elements: mesh.elements().len(),
            n_straightened,
            n_held_nodes: varied.n_held_nodes,
            factor: *elastic_model.info(),
            solve,
            elapsed_s: start.elapsed().as_secs_f64(),
        };
        let gains = draw_gains(gauges.len(), &params.gain);
        Ok(Self {
            mesh,
            skin,
            response,
            gains,
            tip_radius_m: nominal.tip_radius_m,
            info,
        })
    }

    /// Gauge strains for a unit force at `position` along `direction`, gains included,
    /// `[n_gauges]`, µε/N.
    ///
    /// # Errors
    /// [`RigError::Sim`] when the tip does not touch the skin there.
    pub fn response_ue_per_n(
        &self,
        position: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Result<Vec<f64>, RigError> {
        let load = NodalLoad::patch(
            &self.mesh,
            &self.skin,
            position,
            self.tip_radius_m,
            direction,
        )?;
        Ok((0..self.gains.len())
            .map(|gauge| {
                self.gains[gauge] * self.response.reading(GaugeId::from_index(gauge), &load) * 1e6
            })
            .collect())
    }

    /// What building took.
    #[must_use]
    pub fn info(&self) -> &RealLimbInfo {
        &self.info
    }
}

/// The refined mesh and its clamped nodes: a new node is clamped where both ends of its edge are.
fn refined(
    nominal: &NominalLimb<'_>,
    refinements: u32,
) -> Result<(Refined, Vec<FeNodeId>), MeshError> {
    let mut mesh = nominal.mesh.clone();
    let mut n_straightened = 0;
    let mut clamped = vec![false; mesh.nodes().len()];
    for node in nominal.clamped {
        clamped[node.index()] = true;
    }
    for _ in 0..refinements {
        let refined = refine_unfolded(&mesh)?;
        mesh = refined.mesh;
        n_straightened += refined.n_straightened;
        let n_old = clamped.len();
        clamped.resize(mesh.nodes().len(), false);
        for element in mesh.elements() {
            for (mid, [a, b]) in (4..).zip(TET10_EDGES) {
                let ends_clamped = [a, b]
                    .iter()
                    .all(|&end| element[end].index() < n_old && clamped[element[end].index()]);
                clamped[element[mid].index()] |= ends_clamped;
            }
        }
    }
    let nodes = (0..clamped.len())
        .filter(|&i| clamped[i])
        .map(FeNodeId::from_index);
    Ok((
        Refined {
            mesh,
            n_straightened,
        },
        nodes.collect(),
    ))
}

/// The boundary faces of the refined mesh that the faces of `skin` were cut into.
fn refined_skin(
    mesh: &Tet10Mesh,
    skin: &SkinRegion,
    refinements: u32,
) -> Result<SkinRegion, MeshError> {
    let mut faces = skin.faces.clone();
    for _ in 0..refinements {
        let pieces: BTreeSet<[FeNodeId; 3]> = faces.iter().flat_map(quarters).collect();
        let is_piece = |face: &&Tri6Face| pieces.contains(&corners(&face.nodes[..3]));
        faces = mesh
            .boundary()
            .faces
            .iter()
            .filter(is_piece)
            .copied()
            .collect();
    }
    SkinRegion::new(mesh, faces)
}

/// The corners of the four faces that uniform refinement cuts a face into.
fn quarters(face: &Tri6Face) -> [[FeNodeId; 3]; 4] {
    [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].map(|piece| corners(&piece.map(|i| face.nodes[i])))
}

fn corners(nodes: &[FeNodeId]) -> [FeNodeId; 3] {
    let mut corners = [nodes[0], nodes[1], nodes[2]];
    corners.sort_unstable();
    corners
}

fn stiffness_scale(mesh: &Tet10Mesh, params: &RigParams) -> Vec<f64> {
    let centroids: Vec<Point3<f64>> = mesh
        .elements()
        .iter()
        .map(|element| {
            let corners = element[..4].iter().map(|n| mesh.nodes()[n.index()].coords);
            Point3::from(corners.sum::<Vector3<f64>>() / 4.0)
        })
        .collect();
    let variation = SmoothField::scaled(&params.stiffness, &centroids);
    variation.iter().map(|v| 1.0 + v).collect()
}

fn draw_gains(n_gauges: usize, params: &GainParams) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(params.seed);
    (0..n_gauges)
        .map(|_| 1.0 + rng.random_range(-params.fraction..=params.fraction))
        .collect()
}
