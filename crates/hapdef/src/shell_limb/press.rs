//! The same presses on the shell and on solid models of the limb.

use std::time::Instant;

use hapdef_mesh::{FeNodeId, GaugeId, PointIndex, SkinRegion, SurfaceMesh, Tet10Mesh};
use hapdef_sim::{
    ComplianceParams, ElasticModel, ElasticParams, GaugeResponse, GaugeStrain, NodalLoad,
    ShellGaugeStrain, SimError, SolverKind,
};
use nalgebra::{Point3, Vector3};

use super::ShellLimb;
use super::compare::{Answered, PressDifference, ShellComparison, ShellVerdict};
use super::differences::Differences;
use super::maps::{ShellMaps, Tables};
use super::sites::spread;
use crate::error::HapdefError;

/// Places where readings are compared, at most.
const N_TOUCHES: usize = 480;

/// A tip's load on the shell may be off its centre by this part of the tip's radius; at a rim or a
/// hole it is farther off.
const MAX_OFF_CENTRE: f64 = 0.25;

/// Presses solved together: of a finer solid their displacements are kept at all loaded nodes.
const PRESSES_AT_A_TIME: usize = 60;

/// Presses, at most, where a solid is too large to be factored: each then takes an iteration.
const MOST_ITERATED: usize = 24;

/// What is compared, and where.
pub(super) struct Comparison<'a> {
    pub name: String,
    /// Hash of the solid's deck.
    pub deck_hash: Option<String>,
    /// The solid; before it, perhaps, one with longer edges.
    pub solids: Vec<Solid<'a>>,
    /// Gauges on the shell, in the order of those on the solids.
    pub gauges: Vec<ShellGaugeStrain>,
    /// Where they are glued.
    pub sites: Vec<Point3<f64>>,
    pub n_gauges_left_out: usize,
    /// Places on the skin, and the same places on the shell's middle.
    pub places: Vec<[Point3<f64>; 2]>,
    /// Directions of the force there.
    pub directions: Vec<Vector3<f64>>,
    /// What the differences are drawn on.
    pub picture: SurfaceMesh,
}

/// A solid model of the limb.
pub(super) struct Solid<'a> {
    pub mesh: &'a Tet10Mesh,
    pub skin: &'a SkinRegion,
    pub clamped: Vec<FeNodeId>,
    pub gauges: Vec<GaugeStrain>,
}

/// What a model answers.
struct Answers {
    n_equations: usize,
    /// `[n_touches][n_gauges]`, µε/N.
    readings: Vec<Vec<f64>>,
    /// `[n_presses][1]`, µm/N.
    tips: Vec<Vec<f64>>,
}

/// Where is pressed: numbers of places, the shell's loads there, and how many were passed over.
struct Touches {
    places: Vec<usize>,
    shell_loads: Vec<NodalLoad>,
    n_left_out: usize,
}

impl ShellLimb {
    pub(super) fn compare(
        &self,
        comparison: &Comparison<'_>,
    ) -> Result<ShellComparison, HapdefError> {
        let started = Instant::now();
        let touches = self.touches(comparison)?;
        let (response, _) = self.elastic_model.response(&comparison.gauges)?;
        let mut on_shell = self.answers(&self.elastic_model, &response, &touches.shell_loads)?;
        let on_solids =
            comparison.solids.iter().map(|solid| self.solid_answers(solid, comparison, &touches));
        let mut on_solids: Vec<Answers> = on_solids.collect::<Result<_, _>>()?;
        let everyone = || on_solids.iter().chain([&on_shell]);
        let n_presses = everyone().map(|a| a.tips.len()).min().unwrap_or(0);
        on_shell.tips.truncate(n_presses);
        on_solids.iter_mut().for_each(|a| a.tips.truncate(n_presses));
        let (Some(solid), Some(truth)) = (comparison.solids.last(), on_solids.last()) else {
            return Err(HapdefError::NothingToPress { n_places: 0 });
        };
        let shell = on_shell.against(truth);
        let coarser = on_solids.len().checked_sub(2).map(|i| &on_solids[i]);
        let coarser_solid = coarser.map(|coarser| coarser.against(truth));
        let touched = touches.places.iter().map(|&i| comparison.places[i][0]);
        let tables = Tables {
            places: touched.collect(),
            sites: &comparison.sites,
            readings: [&truth.readings, &on_shell.readings],
            tips: [&truth.tips, &on_shell.tips],
        };
        let maps = ShellMaps::new(&comparison.picture, &tables);
        Ok(ShellComparison {
            solid: comparison.name.clone(),
            deck_hash: comparison.deck_hash.clone(),
            n_fe_nodes: solid.mesh.nodes().len(),
            n_equations: truth.n_equations,
            n_gauges: comparison.gauges.len(),
            n_gauges_left_out: comparison.n_gauges_left_out,
            n_touches: touches.places.len(),
            n_touches_left_out: touches.n_left_out,
            presses: press_differences(&tables),
            touches: tables.touches(),
            gauges: tables.gauges(),
            above_good: maps.above_good(&comparison.picture),
            verdict: ShellVerdict::new(&shell, coarser_solid.as_ref()),
            shell,
            coarser_solid,
            reading_difference: tables.nearest_difference(comparison.picture.vertices()),
            maps,
            skin: comparison.picture.clone(),
            elapsed_s: started.elapsed().as_secs_f64(),
        })
    }

