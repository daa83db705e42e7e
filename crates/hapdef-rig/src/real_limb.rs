//! The limb behind the gauges: another mesh, perturbed, solved once per gauge.

use std::time::Instant;

use hapdef_mesh::{ClosestPoint, GaugeId, HeldSolid, MeshError, Tet10Mesh};
use hapdef_sim::{
    ElasticModel, ElasticParams, FactorInfo, GaugeResponse, LoadedLimb, NodalLoad, PressedSkin,
    SolveInfo, Supports,
};
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::RigError;
use crate::field::SmoothField;
use crate::misplace::misplaced_gauges;
use crate::nominal_limb::{NominalLimb, NominalLoads};
use crate::params::{GainParams, RigParams};
use crate::warp::vary_thickness;

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
    skin: PressedSkin,
    loads: Vec<NodalLoad>,
    response: GaugeResponse,
    gains: Vec<f64>,
    tip_radius_m: f64,
    projection: Option<Projection>,
    info: RealLimbInfo,
}

/// Takes places from another mesh of the limb onto this one's skin.
struct Projection {
    skin: ClosestPoint,
    max_off_skin_m: f64,
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
        let HeldSolid { mesh, clamped, flange, skin, n_straightened } =
            finer(nominal, params.refinements)?;
        let varied = vary_thickness(&mesh, &skin, &params.thickness, params.max_wall_m)?;
        let mesh = varied.mesh;
        let gauges = misplaced_gauges(&mesh, nominal, &params.misplacement)?;
        let elastic = ElasticParams {
            element_stiffness_scale: Some(stiffness_scale(&mesh, params)),
            supports: Supports::of_rigid_body(&flange),
            n_threads,
            ..ElasticParams::new(nominal.material, clamped)
        };
        let elastic_model = ElasticModel::build(&mesh, &elastic)?;
        let (response, solve) = elastic_model.response(&gauges)?;
        let NominalLoads { loads, flange_point_m, expansion_per_k, .. } = nominal.loads;
        let material = nominal.material;
        let loaded =
            LoadedLimb { mesh: &mesh, material, expansion_per_k, flange: &flange, flange_point_m };
        let loads: Vec<NodalLoad> =
            loads.iter().map(|load| loaded.unit(*load)).collect::<Result<_, _>>()?;
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
        let projection = params.max_off_skin_m.map(|max_off_skin_m| -> Result<_, MeshError> {
            let skin = ClosestPoint::of_surface(&skin.surface(&mesh)?);
            Ok(Projection { skin, max_off_skin_m })
        });
        Ok(Self {
            projection: projection.transpose()?,
            skin: PressedSkin::new(&mesh, &skin)?,
            loads,
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
    /// [`RigError::Sim`] when the tip does not touch the skin there; [`RigError::OffSkin`].
    pub fn response_ue_per_n(
        &self,
        position: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Result<Vec<f64>, RigError> {
        self.response_under_tip_ue_per_n(position, direction, self.tip_radius_m)
    }

    /// The same under another tip, of `tip_radius_m`.
    ///
    /// # Errors
    /// As [`RealLimb::response_ue_per_n`].
    pub fn response_under_tip_ue_per_n(
        &self,
        position: &Point3<f64>,
        direction: &Vector3<f64>,
        tip_radius_m: f64,
    ) -> Result<Vec<f64>, RigError> {
        let position = self.on_skin(position)?;
        Ok(self.readings_ue(&self.skin.load(&position, tip_radius_m, direction)?))
    }

    /// Gauge strains for one unit of each load on the whole limb, gains included `[n_loads, n_gauges]`, µε.
    #[must_use]
    pub fn load_responses_ue(&self) -> Vec<f64> {
        self.loads.iter().flat_map(|load| self.readings_ue(load)).collect()
    }

    fn readings_ue(&self, load: &NodalLoad) -> Vec<f64> {
        let strain = |gauge| self.response.reading(GaugeId::from_index(gauge), load);
        self.gains.iter().enumerate().map(|(gauge, gain)| gain * strain(gauge) * 1e6).collect()
    }

    /// Gauge strains per newton along x, y and z under the tip at `position`, gains included,
    /// `[n_gauges]`, µε/N.
    ///
    /// # Errors
    /// As [`RealLimb::response_ue_per_n`].
    pub fn columns_ue_per_n(&self, position: &Point3<f64>) -> Result<Vec<Vector3<f64>>, RigError> {
        let position = self.on_skin(position)?;
        let load = self.skin.load(&position, self.tip_radius_m, &Vector3::x())?;
        let column = |gauge: usize| {
            let field = self.response.field(GaugeId::from_index(gauge));
            let forces = load.forces_n.iter();
            let sum: Vector3<f64> = forces.map(|(n, force)| field[n.index()] * force.x).sum();
            sum.map(|strain| self.gains[gauge] * strain * 1e6)
        };
        Ok((0..self.gains.len()).map(column).collect())
    }

    fn on_skin(&self, position: &Point3<f64>) -> Result<Point3<f64>, RigError> {
        let Some(projection) = &self.projection else {
            return Ok(*position);
        };
        let nearest = projection.skin.nearest(position);
        let off_m = nearest.map_or(f64::INFINITY, |nearest| nearest.distance_m);
        nearest
            .filter(|nearest| nearest.distance_m <= projection.max_off_skin_m)
            .map(|nearest| nearest.point)
            .ok_or(RigError::OffSkin {
                at_m: position.coords.into(),
                off_mm: off_m * 1e3,
                most_mm: projection.max_off_skin_m * 1e3,
            })
    }

    /// What building took.
    #[must_use]
    pub fn info(&self) -> &RealLimbInfo {
        &self.info
    }
}

/// The nominal limb on a finer mesh.
fn finer(nominal: &NominalLimb<'_>, refinements: u32) -> Result<HeldSolid, MeshError> {
    let own = HeldSolid {
        mesh: nominal.mesh.clone(),
        clamped: nominal.clamped.to_vec(),
        flange: nominal.loads.flange.to_vec(),
        skin: nominal.skin.clone(),
        n_straightened: 0,
    };
    (0..refinements).try_fold(own, |solid, _| solid.refined())
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
    (0..n_gauges).map(|_| 1.0 + rng.random_range(-params.fraction..=params.fraction)).collect()
}
