//! What changes a limb's response: gauges moved and turned, parts of the limb stiffer or softer.
//! Each is a map of its own, the derivative of the response with respect to the cause.

use hapdef_inverse::{ModeMap, ModeScope, ResponseMap};
use hapdef_mesh::{FeNodeId, GaugeId, farthest_nodes};
use hapdef_sim::{
    ComplianceParams, ElasticModel, ElasticParams, GaugeResponse, GaugeSite, GaugeStrain,
    NodalLoad, SimError, stiffness,
};
use nalgebra::{Point3, Vector3};

use super::fine::FineLimb;
use super::glued::{Gauges, Glued};
use super::response::{TouchedSkin, skin_values};
use super::shell::SkinShell;
use crate::error::HapdefError;
use crate::limb::Limb;

/// Width of a stiffness mode, m.
const MODE_WIDTH_M: f64 = 0.025;

/// Elements whose stiffness changes by less than this share don't count.
const LEAST_WEIGHT: f64 = 1e-4;

/// Standard deviations before any press: a gauge's place, m, its angle, rad, and the stiffness of a
/// part of the limb.
const PRIOR_SHIFT_M: f64 = 7e-4;
const PRIOR_TURN_RAD: f64 = 0.035;
const PRIOR_STIFFNESS: f64 = 0.07;

/// The response of a scene's gauges with what may change it.
#[derive(Clone, Debug)]
pub struct UncertainResponse {
    /// µε/N.
    pub map: ResponseMap,
    /// Every gauge moved along its axis and across it, per metre, and turned, per radian.
    pub gauge_modes: [ResponseMap; 3],
    /// Parts of the limb made stiffer, per unit of relative change.
    pub stiffness_modes: Vec<ResponseMap>,
}

impl UncertainResponse {
    /// Solves for `gauges` at `sites`: the map on the limb's mesh or a finer one, its gauge modes,
    /// and as many stiffness modes as `n_stiffness`, bumps of 25 mm spread over the skin, on the
    /// limb's mesh.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] when the limb floats or can't be solved; [`HapdefError::Inverse`].
    pub fn solve(
        limb: &Limb,
        sites: &[GaugeSite],
        gauges: &[GaugeStrain],
        params: &UncertainParams,
    ) -> Result<Self, HapdefError> {
        let elastic = ElasticParams {
            n_threads: params.n_threads,
            ..ElasticParams::new(limb.material, limb.clamped.clone())
        };
        let model = ElasticModel::build(&limb.mesh, &elastic)?;
        let (response, _) = model.response(gauges)?;
        let skin = TouchedSkin::new(limb, params.tip_radius_m)?;
        let on_skin = |adjoint: &[Vector3<f64>]| skin.map(gauges.len(), adjoint);
        let solid = Solid { limb, model: &model };
        let stiffness = solid.stiffness_modes(&response, params.n_stiffness)?;
        let map = if params.refinements == 0 {
            on_skin(&skin_values(limb, &response))?
        } else {
            FineLimb::new(limb, params.refinements)?.map(
                sites,
                params.tip_radius_m,
                params.n_threads,
            )?
        };
        Ok(Self {
            map,
            gauge_modes: Gauges { wall: &solid, sites, on_solid: gauges, on_wall: gauges }
                .modes(|adjoint| on_skin(adjoint))?,
            stiffness_modes: stiffness
                .iter()
                .map(|adjoint| on_skin(adjoint))
                .collect::<Result<_, _>>()?,
        })
    }

    /// The same on a shell of the limb's skin, with the median thickness of the wall behind it, of
    /// material up to `max_wall_m` thick: ribs and rings are left out, and so are stiffness modes.
    /// A gauge on a rib, where the shell has no wall, has no response.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] where the skin has no wall behind it; [`HapdefError::Sim`];
    /// [`HapdefError::Inverse`].
    pub fn solve_shell(
        limb: &Limb,
        sites: &[GaugeSite],
        gauges: &[GaugeStrain],
        max_wall_m: f64,
        params: &UncertainParams,
    ) -> Result<Self, HapdefError> {
        let shell = SkinShell::new(limb, max_wall_m, params.n_threads)?;
        let on_shell = sites.iter().map(|site| shell.gauge(site));
        let on_shell: Vec<_> = on_shell.collect::<Result<_, _>>()?;
        let skin = TouchedSkin::new(limb, params.tip_radius_m)?;
        let on_skin = |adjoint: &[Vector3<f64>]| skin.map(gauges.len(), adjoint);
        Ok(Self {
            map: on_skin(&shell.fields(&on_shell)?)?,
            gauge_modes: Gauges { wall: &shell, sites, on_solid: gauges, on_wall: &on_shell }
                .modes(|adjoint| on_skin(adjoint))?,
            stiffness_modes: Vec::new(),
        })
    }

    /// The modes with what is known of them before any press.
    #[must_use]
    pub fn modes(&self) -> Vec<ModeMap<'_>> {
        let gauge_sds = [PRIOR_SHIFT_M, PRIOR_SHIFT_M, PRIOR_TURN_RAD];
        let of_gauges = self.gauge_modes.iter().zip(gauge_sds);
        let of_limb = self.stiffness_modes.iter();
        let each =
            of_gauges.map(|(map, prior_sd)| ModeMap { map, scope: ModeScope::EachGauge, prior_sd });
        let shared =
            of_limb.map(|map| ModeMap { map, scope: ModeScope::Shared, prior_sd: PRIOR_STIFFNESS });
        each.chain(shared).collect()
    }
}

