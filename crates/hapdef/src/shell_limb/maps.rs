//! A comparison over the surface and by gauge.

use hapdef_mesh::{PointIndex, SurfaceMesh};
use nalgebra::Point3;
use serde::Serialize;

use crate::convergence::{GOOD_DIFFERENCE, norm, relative};

/// One place pressed on both models.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PressDifference {
    /// Where on the solid's skin, m.
    pub position_m: [f64; 3],
    /// Root of the sum of squares of all gauges' readings of the shell, µε/N.
    pub shell_ue_per_n: f64,
    /// The same of the solid, µε/N.
    pub solid_ue_per_n: f64,
    /// The readings' relative difference.
    pub reading_difference: f64,
    /// Displacement under the tip of the shell, µm/N, where it is compared.
    pub shell_tip_um_per_n: Option<f64>,
    /// The same of the solid, µm/N.
    pub solid_tip_um_per_n: Option<f64>,
}

/// One gauge on both models.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GaugeDifference {
    /// Where it is glued, m.
    pub position_m: [f64; 3],
    /// The place where the solid's gauge reads most, m.
    pub strongest_position_m: [f64; 3],
    /// What it reads there, µε/N.
    pub solid_ue_per_n: f64,
    /// What the shell's gauge reads there, µε/N.
    pub shell_ue_per_n: f64,
    /// ‖shell − solid‖ / ‖solid‖ over all places.
    pub difference: f64,
}

/// Shares of the compared surface's area where the shell is off by more than 10 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AboveGood {
    /// Displacement under the tip.
    pub tip_share: f64,
    /// Gauge readings.
    pub readings_share: f64,
}

/// Answers at each vertex of a skin, those of the nearest place `[n_vertices]`: of the solid, of
/// the shell, and their relative difference. NaN where no place is near: it was not compared.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellMaps {
    /// Displacement under the tip, µm/N.
    pub tip: [Vec<f64>; 3],
    /// Root of the sum of squares of all gauges' readings, µε/N.
    pub readings: [Vec<f64>; 3],
}

/// What the models answered, the solid's first, at places on the skin.
pub(super) struct Tables<'a> {
    pub places: Vec<Point3<f64>>,
    pub sites: Vec<Point3<f64>>,
    /// `[n_places][n_gauges]`, µε/N.
    pub readings: [&'a [Vec<f64>]; 2],
    /// At the first places, µm/N.
    pub tips: [&'a [f64]; 2],
}

impl Tables<'_> {
    pub fn presses(&self) -> Vec<PressDifference> {
        let [solid, shell] = self.readings;
        let [solid_tips, shell_tips] = self.tips;
        let press = |(i, place): (usize, &Point3<f64>)| PressDifference {
            position_m: place.coords.into(),
            shell_ue_per_n: norm(&shell[i]),
            solid_ue_per_n: norm(&solid[i]),
            reading_difference: relative(&shell[i], &solid[i]),
            shell_tip_um_per_n: shell_tips.get(i).copied(),
            solid_tip_um_per_n: solid_tips.get(i).copied(),
        };
        self.places.iter().enumerate().map(press).collect()
    }

    pub fn gauges(&self) -> Vec<GaugeDifference> {
        let gauge = |(g, site): (usize, &Point3<f64>)| {
            let [solid, shell] =
                self.readings.map(|rows| rows.iter().map(|row| row[g]).collect::<Vec<f64>>());
            let stronger = |a: usize, b: usize| {
                if solid[b].abs() > solid[a].abs() { b } else { a }
            };
            let strongest = (0..solid.len()).fold(0, stronger);
            GaugeDifference {
                position_m: site.coords.into(),
                strongest_position_m: self.places[strongest].coords.into(),
                solid_ue_per_n: solid[strongest],
                shell_ue_per_n: shell[strongest],
                difference: relative(&shell, &solid),
            }
        };
        self.sites.iter().enumerate().map(gauge).collect()
    }
}

impl ShellMaps {
    pub(super) fn new(skin: &SurfaceMesh, tables: &Tables<'_>) -> Self {
        let at = |[solid, shell]: [&[&[f64]]; 2]| {
            let nearest = nearest_within_reach(skin.vertices(), &tables.places[..solid.len()]);
            let value = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
                nearest.iter().map(|i| i.map_or(f64::NAN, of)).collect()
            };
            [
                value(&|i| norm(solid[i])),
                value(&|i| norm(shell[i])),
                value(&|i| relative(shell[i], solid[i])),
            ]
        };
        let tips = tables.tips.map(|tips| tips.chunks(1).collect::<Vec<_>>());
        let readings =
            tables.readings.map(|rows| rows.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let [tip, readings] = [&tips, &readings].map(|[solid, shell]| at([&solid[..], &shell[..]]));
        Self { tip, readings }
    }

