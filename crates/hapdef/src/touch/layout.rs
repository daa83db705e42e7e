//! Where on a limb's inner wall gauges can be put: what is asked, and the places that fit.

use std::f64::consts::PI;

use hapdef_inverse::{Candidates, PlacementScore, ResponseMap, ScanSites};
use hapdef_mesh::{clear_nodes, farthest_nodes, wall};
use hapdef_sim::{GaugeStrain, LinearFunctional};
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

use super::model::{LimbModel, ModelGauge};
use super::steady::{GluedOff, changes};
use crate::error::HapdefError;
use crate::run::Run;
use crate::scene::GaugeEntry;

/// Least cosine between the normals of a gauge and of the same gauge glued off its place: beyond
/// 60° it lies on another wall, around an edge.
const SAME_WALL: f64 = 0.5;

/// How far a gauge is turned, beside moved by the margin, for what its reading changes by, rad: the 3° that the
/// simulated rig turns gauges by.
const OFF_TURN_RAD: f64 = 0.0524;

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutParams {
    /// Gauges in all.
    pub n_gauges: usize,
    /// The first so many of the scene's gauges are mounted already and stay.
    pub n_mounted: usize,
    /// Places on the wall that are looked at.
    pub n_positions: usize,
    /// Directions tried at each place, evenly over half a turn.
    pub n_axes: usize,
    /// Sites of contacts.
    pub n_sites: usize,
    /// Balls that no gauge's centre may lie in: centre and radius, m.
    pub keep_out: Vec<(Point3<f64>, f64)>,
    /// Least distance of two gauges, m.
    pub min_spacing_m: f64,
    /// How far off a gauge may be glued and must still fit on its wall, m.
    pub margin_m: f64,
    /// Places are passed over where a gauge glued that far off, or turned by 3°, reads something else by more than
    /// this part of what it should; infinite takes them all.
    pub max_change: f64,
    /// Standard deviation of a reading's noise, µε.
    pub noise_ue: f64,
    /// Force of the contacts, N.
    pub force_n: f64,
    /// Whether the scene's loads that are no contacts count as unknown, too.
    pub beside_loads: bool,
    /// Random layouts that the others are compared with.
    pub n_random: usize,
    /// Whether other methods are scored, too.
    pub compares: bool,
    /// Numbers of gauges that the methods are scored for beside `n_gauges`.
    pub other_counts: Vec<usize>,
    /// Seed of pairs and random layouts.
    pub seed: u64,
}

impl Default for LayoutParams {
    fn default() -> Self {
        Self {
            n_gauges: 10,
            n_mounted: 0,
            n_positions: 160,
            n_axes: 4,
            n_sites: 400,
            keep_out: Vec::new(),
            min_spacing_m: 0.01,
            margin_m: 1e-3,
            max_change: f64::INFINITY,
            noise_ue: 5.0,
            force_n: 10.0,
            beside_loads: false,
            n_random: 20,
            compares: true,
            other_counts: vec![4, 6, 8, 12, 16],
            seed: 1,
        }
    }
}

/// A gauge of a layout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedGauge {
    /// Centre on the wall, m.
    pub position_m: Point3<f64>,
    /// Measuring direction, unit length.
    pub axis: Vector3<f64>,
}

/// Gauges as a scene has them, to the micrometre, named g0, g1, …
#[must_use]
pub fn gauge_entries(gauges: &[PlacedGauge]) -> Vec<GaugeEntry> {
    let entry = |(i, gauge): (usize, &PlacedGauge)| GaugeEntry {
        name: format!("g{i}"),
        position_m: <[f64; 3]>::from(gauge.position_m.coords).map(to_micrometres),
        axis: <[f64; 3]>::from(gauge.axis).map(to_micrometres),
    };
    gauges.iter().enumerate().map(entry).collect()
}

