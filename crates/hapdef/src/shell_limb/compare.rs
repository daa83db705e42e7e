//! The same presses on the shell and on a solid model of the limb.

use std::fmt;
use std::time::Instant;

use hapdef_mesh::{FeNodeId, GaugeId, PointIndex, SkinRegion, SurfaceMesh, Tet10Mesh};
use hapdef_sim::{
    ElasticModel, ElasticParams, GaugeResponse, GaugeStrain, NodalLoad, ShellGaugeStrain, SimError,
};
use nalgebra::{Point3, Vector3};
use serde::Serialize;

use super::ShellLimb;
use super::info::quartiles;
use super::sites::spread;
use crate::error::HapdefError;

/// Median difference up to which a shell is good enough.
const GOOD: f64 = 0.1;

/// Places where readings are compared, at most.
const N_TOUCHES: usize = 480;

/// A tip's load on the shell may be off its centre by this part of the tip's radius; at a rim or a
/// hole it is farther off.
const MAX_OFF_CENTRE: f64 = 0.25;

/// What a shell and a solid answer to the same presses.
#[derive(Clone, Debug, Serialize)]
pub struct ShellComparison {
    /// The solid.
    pub solid: String,
    /// Nodes of the solid.
    pub n_fe_nodes: usize,
    /// Equations of the solid.
    pub n_equations: usize,
    /// Gauges compared.
    pub n_gauges: usize,
    /// Gauges that only one of the models can carry.
    pub n_gauges_left_out: usize,
    /// Places where readings are compared.
    pub n_touches: usize,
    /// Places passed over: held, or not on the shell.
    pub n_touches_left_out: usize,
    /// Gauge readings: ‖shell − solid‖ / ‖solid‖ over the gauges, at every place.
    pub readings: Differences,
    /// Displacement under the tip along the force: |shell − solid| / solid, at every press.
    pub tip: Differences,
    /// The presses whose displacement is compared.
    pub presses: Vec<PressDifference>,
    /// Whether both median differences are at most 10 %.
    pub is_shell_good: bool,
    /// Seconds.
    pub elapsed_s: f64,
    /// The solid's skin, m.
    #[serde(skip)]
    pub skin: SurfaceMesh,
    /// The readings' difference at the nearest place, `[n_vertices]` of [`Self::skin`].
    #[serde(skip)]
    pub reading_difference: Vec<f64>,
}

/// Relative differences of a shell's answers from a solid's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Differences {
    /// The median.
    pub median: f64,
    /// The largest.
    pub worst: f64,
    /// The norm of all differences over the norm of all the solid's answers.
    pub overall: f64,
    /// The median of the shell's magnitude over the solid's.
    pub median_ratio: f64,
}

/// One press on both models.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PressDifference {
    /// Where on the solid's skin, m.
    pub position_m: [f64; 3],
    /// Displacement under the tip of the shell, µm/N.
    pub shell_tip_um_per_n: f64,
    /// The same of the solid, µm/N.
    pub solid_tip_um_per_n: f64,
    /// The readings' relative difference.
    pub reading_difference: f64,
}

/// A solid model of the same limb, and where both are touched.
pub(super) struct Solid<'a> {
    pub name: String,
    pub mesh: &'a Tet10Mesh,
    pub skin: &'a SkinRegion,
    pub clamped: Vec<FeNodeId>,
    /// The same gauges on both models.
    pub gauges: Vec<(ShellGaugeStrain, GaugeStrain)>,
    pub n_gauges_left_out: usize,
    /// Places on the skin, and the same places on the shell's middle.
    pub places: Vec<[Point3<f64>; 2]>,
    /// Directions of the force there.
    pub directions: Vec<Vector3<f64>>,
    /// What the differences are drawn on.
    pub picture: SurfaceMesh,
}

/// A model, its gauges and the loads on it.
struct Pressed<'a> {
    model: &'a ElasticModel,
    response: GaugeResponse,
    loads: Vec<NodalLoad>,
}

impl ShellLimb {
    pub(super) fn compare(&self, solid: &Solid<'_>) -> Result<ShellComparison, HapdefError> {
        let started = Instant::now();
        let elastic = ElasticParams {
            n_threads: self.params.n_threads,
            ..ElasticParams::new(self.params.material, solid.clamped.clone())
        };
        let solid_model = ElasticModel::build(solid.mesh, &elastic)?;
        let (touched, shell_loads, n_touches_left_out) = self.touches(solid)?;
        let (on_shell, on_solid): (Vec<_>, Vec<_>) = solid.gauges.iter().cloned().unzip();
        let shell = Pressed {
            response: self.elastic_model.shell_gauge_response(&on_shell)?.0,
            model: &self.elastic_model,
            loads: shell_loads,
        };
        let solid_loads = touched.iter().map(|&i| self.solid_load(solid, i));
        let pressed_solid = Pressed {
            response: solid_model.gauge_response(&on_solid)?.0,
            model: &solid_model,
            loads: solid_loads.collect::<Result<_, _>>()?,
        };
        let readings = [&shell, &pressed_solid].map(Pressed::readings);
        let n_presses = self.params.n_presses.min(touched.len());
        let tips = [
            shell.displacements(n_presses)?,
            pressed_solid.displacements(n_presses)?,
        ];
        let at_touch: Vec<f64> = (0..touched.len())
            .map(|i| relative(&readings[0][i], &readings[1][i]))
            .collect();
        let presses = (0..n_presses).map(|i| PressDifference {
            position_m: solid.places[touched[i]][0].coords.into(),
            shell_tip_um_per_n: tips[0][i][0],
            solid_tip_um_per_n: tips[1][i][0],
            reading_difference: at_touch[i],
        });
        let (of_readings, of_tips) = (differences(&readings), differences(&tips));
        let places: Vec<Point3<f64>> = touched.iter().map(|&i| solid.places[i][0]).collect();
        Ok(ShellComparison {
            solid: solid.name.clone(),
            n_fe_nodes: solid.mesh.nodes().len(),
            n_equations: solid_model.info().n_equations,
            n_gauges: solid.gauges.len(),
            n_gauges_left_out: solid.n_gauges_left_out,
            n_touches: touched.len(),
            n_touches_left_out,
            readings: of_readings,
            tip: of_tips,
            presses: presses.collect(),
            is_shell_good: of_readings.median <= GOOD && of_tips.median <= GOOD,
            reading_difference: nearest_values(solid.picture.vertices(), &places, &at_touch),
            skin: solid.picture.clone(),
            elapsed_s: started.elapsed().as_secs_f64(),
        })
    }

