//! The piece of mid-surface a gauge is glued to, and points on it.

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
        let nearest = |triangle: usize| {
            let corners = mesh.corners(triangle);
            let (s, t) = nearest_on_triangle(&corners, centre);
            let [a, b, c] = corners;
            let point = a + (b - a) * s + (c - a) * t;
            (triangle, point, (point - centre).norm())
        };
        let (start, origin, distance_m) =
            (0..mesh.triangles().len()).map(nearest).min_by(|a, b| a.2.total_cmp(&b.2))?;
        let normal = normal_of(&mesh.corners(start))?;
        let near = |triangle: usize| {
            let corners = mesh.corners(triangle);
            let size = (corners[1] - corners[0]).norm() + (corners[2] - corners[0]).norm();
            (corners[0] - origin).norm() <= reach_m + size
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

fn normal_of([a, b, c]: &[Point3<f64>; 3]) -> Option<Vector3<f64>> {
    (b - a).cross(&(c - a)).try_normalize(0.0)
}

/// Those of `candidates` (ascending, with `start`) that are reached from `start` over shared sides.
fn connected(mesh: &ShellMesh, start: usize, candidates: &[usize]) -> Vec<usize> {
    let shares_side = |s: usize, t: usize| {
        let other = mesh.triangles()[t];
        let common = mesh.triangles()[s].iter().filter(|n| other.contains(n));
        common.count() >= 2
    };
    let mut reached = vec![start];
    let mut next = 0;
    while next < reached.len() {
        let from = reached[next];
        let new = candidates.iter().copied();
        let new: Vec<usize> =
            new.filter(|&t| !reached.contains(&t) && shares_side(from, t)).collect();
        reached.extend(new);
        next += 1;
    }
    reached.sort_unstable();
    reached
}
