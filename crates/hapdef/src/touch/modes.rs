//! What changes a limb's response: gauges moved and turned, parts of the limb stiffer or softer.
//! Each is a map of its own, the derivative of the response with respect to the cause.

use hapdef_inverse::{ModeMap, ModeScope, ResponseMap};
use hapdef_sim::{GaugeSite, GaugeStrain};
use nalgebra::Vector3;

use super::fine::FineLimb;
use super::glued::Gauges;
use super::model::LimbModel;
use super::response::TouchedSkin;
use super::shell::even_shell;
use super::stiffness::stiffness_modes;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;

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
        let model = LimbModel::build(limb, params.n_threads)?;
        Self::of_model(&model, sites, gauges, params)
    }

    /// The same on a shell of the limb's skin, with the median thickness of the wall behind it, of
    /// material up to `max_wall_m` thick: ribs and rings are left out. It is not refined. A gauge on a
    /// rib, where the shell has no wall, has no response.
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
        let shell = even_shell(limb, max_wall_m)?;
        let model = LimbModel::of_shell(limb, &shell, params.n_threads)?;
        let params = UncertainParams { refinements: 0, n_stiffness: 0, ..*params };
        Self::of_model(&model, sites, gauges, &params)
    }

    fn of_model(
        model: &LimbModel<'_>,
        sites: &[GaugeSite],
        on_solid: &[GaugeStrain],
        params: &UncertainParams,
    ) -> Result<Self, HapdefError> {
        let (limb, tip_radius_m) = (model.limb, params.tip_radius_m);
        let in_model = &model.gauges(sites, on_solid)?;
        let skin = TouchedSkin::new(limb, tip_radius_m)?;
        let on_skin = |adjoint: &[Vector3<f64>]| skin.map(sites.len(), adjoint);
        let map = if params.refinements == 0 || model.shell.is_some() {
            on_skin(&model.fields(in_model)?.0)?
        } else {
            let fine = FineLimb::new(limb, params.refinements)?;
            fine.map(sites, tip_radius_m, params.n_threads)?
        };
        let stiffness = stiffness_modes(model, in_model, params.n_stiffness)?;
        let stiffness = stiffness.iter().map(|adjoint| on_skin(adjoint));
        Ok(Self {
            map,
            gauge_modes: Gauges { model, sites, on_solid, in_model }.modes(on_skin)?,
            stiffness_modes: stiffness.collect::<Result<_, _>>()?,
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
    /// Refinements of the limb's solid for the map: each cuts an element into eight. A shell is not
    /// refined, and the modes are solved for on the limb's own mesh.
    pub refinements: u32,
    /// Stiffness modes.
    pub n_stiffness: usize,
    /// Threads.
    pub n_threads: usize,
}

impl UncertainParams {
    /// What the scene asks for, with `n_stiffness` stiffness modes.
    pub(crate) fn of_scene(run: &Run, n_stiffness: usize) -> Self {
        Self {
            tip_radius_m: run.scene.contact.tip_radius_m,
            refinements: run.scene.estimator.map_refinements(),
            n_stiffness,
            n_threads: run.threads,
        }
    }
}