    /// Places to press, spread, with the shell's load at each, and how many were passed over.
    fn touches(
        &self,
        solid: &Solid<'_>,
    ) -> Result<(Vec<usize>, Vec<NodalLoad>, usize), HapdefError> {
        let radius_m = self.params.tip_radius_m;
        let held = self.clamped.iter().map(|n| self.mesh.nodes()[n.index()]);
        let held = PointIndex::new(&held.collect::<Vec<_>>());
        let points: Vec<Point3<f64>> = solid.places.iter().map(|place| place[0]).collect();
        let all: Vec<usize> = (0..points.len()).collect();
        let mut loads = Vec::new();
        let mut n_left_out = 0;
        let touched = spread(&points, &all, N_TOUCHES, |i| {
            let centre = &solid.places[i][1];
            let nearest = held.nearest(centre);
            let is_free = nearest.is_none_or(|(_, d)| d > 2.0 * radius_m);
            let load = if is_free {
                self.shell_load(centre, &solid.directions[i])?
            } else {
                None
            };
            n_left_out += usize::from(load.is_none());
            let is_taken = load.is_some();
            loads.extend(load);
            Ok(is_taken)
        })?;
        if touched.is_empty() {
            return Err(HapdefError::NothingToPress {
                n_places: all.len(),
            });
        }
        Ok((touched, loads, n_left_out))
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
        let off_centre_m = shares.sum::<Vector3<f64>>().norm() / direction.norm_squared();
        Ok((off_centre_m <= MAX_OFF_CENTRE * radius_m).then_some(load))
    }

    fn solid_load(&self, solid: &Solid<'_>, place: usize) -> Result<NodalLoad, SimError> {
        NodalLoad::patch(
            solid.mesh,
            solid.skin,
            &solid.places[place][0],
            self.params.tip_radius_m,
            &solid.directions[place],
        )
    }
}

impl Pressed<'_> {
    /// `[n_loads][n_gauges]`, µε/N.
    fn readings(&self) -> Vec<Vec<f64>> {
        let reading = |load: &NodalLoad| {
            let gauges = (0..self.response.n_gauges()).map(GaugeId::from_index);
            gauges
                .map(|gauge| self.response.reading(gauge, load) * 1e6)
                .collect()
        };
        self.loads.iter().map(reading).collect()
    }

    /// Displacement under the tip along the force for the first `n` loads `[n][1]`, µm/N.
    fn displacements(&self, n: usize) -> Result<Vec<Vec<f64>>, HapdefError> {
        let under_tip = |load: &NodalLoad| -> Result<Vec<f64>, HapdefError> {
            let (displacement, _) = self.model.solve(load)?;
            Ok(vec![load.work_j(&displacement)? * 1e6])
        };
        self.loads[..n].iter().map(under_tip).collect()
    }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// ‖shell − solid‖ / ‖solid‖; 0 where both are 0.
fn relative(shell: &[f64], solid: &[f64]) -> f64 {
    let difference: Vec<f64> = shell.iter().zip(solid).map(|(a, b)| a - b).collect();
    match (norm(&difference), norm(solid)) {
        (0.0, 0.0) => 0.0,
        (difference, whole) => difference / whole.max(f64::MIN_POSITIVE),
    }
}

/// Of answers `[n][m]` of the shell and of the solid.
fn differences([shell, solid]: &[Vec<Vec<f64>>; 2]) -> Differences {
    let pairs = || shell.iter().zip(solid);
    let [_, _, median, _, worst] = quartiles(pairs().map(|(a, b)| relative(a, b)));
    let ratio = |(a, b): (&Vec<f64>, &Vec<f64>)| norm(a) / norm(b).max(f64::MIN_POSITIVE);
    Differences {
        median,
        worst,
        overall: relative(&shell.concat(), &solid.concat()),
        median_ratio: quartiles(pairs().map(ratio))[2],
    }
}

/// At each of `points` the value of the nearest of `places`.
fn nearest_values(points: &[Point3<f64>], places: &[Point3<f64>], values: &[f64]) -> Vec<f64> {
    let index = PointIndex::new(places);
    let value = |point| index.nearest(point).map_or(0.0, |(i, _)| values[i]);
    points.iter().map(value).collect()
}

impl fmt::Display for ShellComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |x: f64| 100.0 * x;
        let (readings, tip) = (&self.readings, &self.tip);
        let advice = if self.is_shell_good {
            "the shell is good here"
        } else {
            "more than 10 %: use the solid"
        };
        write!(
            f,
            "shell against {}: gauge readings within {:.1} % (median; worst of {} places {:.0} %), \
             displacement under the tip within {:.1} % (median; worst of {} presses {:.0} %): \
             {advice}",
            self.solid,
            percent(readings.median),
            self.n_touches,
            percent(readings.worst),
            percent(tip.median),
            self.presses.len(),
            percent(tip.worst),
        )
    }
}
