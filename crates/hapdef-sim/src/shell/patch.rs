//! The piece of mid-surface a gauge is glued to, and points on it.

use std::collections::{BTreeMap, BTreeSet};

use hapdef_mesh::FeNodeId;
use nalgebra::{Point3, Vector3};

use super::ShellMesh;
use crate::gauges::wall::nearest_on_triangle;

/// A triangle belongs to the patch only if its normal is within 60° of the normal at the gauge.
const MIN_NORMAL_AGREEMENT: f64 = 0.5;

/// Barycentric coordinates may leave a triangle by this much before a point counts as off it.
const EDGE_TOLERANCE: f64 = 1e-9;

/// Triangles around the one under the gauge, reachable over shared sides.
pub(super) struct ShellPatch {
    triangles: Vec<(usize, [Point3<f64>; 3])>,
    /// The point of the mid-surface nearest to the gauge's centre, m.
    pub(super) origin: Point3<f64>,
    /// The unit normal of the facet there.
    pub(super) normal: Vector3<f64>,
}

/// A point on a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchPoint {
    pub(super) triangle: usize,
    /// Barycentric coordinates.
    pub(super) at: [f64; 3],
}

impl ShellPatch {
    /// The patch at the point of `mesh` nearest to `centre`, within `reach_m` of it, and the
    /// distance to it, m; nothing on a mesh without triangles.
    pub(super) fn at(mesh: &ShellMesh, centre: &Point3<f64>, reach_m: f64) -> Option<(Self, f64)> {
        let (start, origin, distance_m) = triangle_under(mesh, centre)?;
        let normal = normal_of(&mesh.corners(start))?;
        let near = |triangle: usize| {
            let corners = mesh.corners(triangle);
            (corners[0] - origin).norm() <= reach_m + size_m(&corners)
                && normal_of(&corners).is_some_and(|n| n.dot(&normal) > MIN_NORMAL_AGREEMENT)
        };
        let candidates: Vec<usize> = (0..mesh.triangles().len()).filter(|&t| near(t)).collect();
        let triangles = connected(mesh, start, &candidates);
        let triangles = triangles.into_iter().map(|t| (t, mesh.corners(t))).collect();
        Some((Self { triangles, origin, normal }, distance_m))
    }

    /// Where the line through `point` along the patch's normal meets it, nearest to `point` and
    /// within `reach_m` of it.
    pub(super) fn project(&self, point: &Point3<f64>, reach_m: f64) -> Option<PatchPoint> {
        self.triangles
            .iter()
            .filter_map(|(triangle, [a, b, c])| {
                // volumes spanned with the normal are areas seen along it
                let area = |u: Vector3<f64>, v: Vector3<f64>| u.cross(&v).dot(&self.normal);
                let whole = area(b - a, c - a);
                let at = [
                    area(b - point, c - point) / whole,
                    area(c - point, a - point) / whole,
                    area(a - point, b - point) / whole,
                ];
                let inside = at.iter().all(|&l| l >= -EDGE_TOLERANCE);
                let foot = a.coords * at[0] + b.coords * at[1] + c.coords * at[2];
                let height_m = (foot - point.coords).norm();
                let hit = PatchPoint { triangle: *triangle, at };
                (inside && height_m <= reach_m).then_some((height_m, hit))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, hit)| hit)
    }
}

/// The triangle nearest to a point, the point on it, and how far that is, m.
fn triangle_under(mesh: &ShellMesh, point: &Point3<f64>) -> Option<(usize, Point3<f64>, f64)> {
    let mut best: Option<(usize, Point3<f64>, f64)> = None;
    for triangle in 0..mesh.triangles().len() {
        let best_m = best.map_or(f64::INFINITY, |(_, _, distance_m)| distance_m);
        let corners = mesh.corners(triangle);
        if (corners[0] - point).norm() - size_m(&corners) > best_m {
            continue;
        }
        let (s, t) = nearest_on_triangle(&corners, point);
        let [a, b, c] = corners;
        let nearest = a + (b - a) * s + (c - a) * t;
        let distance_m = (nearest - point).norm();
        if distance_m < best_m {
            best = Some((triangle, nearest, distance_m));
        }
    }
    best
}

/// More than the distance of any point of a triangle from its first corner, m.
fn size_m([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    (b - a).norm() + (c - a).norm()
}

fn normal_of([a, b, c]: &[Point3<f64>; 3]) -> Option<Vector3<f64>> {
    (b - a).cross(&(c - a)).try_normalize(0.0)
}

/// Those of `candidates` (with `start`) that are reached from `start` over shared sides, ascending.
fn connected(mesh: &ShellMesh, start: usize, candidates: &[usize]) -> Vec<usize> {
    let sides = |triangle: usize| {
        let [a, b, c] = mesh.triangles()[triangle];
        [[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)])
    };
    let mut by_side: BTreeMap<[FeNodeId; 2], Vec<usize>> = BTreeMap::new();
    for &triangle in candidates {
        for side in sides(triangle) {
            by_side.entry(side).or_default().push(triangle);
        }
    }
    let mut reached = BTreeSet::from([start]);
    let mut open = vec![start];
    while let Some(from) = open.pop() {
        let beside = sides(from).into_iter().filter_map(|side| by_side.get(&side)).flatten();
        open.extend(beside.copied().filter(|&triangle| reached.insert(triangle)));
    }
    reached.into_iter().collect()
}