    /// The shares of the area where the differences are more than is good, a third of each
    /// triangle for each corner.
    pub(super) fn above_good(&self, skin: &SurfaceMesh) -> AboveGood {
        let mut area_m2 = vec![0.0; skin.vertices().len()];
        for (triangle, corners) in skin.triangles().iter().enumerate() {
            let third_m2 = skin.area_normal_m2(triangle).norm() / 3.0;
            corners.iter().for_each(|&v| area_m2[v as usize] += third_m2);
        }
        let share = |differences: &[f64]| {
            let of = |wanted: &dyn Fn(f64) -> bool| -> f64 {
                let rows = differences.iter().zip(&area_m2);
                rows.filter(|(d, _)| wanted(**d)).fold(0.0, |sum, (_, a)| sum + a)
            };
            let compared_m2 = of(&|d| !d.is_nan());
            of(&|d| d > GOOD_DIFFERENCE) / compared_m2.max(f64::MIN_POSITIVE)
        };
        AboveGood { tip_share: share(&self.tip[2]), readings_share: share(&self.readings[2]) }
    }
}

/// The nearest place to each point; nothing beyond the widest gap between a place and the next.
fn nearest_within_reach(points: &[Point3<f64>], places: &[Point3<f64>]) -> Vec<Option<usize>> {
    let index = PointIndex::new(places);
    let gap_m = |place: &Point3<f64>| {
        let other = index.k_nearest(place, 2).into_iter().next_back();
        other.map_or(f64::INFINITY, |other| (places[other] - place).norm())
    };
    let reach_m = places.iter().map(gap_m).fold(0.0, f64::max);
    let near = |point| {
        let (place, distance_m) = index.nearest(point)?;
        (distance_m <= reach_m).then_some(place)
    };
    points.iter().map(near).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of unit squares along x, two triangles each.
    fn strip(n: usize) -> SurfaceMesh {
        let vertex = |i: usize| Point3::new((i / 2) as f64, (i % 2) as f64, 0.0);
        let square = |i: usize| {
            let a = 2 * i as u32;
            [[a, a + 2, a + 1], [a + 1, a + 2, a + 3]]
        };
        let vertices = (0..2 * n + 2).map(vertex).collect();
        SurfaceMesh::new(vertices, (0..n).flat_map(square).collect()).unwrap()
    }

    fn column(values: &[f64]) -> Vec<Vec<f64>> {
        values.iter().map(|v| vec![*v]).collect()
    }

    /// Three places one apart; the strip's far end is out of reach.
    fn check(shell: [f64; 3], expected_share: f64) -> ShellMaps {
        let skin = strip(8);
        let places: Vec<_> = (0..3).map(|i| Point3::new(f64::from(i), 0.5, 0.0)).collect();
        let (tips, solid, shell) = (shell, column(&[1.0, 2.0, 4.0]), column(&shell));
        let tables = Tables {
            sites: places[..1].to_vec(),
            places: places.clone(),
            readings: [&solid, &shell],
            tips: [&[1.0, 2.0, 4.0], &tips],
        };
        let maps = ShellMaps::new(&skin, &tables);
        let found = maps.above_good(&skin);
        assert!((found.tip_share - expected_share).abs() < 1e-12, "{found:?}");
        assert_eq!(found.tip_share, found.readings_share);
        let gauge = tables.gauges()[0];
        assert_eq!(gauge.solid_ue_per_n, 4.0);
        assert_eq!(gauge.shell_ue_per_n, shell[2][0]);
        maps
    }

    #[test]
    fn maps_hold_the_nearest_answers_and_know_where_there_is_none() {
        let maps = check([1.0, 2.0, 4.0], 0.0);
        let [solid, shell, difference] = &maps.tip;
        assert_eq!(solid[..6], [1.0, 1.0, 2.0, 2.0, 4.0, 4.0]);
        assert_eq!(solid[..6], shell[..6]);
        assert_eq!(difference[..6], [0.0; 6]);
        assert!(solid[6..].iter().all(|v| v.is_nan()));
    }

    /// The first place has the strip's half square at its end, the others a whole one.
    #[test]
    fn shares_are_of_the_compared_area() {
        check([1.2, 2.0, 4.0], 0.2);
        check([1.05, 2.5, 4.0], 0.4);
        check([2.0, 3.0, 8.0], 1.0);
    }
}