/// How a response and its modes are solved for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertainParams {
    /// Radius of the tip, m.
    pub tip_radius_m: f64,
    /// Refinements of the limb's mesh for the map: each cuts an element into eight. The modes are
    /// solved for on the limb's own mesh.
    pub refinements: u32,
    /// Stiffness modes.
    pub n_stiffness: usize,
    /// Threads.
    pub n_threads: usize,
}

/// A limb's own mesh, solved.
struct Solid<'a> {
    limb: &'a Limb,
    model: &'a ElasticModel,
}

impl Glued for Solid<'_> {
    type Gauge = GaugeStrain;

    fn glued(&self, site: &GaugeSite) -> Option<GaugeStrain> {
        let limb = self.limb;
        let faces = &limb.boundary.faces;
        GaugeStrain::with_params(&limb.mesh, faces, site, &limb.gauge_params).ok()
    }

    fn fields(&self, gauges: &[GaugeStrain]) -> Result<Vec<Vector3<f64>>, HapdefError> {
        let (response, _) = self.model.response(gauges)?;
        Ok(skin_values(self.limb, &response))
    }
}

impl Solid<'_> {
    /// ∂/∂s of the adjoint fields K⁻¹ c for stiffness 1 + s b(x): −K⁻¹ K_b K⁻¹ c, one solve for each
    /// bump b and gauge; each `[n_surface, n_gauges]`, µε/N.
    fn stiffness_modes(
        &self,
        response: &GaugeResponse,
        n_modes: usize,
    ) -> Result<Vec<Vec<Vector3<f64>>>, HapdefError> {
        let limb = self.limb;
        let centres = farthest_nodes(&limb.mesh, &limb.skin.nodes, n_modes);
        let n_gauges = response.n_gauges();
        let forces = element_forces(limb, response)?;
        let loads: Vec<NodalLoad> = centres
            .iter()
            .flat_map(|centre| {
                let weights = bump(limb, &limb.mesh.position(*centre));
                let load = |of_gauge: &Vec<Vector3<f64>>| weighted(limb, of_gauge, &weights);
                forces.iter().map(load).collect::<Vec<_>>()
            })
            .collect();
        let params = ComplianceParams::default();
        let (solved, _) = self.model.compliance(&loads, &limb.skin.nodes, &params)?;
        let mode = |k: usize| {
            let nodes = 0..limb.skin.nodes.len();
            let at = |node| {
                let gauges = k * n_gauges..(k + 1) * n_gauges;
                gauges.map(move |load| (load, node))
            };
            nodes.flat_map(at).map(|(load, node)| solved.displacement(load, node) * 1e6).collect()
        };
        Ok((0..centres.len()).map(mode).collect())
    }
}

/// A Gaussian of the elements' distance from `centre` `[n_elements]`.
fn bump(limb: &Limb, centre: &Point3<f64>) -> Vec<f64> {
    let weight = |element: &[FeNodeId; 10]| {
        let corners = element[..4].iter().map(|n| limb.mesh.position(*n).coords);
        let x = Point3::from(corners.sum::<Vector3<f64>>() / 4.0);
        (-0.5 * (x - centre).norm_squared() / MODE_WIDTH_M.powi(2)).exp()
    };
    limb.mesh.elements().iter().map(weight).collect()
}

/// −Σ w K_e λ as a load.
fn weighted(limb: &Limb, forces: &[Vector3<f64>], weights: &[f64]) -> NodalLoad {
    let mut sums = vec![Vector3::zeros(); limb.mesh.nodes().len()];
    for (e, element) in limb.mesh.elements().iter().enumerate() {
        if weights[e] >= LEAST_WEIGHT {
            for (i, node) in element.iter().enumerate() {
                sums[node.index()] -= forces[10 * e + i] * weights[e];
            }
        }
    }
    let loaded = sums.into_iter().enumerate();
    NodalLoad {
        forces_n: loaded
            .filter(|(_, force)| force.norm_squared() > 0.0)
            .map(|(node, force)| (FeNodeId::from_index(node), force))
            .collect(),
        ..NodalLoad::default()
    }
}

/// K_e λ of every element, `[n_gauges][n_elements × 10]`.
fn element_forces(
    limb: &Limb,
    response: &GaugeResponse,
) -> Result<Vec<Vec<Vector3<f64>>>, HapdefError> {
    let mut forces = vec![Vec::new(); response.n_gauges()];
    for (e, element) in limb.mesh.elements().iter().enumerate() {
        let nodes = element.map(|node| limb.mesh.position(node));
        let k = stiffness(&nodes, &limb.material).map_err(|at| SimError::ElementInverted {
            element: e,
            parent: at.parent,
            det_j_m3: at.det_j_m3,
        })?;
        for (gauge, forces) in forces.iter_mut().enumerate() {
            let field = response.field(GaugeId::from_index(gauge));
            let force = |i: usize, c: usize| {
                (0..30).map(|j| k[3 * i + c][j] * field[element[j / 3].index()][j % 3]).sum::<f64>()
            };
            forces.extend((0..10).map(|i| Vector3::from_fn(|c, _| force(i, c))));
        }
    }
    Ok(forces)
}
