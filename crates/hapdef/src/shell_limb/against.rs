//! The same presses on a shell and on solid models of the limb.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use hapdef_mesh::{FeNodeId, PointIndex, farthest_nodes};
use hapdef_sim::{GaugeSite, LinearFunctional, NodalLoad, PressedSkin, SimError};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::ShellLimb;
use super::compare::{Answered, SceneSource, ShellComparison, ShellVerdict};
use super::limb::file_hash;
use super::maps::{ShellMaps, Tables};
use crate::convergence::{Answers, Differences, Levels};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::scene::read_scene;
use crate::touch::LimbModel;

/// Places where readings are compared, at most.
const N_TOUCHES: usize = 480;

/// A tip's load on the shell may be off its centre by this part of the tip's radius; at a rim or a
/// hole it is farther off.
const MAX_OFF_CENTRE: f64 = 0.25;

/// Presses, at most, where a solid is too large to be factored: each then takes an iteration.
const MOST_ITERATED: usize = 24;

/// Where the number of halvings is free: one, if it makes no more nodes than this.
const MAX_FE_NODES: usize = 150_000;

/// Nodes after halving all edges over nodes before, at most.
const GROWTH: usize = 7;

/// A solid and how it is compared.
struct Solid<'a> {
    limb: &'a Limb,
    name: String,
    scene: Option<SceneSource>,
    halvings: usize,
}

/// Where is pressed: nodes and directions on the solid, loads on the shell's skin.
struct Presses {
    places: Vec<(FeNodeId, Vector3<f64>)>,
    shell_loads: Vec<NodalLoad>,
    n_left_out: usize,
}

impl ShellLimb {
    /// Presses the shell and the solid extruded from the same skin, its edges halved as often as the
    /// params say, held and read at the same places.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] where the wall folds; [`HapdefError::NothingToPress`];
    /// [`HapdefError::Sim`].
    pub fn against_extruded(&self) -> Result<ShellComparison, HapdefError> {
        let is_small = GROWTH * self.limb.mesh.nodes().len() <= MAX_FE_NODES;
        let halvings = self.params.n_solid_halvings.unwrap_or(usize::from(is_small));
        let edge_mm = 1e3 * self.info.wall.target_edge_m * 0.5_f64.powi(halvings as i32);
        let name = format!("its extruded solid (edges of {edge_mm:.2} mm)");
        self.compare(&Solid { limb: &self.limb, name, scene: None, halvings })
    }

    /// Presses the shell and the solid limb of the scene in the file `path`, of the shell's material, at
    /// the solid's surface nodes. Each model is held as it says itself; nodes and gauges that don't lie on
    /// the shell are passed over.
    ///
    /// # Errors
    /// [`HapdefError::NothingToPress`] where the two don't lie on one another; what [`read_scene`] and
    /// [`Limb::load`] refuse; [`HapdefError::Sim`].
    pub fn against_scene(&self, path: &Path) -> Result<ShellComparison, HapdefError> {
        let scene = read_scene(path)?;
        let limb = Limb::load(&scene, path.parent().unwrap_or(Path::new(".")))?;
        let name = format!("the solid of scene {:?}", scene.name);
        let source = SceneSource { file: path.display().to_string(), file_hash: file_hash(path)? };
        self.compare(&Solid { limb: &limb, name, scene: Some(source), halvings: 0 })
    }