    /// Places to press, spread.
    fn touches(&self, comparison: &Comparison<'_>) -> Result<Touches, HapdefError> {
        let held = self.clamped.iter().map(|n| self.mesh.nodes()[n.index()]);
        let held = PointIndex::new(&held.collect::<Vec<_>>());
        let points: Vec<Point3<f64>> = comparison.places.iter().map(|place| place[0]).collect();
        let all: Vec<usize> = (0..points.len()).collect();
        let mut shell_loads = Vec::new();
        let mut n_left_out = 0;
        let places = spread(&points, &all, N_TOUCHES, |i| {
            let centre = &comparison.places[i][1];
            let nearest = held.nearest(centre);
            let is_free = nearest.is_none_or(|(_, d)| d > 2.0 * self.params.tip_radius_m);
            let load =
                if is_free { self.shell_load(centre, &comparison.directions[i])? } else { None };
            n_left_out += usize::from(load.is_none());
            let is_taken = load.is_some();
            shell_loads.extend(load);
            Ok(is_taken)
        })?;
        if places.is_empty() {
            return Err(HapdefError::NothingToPress { n_places: all.len() });
        }
        Ok(Touches { places, shell_loads, n_left_out })
    }

    /// The tip's load on the shell, if the whole tip is on it.
    fn shell_load(
        &self,
        centre: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Result<Option<NodalLoad>, HapdefError> {
        let radius_m = self.params.tip_radius_m;
        let load = match self.mesh.patch_load(centre, radius_m, direction) {
            Err(SimError::PatchOffSkin { .. }) => return Ok(None),
            other => other?,
        };
        let shares = load
            .forces_n
            .iter()
            .map(|(node, force)| (self.mesh.nodes()[node.index()] - centre) * force.dot(direction));
        let off_centre_m = shares.sum::<Vector3<f64>>().norm() / direction.norm();
        Ok((off_centre_m <= MAX_OFF_CENTRE * radius_m).then_some(load))
    }

    fn solid_answers(
        &self,
        solid: &Solid<'_>,
        comparison: &Comparison<'_>,
        touches: &Touches,
    ) -> Result<Answers, HapdefError> {
        let params = ElasticParams {
            n_threads: self.params.n_threads,
            ..ElasticParams::new(self.params.material, solid.clamped.clone())
        };
        let model = ElasticModel::build(solid.mesh, &params)?;
        let (response, _) = model.response(&solid.gauges)?;
        let load = |&place: &usize| {
            let (centre, direction) = (&comparison.places[place][0], &comparison.directions[place]);
            let radius_m = self.params.tip_radius_m;
            NodalLoad::patch(solid.mesh, solid.skin, centre, radius_m, direction)
        };
        let loads: Vec<NodalLoad> = touches.places.iter().map(load).collect::<Result<_, _>>()?;
        self.answers(&model, &response, &loads)
    }

    fn answers(
        &self,
        model: &ElasticModel,
        response: &GaugeResponse,
        loads: &[NodalLoad],
    ) -> Result<Answers, HapdefError> {
        let readings = |load: &NodalLoad| {
            let gauges = (0..response.n_gauges()).map(GaugeId::from_index);
            gauges.map(|g| response.reading(g, load) * 1e6).collect()
        };
        let most = match model.solver_info().kind {
            SolverKind::Iterative => self.params.n_presses.min(MOST_ITERATED),
            SolverKind::Direct => self.params.n_presses,
        };
        let presses = &loads[..loads.len().min(most)];
        let mut tips = Vec::new();
        for together in presses.chunks(PRESSES_AT_A_TIME) {
            tips.extend(under_tips(model, together)?);
        }
        Ok(Answers {
            n_equations: model.info().n_equations,
            readings: loads.iter().map(readings).collect(),
            tips,
        })
    }
}

/// The displacement under each load along its force, µm/N.
fn under_tips(model: &ElasticModel, loads: &[NodalLoad]) -> Result<Vec<Vec<f64>>, SimError> {
    let loaded = loads.iter().flat_map(|load| &load.forces_n);
    let mut wanted: Vec<FeNodeId> = loaded.map(|(node, _)| *node).collect();
    wanted.sort_unstable();
    wanted.dedup();
    let (moved, _) = model.compliance(loads, &wanted, &ComplianceParams::default())?;
    let work = |(i, load): (usize, &NodalLoad)| {
        let shares = load.forces_n.iter().map(|(node, force)| {
            let place = wanted.partition_point(|other| other < node);
            force.dot(&moved.displacement(i, place))
        });
        vec![shares.sum::<f64>() * 1e6]
    };
    Ok(loads.iter().enumerate().map(work).collect())
}

impl Answers {
    fn against(&self, solid: &Self) -> Answered {
        Answered {
            readings: Differences::of(&self.readings, &solid.readings),
            tip: Differences::of(&self.tips, &solid.tips),
        }
    }
}

fn press_differences(tables: &Tables<'_>) -> Vec<PressDifference> {
    let [solid, shell] = tables.tips;
    let press = |i: usize| PressDifference {
        position_m: tables.places[i].coords.into(),
        shell_tip_um_per_n: shell[i][0],
        solid_tip_um_per_n: solid[i][0],
        reading_difference: tables.difference(i),
    };
    (0..solid.len()).map(press).collect()
}
