//! What configurations are measured with: one simulated rig with the gauges of every layout, its presses and
//! frames, and the maps that several configurations share.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use hapdef::touch::estimator_params;
use hapdef::{Limb, Run};
use hapdef_inverse::{
    ContactEstimator, EstimatorParams, LocatedContact, ModelError, NoiseParams, ScanSites,
};

use super::configuration::{Configuration, LAYOUTS};
use super::frames::Frames;
use crate::compare::frontier::EFFORTS;
use crate::compare::paper::TrueMaps;
use crate::compare::rig::Rig;

/// The rig, its frames, and what configurations share.
pub(super) struct Lab<'a> {
    pub(super) run: &'a Run,
    pub(super) limb: &'a Limb,
    rig: Rig<'a>,
    pub(super) frames: Frames,
    pub(super) maps_of: TrueMaps,
}

/// An estimator and what it took to make it.
pub(super) struct Ready {
    pub(super) estimator: ContactEstimator,
    pub(super) channels: Range<usize>,
    pub(super) design: Design,
}

/// Times at design, s.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Design {
    /// The response and what may change it, or the compliance and the rig.
    pub(super) solve_s: f64,
    /// The calibration, or the training.
    pub(super) learn_s: f64,
    /// Everything that a frame needs ready at hand.
    pub(super) prepare_s: f64,
}

impl Design {
    pub(super) fn all_s(&self) -> f64 {
        self.solve_s + self.learn_s + self.prepare_s
    }
}

impl<'a> Lab<'a> {
    pub(super) fn build(
        run: &'a Run,
        limb: &'a Limb,
        test_seed: u64,
        n_frames: usize,
    ) -> Result<Self> {
        let maps_of = TrueMaps::read(run, limb)?;
        let rig = Rig::build(run, limb, &LAYOUTS, 0.0)?;
        let frames = Frames::draw(&rig.world, &run.scene, test_seed, n_frames)?;
        Ok(Self { run, limb, rig, frames, maps_of })
    }

    /// Makes the estimator of a configuration; what it shares with others is made once.
    pub(super) fn ready(&mut self, configuration: &Configuration) -> Result<Ready> {
        self.ready_for(configuration, self.run.scene.contact.max_contacts)
    }

    /// The same for a scene that wants at most so many contacts.
    pub(super) fn ready_for(
        &mut self,
        configuration: &Configuration,
        max_contacts: usize,
    ) -> Result<Ready> {
        let Configuration { layout, presses, .. } = *configuration;
        let mesh = configuration.mesh.refinements();
        let (_, solve_s) = *self.rig.response(mesh, layout)?;
        let channels = self.rig.channels(layout);
        let effort = &EFFORTS[configuration.effort];
        let usual = estimator_params(&self.run.scene);
        let params = EstimatorParams { max_contacts, ..(effort.params)(usual) };
        let sites = |skin: &_| ScanSites::farthest(skin, effort.n_sites).map(Arc::new);
        let (start, learn_s, estimator);
        if presses > 0 {
            let (map, elapsed_s) = self.rig.map(mesh, layout, &self.frames.presses[..presses])?;
            (start, learn_s) = (Instant::now(), *elapsed_s);
            estimator = map.estimator_at(&sites(map.calibrated.map.skin())?, params)?;
        } else {
            let noise = self.rig.world.noise(&channels)?;
            let (response, _) = self.rig.response(mesh, layout)?;
            (start, learn_s) = (Instant::now(), 0.0);
            let relative = self.run.scene.estimator.superposition().map_error;
            let model_error = ModelError { relative, ..ModelError::default() };
            let noise = NoiseParams { model_error, ..noise };
            let (map, sites) = (Arc::new(response.map.clone()), sites(response.map.skin())?);
            estimator = ContactEstimator::new(map, sites, noise, params)?;
        }
        let design = Design { solve_s, learn_s, prepare_s: start.elapsed().as_secs_f64() };
        Ok(Ready { estimator, channels, design })
    }
}

/// Displacement of the surface under contacts that were found `[n_surface]`, µm.
pub(super) fn found_um(maps: &TrueMaps, contacts: &[LocatedContact]) -> Vec<f32> {
    let [surface_um, _] = maps.under(contacts.iter().map(|c| (c.point, c.force_n)));
    surface_um
}