    fn compare(&self, solid: &Solid<'_>) -> Result<ShellComparison, HapdefError> {
        let started = Instant::now();
        let presses = self.presses(solid.limb)?;
        let model = LimbModel::build(&self.limb, self.params.n_threads)?;
        let gauges = model.gauges(&solid.limb.sites, &solid.limb.gauges)?;
        let on_shell = gauges.into_iter().zip(&solid.limb.sites);
        let (gauges, sites): (Vec<LinearFunctional>, Vec<GaugeSite>) =
            on_shell.filter_map(|(gauge, site)| Some((gauge?, *site))).unzip();
        let levels = Levels {
            limb: solid.limb,
            material: self.limb.material,
            sites,
            presses: presses.places,
            tip_radius_m: self.params.tip_radius_m,
            n_tips: self.params.n_presses,
            n_iterated_tips: self.params.n_presses.min(MOST_ITERATED),
            n_points: 0,
            n_threads: self.params.n_threads,
        };
        let mut solids = levels.solve(solid.halvings, &|_| {})?;
        let n_tips = solids.iter().map(|level| level.tip_um_per_n.len()).min().unwrap_or(0);
        solids.iter_mut().for_each(|level| level.tip_um_per_n.truncate(n_tips));
        let loads: Vec<NodalLoad> = presses.shell_loads.iter().map(|l| model.load(l)).collect();
        let on_shell = Answers::of(&model.model, &gauges, &loads, n_tips)?;
        let Some(finest) = solids.pop() else {
            return Err(HapdefError::NothingToPress { n_places: 0 });
        };
        let from_finest = |readings: &[Vec<f64>], tips: &[f64]| Answered {
            readings: Differences::of(readings, &finest.reading_ue_per_n),
            tip: Differences::of(&rows(tips), &rows(&finest.tip_um_per_n)),
        };
        let coarser =
            solids.last().map(|level| from_finest(&level.reading_ue_per_n, &level.tip_um_per_n));
        let shell = from_finest(&on_shell.reading_ue_per_n, &on_shell.tip_um_per_n);
        let places = levels.presses.iter().map(|(node, _)| solid.limb.mesh.position(*node));
        let tables = Tables {
            places: places.collect(),
            sites: levels.sites.iter().map(|site| site.position).collect(),
            readings: [&finest.reading_ue_per_n, &on_shell.reading_ue_per_n],
            tips: [&finest.tip_um_per_n, &on_shell.tip_um_per_n],
        };
        let skin = solid.limb.skin.surface(&solid.limb.mesh)?;
        let maps = ShellMaps::new(&skin, &tables);
        Ok(ShellComparison {
            solid: solid.name.clone(),
            deck_hash: solid.scene.as_ref().map(|_| solid.limb.deck_hash.clone()),
            scene: solid.scene.clone(),
            n_fe_nodes: finest.n_fe_nodes,
            n_equations: finest.n_equations,
            n_gauges: gauges.len(),
            n_gauges_left_out: solid.limb.sites.len() - gauges.len(),
            n_touches: tables.places.len(),
            n_tips,
            n_touches_left_out: presses.n_left_out,
            presses: tables.presses(),
            gauges: tables.gauges(),
            above_good: maps.above_good(&skin),
            verdict: ShellVerdict::new(&shell, coarser.as_ref()),
            shell,
            coarser_solid: coarser,
            maps,
            skin,
            elapsed_s: started.elapsed().as_secs_f64(),
        })
    }

    /// Nodes of the solid's skin to press, spread; those that are held, or not wholly on the shell, are passed
    /// over.
    fn presses(&self, solid: &Limb) -> Result<Presses, HapdefError> {
        let (limb, radius_m) = (&self.limb, self.params.tip_radius_m);
        let skin = PressedSkin::new(&limb.mesh, &limb.skin)?;
        let held: Vec<_> = limb.clamped.iter().map(|node| limb.mesh.position(*node)).collect();
        let held = PointIndex::new(&held);
        let load = |place: &Point3<f64>, direction: &Vector3<f64>| {
            if held.nearest(place).is_some_and(|(_, d)| d <= 2.0 * radius_m) {
                return Ok(None);
            }
            match skin.load(place, radius_m, direction) {
                Err(SimError::PatchOffSkin { .. }) => Ok(None),
                load => load.map(|load| self.is_centred(&load, place, direction).then_some(load)),
            }
        };
        let nodes = solid.skin.nodes.par_iter().zip(&solid.directions);
        let loads = nodes.map(|(node, direction)| {
            let load = load(&solid.mesh.position(*node), direction)?;
            Ok(load.map(|load| (*node, (*direction, load))))
        });
        let loads: Vec<_> = loads.collect::<Result<_, SimError>>()?;
        let mut open: BTreeMap<FeNodeId, _> = loads.into_iter().flatten().collect();
        let n_left_out = solid.skin.nodes.len() - open.len();
        let nodes: Vec<FeNodeId> = open.keys().copied().collect();
        let chosen = farthest_nodes(&solid.mesh, &nodes, N_TOUCHES);
        if chosen.is_empty() {
            return Err(HapdefError::NothingToPress { n_places: n_left_out });
        }
        let taken = chosen.iter().filter_map(|node| Some((*node, open.remove(node)?)));
        let taken = taken.map(|(node, (direction, load))| ((node, direction), load));
        let (places, shell_loads) = taken.unzip();
        Ok(Presses { places, shell_loads, n_left_out })
    }

    /// Whether a tip's load has its middle where it presses.
    fn is_centred(&self, load: &NodalLoad, place: &Point3<f64>, direction: &Vector3<f64>) -> bool {
        let share = |(node, force): &(FeNodeId, Vector3<f64>)| {
            (self.limb.mesh.position(*node) - place) * force.dot(direction)
        };
        let off_m = load.forces_n.iter().map(share).sum::<Vector3<f64>>().norm();
        off_m <= MAX_OFF_CENTRE * self.params.tip_radius_m
    }
}

/// Single answers as rows.
fn rows(values: &[f64]) -> Vec<Vec<f64>> {
    values.iter().map(|value| vec![*value]).collect()
}
