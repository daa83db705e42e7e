//! Which triangles of a solid see the outside, and how thick the material is behind them.

use nalgebra::{Point3, Vector3};

/// What a triangle of the solid is to the shell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallKind {
    /// It does not see the outside.
    Inside,
    /// Outer skin with a wall behind it.
    Shell,
    /// Outer skin whose material ends at outer skin again: a solid core, or a plate.
    SolidCore,
    /// Outer skin without a wall parallel to it: a rim, an end, a corner.
    NoWall,
    /// Outer skin with a wall too thick for a shell.
    TooThick,
    /// A shell, but not connected with the largest piece.
    Island,
}

use super::SolidShellParams;
use crate::SurfaceMesh;
use crate::skin::rays::{FaceRays, cone};

/// Every triangle of a solid, judged.
pub(super) struct Walls {
    /// What each triangle is; no islands yet.
    pub kinds: Vec<WallKind>,
    /// The wall's thickness behind each triangle, m; 0 where none was found.
    pub thickness_m: Vec<f64>,
    /// The same near its three corners; the triangle's own where a corner has none.
    pub corners_m: Vec<[f64; 3]>,
}

impl Walls {
    pub fn of(solid: &SurfaceMesh, params: &SolidShellParams) -> Self {
        let probe = Probe::new(solid, params);
        let n = solid.triangles().len();
        let free: Vec<f64> = (0..n).map(|t| probe.free_fraction(t)).collect();
        let is_outer: Vec<bool> = (0..n).map(|t| probe.is_outer(t, &free)).collect();
        let mut walls = Self {
            kinds: vec![WallKind::Inside; n],
            thickness_m: vec![0.0; n],
            corners_m: vec![[0.0; 3]; n],
        };
        for triangle in (0..n).filter(|&t| is_outer[t]) {
            let wall = probe.wall(triangle, &is_outer);
            walls.kinds[triangle] = wall.kind;
            walls.thickness_m[triangle] = wall.thickness_m;
            walls.corners_m[triangle] = wall.corners_m;
        }
        walls
    }
}

struct Wall {
    kind: WallKind,
    thickness_m: f64,
    corners_m: [f64; 3],
}

/// Where in a triangle is measured: near its corners, and its middle.
const SAMPLES: [[f64; 3]; 4] =
    [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8], [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0]];

struct Probe<'a> {
    solid: &'a SurfaceMesh,
    params: &'a SolidShellParams,
    rays: FaceRays,
    normals: Vec<Vector3<f64>>,
}

impl<'a> Probe<'a> {
    fn new(solid: &'a SurfaceMesh, params: &'a SolidShellParams) -> Self {
        let unit = |t| solid.area_normal_m2(t).try_normalize(0.0);
        let n = solid.triangles().len();
        Self {
            solid,
            params,
            rays: FaceRays::of_surface(solid),
            normals: (0..n).map(|t| unit(t).unwrap_or_else(Vector3::zeros)).collect(),
        }
    }

    /// The part of the cone about a triangle's normal that leaves the solid.
    fn free_fraction(&self, triangle: usize) -> f64 {
        let outer = &self.params.outer;
        let centre = self.sample(triangle, SAMPLES[3]);
        let free = cone(&self.normals[triangle], outer.cone_half_angle_rad, outer.n_rays)
            .iter()
            .filter(|direction| self.rays.is_free(&centre, direction, triangle))
            .count();
        free as f64 / outer.n_rays as f64
    }

    /// Whether a triangle is free enough, or clearly freer than what ends the material behind it.
    fn is_outer(&self, triangle: usize, free: &[f64]) -> bool {
        if free[triangle] > self.params.outer.min_free_fraction {
            return true;
        }
        let (centre, inward) = (self.sample(triangle, SAMPLES[3]), -self.normals[triangle]);
        let behind = self.rays.first_hit(&centre, &inward, triangle);
        behind.is_some_and(|hit| free[triangle] > free[hit.face] + self.params.min_free_lead)
    }

    fn sample(&self, triangle: usize, weights: [f64; 3]) -> Point3<f64> {
        let corners = self.solid.corners(triangle);
        let sum: Vector3<f64> = corners.iter().zip(weights).map(|(p, w)| p.coords * w).sum();
        Point3::from(sum)
    }

    /// The wall behind an outer triangle.
    fn wall(&self, triangle: usize, is_outer: &[bool]) -> Wall {
        let samples =
            SAMPLES.map(|weights| self.thickness(triangle, &self.sample(triangle, weights)));
        let mut found: Vec<f64> = samples.iter().flatten().copied().collect();
        if found.len() < 2 {
            return Wall { kind: WallKind::NoWall, thickness_m: 0.0, corners_m: [0.0; 3] };
        }
        let thickness_m = median(&mut found);
        Wall {
            kind: self.kind(triangle, thickness_m, is_outer),
            thickness_m,
            corners_m: [0, 1, 2].map(|corner| samples[corner].unwrap_or(thickness_m)),
        }
    }

    /// The median over the cone of the distance to a parallel wall, if most rays meet one.
    fn thickness(&self, triangle: usize, from: &Point3<f64>) -> Option<f64> {
        let params = self.params;
        let inward = -self.normals[triangle];
        let directions = cone(&inward, params.wall_cone_half_angle_rad, params.n_wall_rays);
        let mut found: Vec<f64> = directions
            .iter()
            .filter_map(|direction| {
                let hit = self.rays.first_hit(from, direction, triangle)?;
                let is_parallel =
                    self.normals[hit.face].dot(&inward) >= params.max_wall_angle_rad.cos();
                is_parallel.then(|| hit.distance_m * direction.dot(&inward))
            })
            .collect();
        (2 * found.len() > directions.len()).then(|| median(&mut found))
    }

    /// By what lies straight behind the triangle's middle, and how far the limb goes on there.
    fn kind(&self, triangle: usize, thickness_m: f64, is_outer: &[bool]) -> WallKind {
        let (centre, inward) = (self.sample(triangle, SAMPLES[3]), -self.normals[triangle]);
        let Some(first) = self.rays.first_hit(&centre, &inward, triangle) else {
            return WallKind::NoWall;
        };
        if is_outer[first.face] {
            WallKind::SolidCore
        } else if thickness_m > self.params.max_thickness_ratio * self.extent_m(triangle) {
            WallKind::TooThick
        } else {
            WallKind::Shell
        }
    }

    /// How far the limb extends inward: the farthest surface that a ray of the cone meets, so that
    /// a hole on the far side doesn't hide it.
    fn extent_m(&self, triangle: usize) -> f64 {
        let (centre, inward) = (self.sample(triangle, SAMPLES[3]), -self.normals[triangle]);
        let params = self.params;
        let directions = cone(&inward, params.wall_cone_half_angle_rad, params.n_wall_rays);
        let farthest = directions.iter().filter_map(|direction| {
            let hits = self.rays.hits(&centre, direction, triangle);
            Some(hits.last()?.distance_m * direction.dot(&inward))
        });
        farthest.fold(0.0, f64::max)
    }
}

/// The middle one; the lower of two.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(values.len() - 1) / 2]
}
