//! One simulated rig with the gauges of several layouts: the response of each, and maps calibrated with presses.

use std::collections::HashMap;
use std::ops::Range;
use std::time::Instant;

use anyhow::{Context, Result};
use hapdef::touch::{
    LayoutCandidates, LayoutParams, PlacedGauge, UncertainParams, UncertainResponse, touchable_skin,
};
use hapdef::{Limb, Run};
use hapdef_sim::{GaugeSite, GaugeStrain};
use serde::{Deserialize, Serialize};

use super::cells::Map;
use super::world::{Frame, World};

/// Stiffness modes of a calibration.
const N_STIFFNESS: usize = 32;

/// Where the gauges are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Layout {
    /// The scene's own.
    Scene,
    /// So many by greedy log-det.
    Greedy(usize),
}

/// Refinements of the limb's own mesh behind a response; none for a shell of its skin.
pub(crate) type Mesh = Option<u32>;

/// The rig, and what is made once on it. With each response and map stands the time that it took, s.
pub(crate) struct Rig<'a> {
    run: &'a Run,
    limb: &'a Limb,
    pub(crate) world: World,
    layouts: HashMap<Layout, Placed>,
    responses: HashMap<(Mesh, Layout), (UncertainResponse, f64)>,
    maps: HashMap<(Mesh, Layout, usize), (Map, f64)>,
}

/// The gauges of a layout.
struct Placed {
    sites: Vec<GaugeSite>,
    gauges: Vec<GaugeStrain>,
    /// The rig's channels that they are.
    channels: Range<usize>,
}

impl<'a> Rig<'a> {
    /// Places the layouts, chosen gauges no nearer than `margin_m` to the edges of the wall; on the rig they
    /// follow the scene's.
    pub(crate) fn build(
        run: &'a Run,
        limb: &'a Limb,
        layouts: &[Layout],
        margin_m: f64,
    ) -> Result<Self> {
        let (layouts, further) = place(run, limb, layouts, margin_m)?;
        run.say("solving the simulated real limb");
        let world = World::build(run, limb, &touchable_skin(limb)?, &further)?;
        let (responses, maps) = (HashMap::new(), HashMap::new());
        Ok(Self { run, limb, world, layouts, responses, maps })
    }

    /// The rig's channels that a layout's gauges are.
    pub(crate) fn channels(&self, layout: Layout) -> Range<usize> {
        self.layouts[&layout].channels.clone()
    }

    /// Where a layout's gauges are, and as they read there.
    pub(crate) fn gauges(&self, layout: Layout) -> (&[GaugeSite], &[GaugeStrain]) {
        let Placed { sites, gauges, .. } = &self.layouts[&layout];
        (sites, gauges)
    }

    /// The response of a layout, solved if it is not there.
    pub(crate) fn response(
        &mut self,
        mesh: Mesh,
        layout: Layout,
    ) -> Result<&(UncertainResponse, f64)> {
        let key = (mesh, layout);
        if !self.responses.contains_key(&key) {
            let Placed { sites, gauges, .. } = &self.layouts[&layout];
            let params = UncertainParams {
                tip_radius_m: self.run.scene.contact.tip_radius_m,
                refinements: mesh.unwrap_or(0),
                n_stiffness: N_STIFFNESS,
                n_threads: self.run.threads,
            };
            let limb = self.limb;
            let response = match mesh {
                Some(_) => UncertainResponse::kept(self.run, limb, sites, gauges, &params)?,
                None => {
                    let (wall_m, start) = (limb.max_wall_m, Instant::now());
                    let shell =
                        UncertainResponse::solve_shell(limb, sites, gauges, wall_m, &params)?;
                    (shell, start.elapsed().as_secs_f64())
                }
            };
            self.responses.insert(key, response);
        }
        self.responses.get(&key).context("a response")
    }

    /// The map of a layout, calibrated with these presses if one with as many is not there.
    pub(crate) fn map(
        &mut self,
        mesh: Mesh,
        layout: Layout,
        presses: &[Frame],
    ) -> Result<&(Map, f64)> {
        let key = (mesh, layout, presses.len());
        if !self.maps.contains_key(&key) {
            let run = self.run;
            let channels = self.channels(layout);
            let noise = self.world.noise(&channels)?;
            let (response, _) = self.response(mesh, layout)?;
            run.say(&format!("calibrating with {} presses", presses.len()));
            let start = Instant::now();
            let map = Map::calibrate(response, presses, channels, noise, run.threads)?;
            self.maps.insert(key, (map, start.elapsed().as_secs_f64()));
        }
        self.maps.get(&key).context("a map")
    }
}

/// Places every layout; the sites of the chosen ones.
fn place(
    run: &Run,
    limb: &Limb,
    layouts: &[Layout],
    margin_m: f64,
) -> Result<(HashMap<Layout, Placed>, Vec<GaugeSite>)> {
    let n_chosen = |layout: &Layout| match layout {
        Layout::Scene => 0,
        Layout::Greedy(n) => *n,
    };
    let params = LayoutParams {
        n_gauges: layouts.iter().map(n_chosen).max().unwrap_or(0),
        margin_m,
        noise_ue: run.scene.rig.electronics.noise_ue,
        seed: run.scene.seed,
        ..LayoutParams::default()
    };
    let is_chosen = params.n_gauges > 0;
    let places = is_chosen.then(|| LayoutCandidates::solve(run, limb, &params)).transpose()?;
    let glued = |placed: PlacedGauge| -> Result<(GaugeSite, GaugeStrain)> {
        let site = run.scene.gauges.site(placed.position_m, placed.axis);
        let faces = &limb.boundary.faces;
        let gauge = GaugeStrain::with_params(&limb.mesh, faces, &site, &limb.gauge_params)?;
        Ok((site, gauge))
    };
    let (mut placed, mut further) = (HashMap::new(), Vec::new());
    for &layout in layouts {
        let (sites, gauges, first) = match layout {
            Layout::Scene => (limb.sites.clone(), limb.gauges.clone(), 0),
            Layout::Greedy(n) => {
                run.say(&format!("placing {n} gauges"));
                let places = places.as_ref().context("candidates of a chosen layout")?;
                let chosen = places.recommended(n)?.into_iter().map(glued);
                let (sites, gauges): (Vec<_>, Vec<_>) = chosen.collect::<Result<_>>()?;
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