/// A layout and what it can tell.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoredLayout {
    /// Method.
    pub name: String,
    /// Its gauges; empty for the median of random ones.
    pub gauges: Vec<PlacedGauge>,
    /// Cramér–Rao bounds.
    pub score: PlacementScore,
    /// Time of the choice, s.
    pub elapsed_s: f64,
}

/// Layouts of a limb.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutStudy {
    /// Places with an axis that a gauge fits on, the scene's own gauges not counted.
    pub n_candidates: usize,
    /// Places with an axis that a gauge doesn't fit on, or that are passed over by
    /// [`LayoutParams::max_change`].
    pub n_refused: usize,
    /// Loads of the scene that are no contacts, beside which contacts are to be found; 0 unless
    /// [`LayoutParams::beside_loads`].
    pub n_loads: usize,
    /// Time of the candidates' adjoint solves with the factor, s.
    pub solve_s: f64,
    /// The layouts, the recommended one last.
    pub layouts: Vec<ScoredLayout>,
    /// Bounds of each method by number of gauges, rising.
    pub by_count: Vec<CountedLayout>,
}

/// What a method reaches with a number of gauges.
#[derive(Clone, Debug, PartialEq)]
pub struct CountedLayout {
    /// Method.
    pub name: &'static str,
    /// Gauges.
    pub n_gauges: usize,
    /// Cramér–Rao bounds.
    pub score: PlacementScore,
}

/// Gauges that fit on the wall, the scene's own behind them.
pub(super) struct Places {
    pub(super) gauges: Vec<ModelGauge>,
    pub(super) placed: Vec<PlacedGauge>,
    /// The largest change of each gauge's readings when it is glued off, relative; 0 where that was not asked for
    /// and for the scene's own `[n]`.
    pub(super) changes: Vec<f64>,
    pub(super) n_own: usize,
    pub(super) n_refused: usize,
}

impl Places {
    pub(super) fn find(
        run: &Run,
        model: &LimbModel<'_>,
        params: &LayoutParams,
    ) -> Result<Self, HapdefError> {
        let limb = model.limb;
        let wall = wall(&limb.mesh, &limb.boundary, &limb.skin, limb.max_wall_m)?;
        let nodes = clear_nodes(&limb.mesh, &wall.inner_faces, 0.0);
        let chosen = farthest_nodes(&limb.mesh, &nodes, params.n_positions);
        let along = Unit::new_normalize(Vector3::from(limb.axis.direction));
        let tried: Vec<_> = (0..chosen.len() * params.n_axes)
            .into_par_iter()
            .map(|i| {
                let position = limb.mesh.position(chosen[i / params.n_axes]).map(to_micrometres);
                let turn = PI * (i % params.n_axes) as f64 / params.n_axes as f64;
                (position, gauge_at(model, run, position, &along, turn, params.margin_m))
            })
            .collect();
        let n_tried = tried.len();
        let fitting =
            tried.into_iter().filter_map(|(position_m, glued)| Some((position_m, glued?)));
        let (positions, glued): (Vec<_>, Vec<_>) = fitting.unzip();
        let tip_radius_m = run.scene.contact.tip_radius_m;
        let changes = match params.max_change.is_finite() {
            true => changes(model, &glued, tip_radius_m)?,
            false => vec![0.0; glued.len()],
        };
        let mut places = Self {
            gauges: Vec::new(),
            placed: Vec::new(),
            changes: Vec::new(),
            n_own: limb.gauges.len(),
            n_refused: 0,
        };
        for ((position_m, glued), change) in positions.into_iter().zip(glued).zip(changes) {
            if change <= params.max_change {
                places.add(Some(glued.in_model), glued.gauge.axis(), position_m, change);
            }
        }
        places.n_refused = n_tried - places.gauges.len();
        if places.gauges.len() < params.n_gauges {
            return Err(HapdefError::TooFewGaugeSites {
                n_gauges: params.n_gauges,
                n_found: places.gauges.len(),
                n_candidates: nodes.len(),
                n_passed_over: places.n_refused,
            });
        }
        let own = model.gauges(&limb.sites, &limb.gauges)?;
        for ((in_model, gauge), site) in own.into_iter().zip(&limb.gauges).zip(&limb.sites) {
            places.add(in_model, gauge.axis(), site.position, 0.0);
        }
        Ok(places)
    }

