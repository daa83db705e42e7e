//! What configurations are measured with: one simulated rig with the gauges of every layout, its presses and
//! frames, and the maps that several configurations share.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result};
use hapdef::touch::{UncertainParams, UncertainResponse, estimator_params};
use hapdef::{Limb, Run};
use hapdef_inverse::{
    ContactEstimator, EstimatorParams, LocatedContact, ModelError, NoiseParams, ScanSites,
};
use hapdef_sim::{GaugeSite, GaugeStrain};

use super::configuration::{Configuration, LAYOUTS, Layout, MOST_GAUGES, Mesh};
use super::frames::Frames;
use crate::compare::cells::Map;
use crate::compare::frontier::EFFORTS;
use crate::compare::paper::TrueMaps;
use crate::compare::world::World;
use crate::compare::{N_STIFFNESS, gauge_places, placed_gauges};

/// The rig, its frames, and what configurations share.
pub(super) struct Lab<'a> {
    pub(super) run: &'a Run,
    pub(super) limb: &'a Limb,
    layouts: HashMap<Layout, Placed>,
    /// What several share, and the time that it took to make it, s.
    responses: HashMap<(Mesh, Layout), (UncertainResponse, f64)>,
    maps: HashMap<(Mesh, Layout, usize), (Map, f64)>,
    world: World,
    pub(super) frames: Frames,
    pub(super) maps_of: TrueMaps,
}

struct Placed {
    sites: Vec<GaugeSite>,
    gauges: Vec<GaugeStrain>,
    /// The rig's channels that they are.
    channels: Range<usize>,
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
        let (layouts, further) = place(run, limb)?;
        let maps_of = TrueMaps::read(run, limb)?;
        run.say("solving the simulated real limb");
        let world = World::build(run, limb, maps_of.skin(), &further)?;
        let frames = Frames::draw(&world, &run.scene, test_seed, n_frames)?;
        Ok(Self {
            run,
            limb,
            layouts,
            responses: HashMap::new(),
            maps: HashMap::new(),
            world,
            frames,
            maps_of,
        })
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
        let solve_s = self.solve(configuration)?;
        let learn_s = self.calibrate(configuration)?;
        let channels = self.layouts[&configuration.layout].channels.clone();
        let start = Instant::now();
        let estimator = self.estimator(configuration, &channels, max_contacts)?;
        Ok(Ready {
            estimator,
            channels,
            design: Design { solve_s, learn_s, prepare_s: start.elapsed().as_secs_f64() },
        })
    }

    fn estimator(
        &self,
        configuration: &Configuration,
        channels: &Range<usize>,
        max_contacts: usize,
    ) -> Result<ContactEstimator> {
        let effort = &EFFORTS[configuration.effort];
        let usual = estimator_params(&self.run.scene);
        let params = EstimatorParams { max_contacts, ..(effort.params)(usual) };
        let map = &self.responses[&(configuration.mesh, configuration.layout)].0.map;
        let sites = Arc::new(ScanSites::farthest(map.skin(), effort.n_sites)?);
        let key = (configuration.mesh, configuration.layout, configuration.presses);
        if let Some((known, _)) = self.maps.get(&key) {
            return known.estimator_at(&sites, params);
        }
        let noise = NoiseParams {
            model_error: ModelError {
                relative: self.run.scene.estimator.superposition().map_error,
                ..ModelError::default()
            },
            ..self.world.noise(channels)?
        };
        let map = Arc::new(map.clone());
        Ok(ContactEstimator::new(map, sites, noise, params)?)
    }

    /// Solves the response of a configuration unless it is there; the time that it took.
    fn solve(&mut self, configuration: &Configuration) -> Result<f64> {
        let key = (configuration.mesh, configuration.layout);
        if !self.responses.contains_key(&key) {
            let placed = self.layouts.get(&configuration.layout).context("a layout is missing")?;
            let params = UncertainParams {
                tip_radius_m: self.run.scene.contact.tip_radius_m,
                refinements: u32::from(configuration.mesh == Mesh::Refined),
                n_stiffness: N_STIFFNESS,
                n_threads: self.run.threads,
            };
            self.run.say(&format!("solving: {}", configuration.name()));
            let start = Instant::now();
            let (sites, gauges) = (&placed.sites, &placed.gauges);
            let response = match configuration.mesh {
                Mesh::Solid | Mesh::Refined => {
                    UncertainResponse::solve(self.limb, sites, gauges, &params)?
                }
                Mesh::Shell => {
                    let max_wall_m = self.limb.max_wall_m;
                    UncertainResponse::solve_shell(self.limb, sites, gauges, max_wall_m, &params)?
                }
            };
            self.responses.insert(key, (response, start.elapsed().as_secs_f64()));
        }
        Ok(self.responses[&key].1)
    }

    /// Calibrates the map of a configuration unless that is done; the time that it took, 0 without presses.
    fn calibrate(&mut self, configuration: &Configuration) -> Result<f64> {
        let key = (configuration.mesh, configuration.layout, configuration.presses);
        if configuration.presses > 0 && !self.maps.contains_key(&key) {
            let channels = self.layouts[&configuration.layout].channels.clone();
            let noise = self.world.noise(&channels)?;
            let (run, presses) = (self.run, &self.frames.presses[..configuration.presses]);
            let response = &self.responses[&(configuration.mesh, configuration.layout)].0;
            run.say(&format!("calibrating: {}", configuration.name()));
            let start = Instant::now();
            let map = Map::calibrate(response, presses, channels, noise, run.threads)?;
            self.maps.insert(key, (map, start.elapsed().as_secs_f64()));
        }
        Ok(self.maps.get(&key).map_or(0.0, |(_, elapsed_s)| *elapsed_s))
    }
}

/// Displacement of the surface under contacts that were found `[n_surface]`, µm.
pub(super) fn found_um(maps: &TrueMaps, contacts: &[LocatedContact]) -> Vec<f32> {
    let [surface_um, _] = maps.under(contacts.iter().map(|c| (c.point, c.force_n)));
    surface_um
}

/// Places every layout; the sites of the chosen ones follow the scene's on the rig.
fn place(run: &Run, limb: &Limb) -> Result<(HashMap<Layout, Placed>, Vec<GaugeSite>)> {
    let mut placed = HashMap::new();
    let mut further = Vec::new();
    let places = gauge_places(run, limb, MOST_GAUGES, 0.0)?;
    for layout in LAYOUTS {
        let (sites, gauges, first) = match layout {
            Layout::Scene => (limb.sites.clone(), limb.gauges.clone(), 0),
            Layout::Greedy(n) => {
                run.say(&format!("placing {n} gauges"));
                let (sites, gauges) = placed_gauges(run, limb, &places, n)?;
                let first = limb.gauges.len() + further.len();
                further.extend_from_slice(&sites);
                (sites, gauges, first)
            }
        };
        let channels = first..first + gauges.len();
        let of_layout = Placed { sites, gauges, channels };
        placed.insert(layout, of_layout);
    }
    Ok((placed, further))
}