    fn add(&mut self, gauge: ModelGauge, axis: Vector3<f64>, position_m: Point3<f64>, change: f64) {
        self.placed.push(PlacedGauge { position_m, axis });
        self.gauges.push(gauge);
        self.changes.push(change);
    }

    pub(super) fn own(&self) -> std::ops::Range<usize> {
        self.gauges.len() - self.n_own..self.gauges.len()
    }

    pub(super) fn candidates(
        &self,
        map: &ResponseMap,
        params: &LayoutParams,
    ) -> Result<Candidates, HapdefError> {
        let sites = ScanSites::farthest(map.skin(), params.n_sites)?;
        let n_sites = sites.len();
        let mut responses = vec![[0.0; 3]; self.gauges.len() * n_sites];
        for (site, point) in sites.points().iter().enumerate() {
            let values = map.normal(point);
            let [along, across] = map.normal_gradient(point);
            for (c, value) in values.iter().enumerate() {
                responses[c * n_sites + site] = [*value, along[c], across[c]];
            }
        }
        let own = self.own();
        let is_free = |(c, gauge): (usize, &PlacedGauge)| {
            let clear = |(centre, radius): &(Point3<f64>, f64)| {
                (gauge.position_m - centre).norm() > *radius
            };
            !own.contains(&c) && params.keep_out.iter().all(clear)
        };
        Ok(Candidates {
            positions_m: self.placed.iter().map(|p| p.position_m).collect(),
            sites_m: sites.positions().to_vec(),
            responses,
            loads: Vec::new(),
            allowed: self.placed.iter().enumerate().map(is_free).collect(),
        })
    }
}

/// As a scene file has it: where walls meet, a micrometre decides which of them a gauge is on.
pub(crate) fn to_micrometres(x_m: f64) -> f64 {
    (x_m * 1e6).round() / 1e6
}

/// The gauge whose axis is turned by `turn` from the limb's axis, if it fits there and `margin_m`
/// off to every side, on the same wall.
fn gauge_at(
    model: &LimbModel<'_>,
    run: &Run,
    position: Point3<f64>,
    along: &Unit<Vector3<f64>>,
    turn: f64,
    margin_m: f64,
) -> Option<GluedOff> {
    let limb = model.limb;
    let placed = |position, axis| {
        let site = run.scene.gauges.site(position, axis);
        let faces = &limb.boundary.faces;
        let gauge = GaugeStrain::with_params(&limb.mesh, faces, &site, &limb.gauge_params).ok()?;
        let in_model = model.gauges(&[site], std::slice::from_ref(&gauge)).ok()?.pop()??;
        Some((gauge, in_model))
    };
    let sides = |gauge: &GaugeStrain| [gauge.axis(), gauge.normal().cross(&gauge.axis())];
    let [ahead, across] = sides(&placed(position, along.into_inner())?.0);
    let turned = |turn: f64| ahead * turn.cos() + across * turn.sin();
    let (gauge, in_model) = placed(position, turned(turn))?;
    let axis = gauge.axis();
    let moved = |side: Vector3<f64>| {
        let (moved, in_model) = placed(position + side * margin_m, axis)?;
        (moved.normal().dot(&gauge.normal()) > SAME_WALL).then_some(in_model)
    };
    let [forward, sideways] = sides(&gauge);
    let shifts = [forward, -forward, sideways, -sideways];
    let mut off: Vec<LinearFunctional> = shifts.into_iter().map(moved).collect::<Option<_>>()?;
    let turns = [OFF_TURN_RAD, -OFF_TURN_RAD];
    let turns = turns.into_iter().filter_map(|by| Some(placed(position, turned(turn + by))?.1));
    off.extend(turns);
    Some(GluedOff { gauge, in_model, off })
}
