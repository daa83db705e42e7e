//! What is wrong with a triangle surface.

use std::fmt;

use super::crossing::{Crossing, number, places};
use super::self_intersection::self_intersections;
use crate::surface::topology::repeats;
use crate::surface::topology::{Edges, count_bodies, count_doubled};
use crate::surface::triangles::corner_angles_rad;
use crate::{BoundingBox, SurfaceMesh, UnitGuess};

/// Triangles with a smaller angle are slivers, degrees.
pub const SLIVER_ANGLE_DEG: f64 = 10.0;

/// A triangle whose height over its longest edge is below this part of that edge has no area to
/// speak of: a few roundings of 32-bit coordinates.
const DEGENERATE_HEIGHT: f64 = 1e-6;

/// A surface in numbers. It describes the mesh as it is: a mesh whose triangles do not share
/// vertices has only open edges, so [`SurfaceMesh::weld`] first.
#[derive(Clone, Debug, PartialEq)]
pub struct QualityReport {
    /// Vertices, used or not.
    pub n_vertices: usize,
    /// Vertices that no triangle uses.
    pub n_unused_vertices: usize,
    /// Triangles.
    pub n_triangles: usize,
    /// Bodies: sets of triangles connected across edges.
    pub n_bodies: usize,
    /// Edges with one triangle: holes and rims.
    pub n_open_edges: usize,
    /// Edges with more than two triangles.
    pub n_non_manifold_edges: usize,
    /// Edges whose two triangles do not agree on which side is outside.
    pub n_misoriented_edges: usize,
    /// Triangles with the same three vertices as an earlier one.
    pub n_doubled_triangles: usize,
    /// Triangles without area: a repeated corner, or a height below a millionth of the longest
    /// edge.
    pub n_degenerate_triangles: usize,
    /// Triangles with area, but an angle below [`SLIVER_ANGLE_DEG`].
    pub n_sliver_triangles: usize,
    /// Pairs of triangles that cross ([`self_intersections`]).
    pub crossings: Vec<Crossing>,
    /// Holes through the solid, summed over the bodies: V − E + F = 2·bodies − 2·genus. Nothing
    /// unless the surface is [closed](Self::is_closed) and no vertex joins otherwise separate
    /// sheets.
    pub genus: Option<usize>,
    /// Area of all triangles, m².
    pub area_m2: f64,
    /// Enclosed volume, m³; positive when the triangles face outward. Means something only where
    /// [`is_closed`](Self::is_closed) holds.
    pub signed_volume_m3: f64,
    /// The box around all vertices, m.
    pub bounding_box: BoundingBox,
    /// Which unit the coordinates may be in, if they are not metres after all.
    pub unit_guess: UnitGuess,
}

impl QualityReport {
    /// Looks at every triangle and edge of `mesh`.
    #[must_use]
    pub fn of(mesh: &SurfaceMesh) -> Self {
        let edges = Edges::of(mesh.triangles());
        let bounding_box = mesh.bounding_box();
        let (n_degenerate_triangles, n_sliver_triangles) = count_shapes(mesh);
        let n_used_vertices = count_used_vertices(mesh);
        let mut report = Self {
            n_vertices: mesh.vertices().len(),
            n_unused_vertices: mesh.vertices().len() - n_used_vertices,
            n_triangles: mesh.triangles().len(),
            n_bodies: count_bodies(mesh.triangles()),
            n_open_edges: edges.n_open,
            n_non_manifold_edges: edges.n_non_manifold,
            n_misoriented_edges: edges.n_misoriented,
            n_doubled_triangles: count_doubled(mesh.triangles()),
            n_degenerate_triangles,
            n_sliver_triangles,
            crossings: self_intersections(mesh),
            genus: None,
            area_m2: mesh.area_m2(),
            signed_volume_m3: mesh.signed_volume_m3(),
            bounding_box,
            unit_guess: UnitGuess::of_length(bounding_box.longest_m()),
        };
        if report.is_closed() {
            report.genus =
                genus(n_used_vertices, edges.n_edges, report.n_triangles, report.n_bodies);
        }
        report
    }

    /// Whether every edge has exactly two triangles that agree on the outside: the surface then
    /// bounds a solid, and its volume means something.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.n_open_edges == 0 && self.n_non_manifold_edges == 0 && self.n_misoriented_edges == 0
    }
}

impl fmt::Display for QualityReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.bounding_box.size_m() * 1e3;
        let with_share =
            |n: usize| format!("{n} ({:.1} %)", 100.0 * n as f64 / self.n_triangles as f64);
        let volume = if self.is_closed() {
            format!("{:.3} cm³", self.signed_volume_m3 * 1e6)
        } else {
            "not defined, the surface is not closed".to_owned()
        };
        let crossings = match &self.crossings[..] {
            [] => "0".to_owned(),
            some => format!("{}, at {}", number(some), places(some)),
        };
        let lines = [
            ("triangles", format!("{} on {} vertices", self.n_triangles, self.n_vertices)),
            ("bodies", self.n_bodies.to_string()),
            ("size", format!("{:.1} × {:.1} × {:.1} mm", size.x, size.y, size.z)),
            ("unit", self.unit_guess.to_string()),
            ("area", format!("{:.2} cm²", self.area_m2 * 1e4)),
            ("volume", volume),
            ("through holes", self.genus.map_or("unknown".to_owned(), |g| g.to_string())),
            ("open edges", self.n_open_edges.to_string()),
            ("non-manifold edges", self.n_non_manifold_edges.to_string()),
            ("misoriented edges", self.n_misoriented_edges.to_string()),
            ("doubled triangles", self.n_doubled_triangles.to_string()),
            ("crossing pairs", crossings),
            ("unused vertices", self.n_unused_vertices.to_string()),
            ("without area", with_share(self.n_degenerate_triangles)),
            ("angle below 10°", with_share(self.n_sliver_triangles)),
        ];
        for (i, (label, text)) in lines.iter().enumerate() {
            let line_break = if i == 0 { "" } else { "\n" };
            write!(f, "{line_break}{label:<20}{text}")?;
        }
        Ok(())
    }
}

fn count_shapes(mesh: &SurfaceMesh) -> (usize, usize) {
    let (mut n_degenerate, mut n_slivers) = (0, 0);
    for (triangle, corners) in mesh.triangles().iter().enumerate() {
        if repeats(corners) || is_flat(mesh, triangle) {
            n_degenerate += 1;
        } else if smallest_angle_deg(mesh, triangle) < SLIVER_ANGLE_DEG {
            n_slivers += 1;
        }
    }
    (n_degenerate, n_slivers)
}

/// Whether a triangle without a repeated corner has no area to speak of.
pub(crate) fn is_flat(mesh: &SurfaceMesh, triangle: usize) -> bool {
    let [a, b, c] = mesh.corners(triangle);
    let longest = [b - a, c - b, a - c].map(|e| e.norm()).into_iter().fold(0.0, f64::max);
    let height = 2.0 * mesh.area_normal_m2(triangle).norm() / longest;
    // A triangle of one point has a height of 0/0.
    height.is_nan() || height <= DEGENERATE_HEIGHT * longest
}

fn smallest_angle_deg(mesh: &SurfaceMesh, triangle: usize) -> f64 {
    corner_angles_rad(&mesh.corners(triangle)).into_iter().fold(f64::MAX, f64::min).to_degrees()
}

fn count_used_vertices(mesh: &SurfaceMesh) -> usize {
    let mut is_used = vec![false; mesh.vertices().len()];
    mesh.triangles().iter().flatten().for_each(|&v| is_used[v as usize] = true);
    is_used.iter().filter(|used| **used).count()
}

/// Euler's formula for a closed surface; nothing when it gives no whole, non-negative number.
fn genus(n_vertices: usize, n_edges: usize, n_triangles: usize, n_bodies: usize) -> Option<usize> {
    let [v, e, f, b] = [n_vertices, n_edges, n_triangles, n_bodies].map(|n| n as i64);
    let twice = 2 * b - (v - e + f);
    if twice % 2 == 0 { usize::try_from(twice / 2).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix4, Point3, Vector3};

    use super::*;
    use crate::surface::triangles::tests::{cuboid, sphere};

    fn with_triangles(mesh: &SurfaceMesh, triangles: Vec<[u32; 3]>) -> QualityReport {
        QualityReport::of(&SurfaceMesh::new(mesh.vertices().to_vec(), triangles).unwrap())
    }

    #[test]
    fn a_box_is_closed() {
        let report = QualityReport::of(&cuboid(0.1, 0.2, 0.3));
        assert!(report.is_closed());
        assert_eq!((report.n_bodies, report.genus), (1, Some(0)));
        assert_eq!((report.n_degenerate_triangles, report.n_sliver_triangles), (0, 0));
        assert!((report.signed_volume_m3 - 0.006).abs() < 1e-15);
        assert!((report.area_m2 - 0.22).abs() < 1e-15);
    }

    #[test]
    fn a_box_without_a_side_is_open() {
        let mesh = cuboid(1.0, 1.0, 1.0);
        let report = with_triangles(&mesh, mesh.triangles()[2..].to_vec());
        assert_eq!((report.n_open_edges, report.n_non_manifold_edges), (4, 0));
        assert_eq!((report.is_closed(), report.genus), (false, None));
        assert!(report.to_string().contains("not closed"), "{report}");
    }

    #[test]
    fn a_doubled_triangle_makes_non_manifold_edges() {
        let mesh = cuboid(1.0, 1.0, 1.0);
        let mut triangles = mesh.triangles().to_vec();
        let [a, b, c] = triangles[0];
        triangles.push([c, a, b]);
        let report = with_triangles(&mesh, triangles);
        assert_eq!((report.n_doubled_triangles, report.n_non_manifold_edges), (1, 3));
    }

    #[test]
    fn a_turned_triangle_disagrees_with_its_three_neighbours() {
        let mesh = cuboid(1.0, 1.0, 1.0);
        let mut triangles = mesh.triangles().to_vec();
        triangles[5].swap(0, 1);
        let report = with_triangles(&mesh, triangles);
        assert_eq!((report.n_misoriented_edges, report.is_closed()), (3, false));
    }

    #[test]
    fn slivers_and_degenerate_triangles_are_told_apart() {
        let p = Point3::new;
        let vertices = vec![
            p(0.0, 0.0, 0.0),
            p(1.0, 0.0, 0.0),
            p(0.5, 0.05, 0.0),
            p(0.5, 0.0, 0.0),
            p(0.5, 1.0, 0.0),
        ];
        let triangles = vec![[0, 1, 2], [0, 1, 3], [0, 1, 1], [0, 1, 4]];
        let report = QualityReport::of(&SurfaceMesh::new(vertices, triangles).unwrap());
        assert_eq!((report.n_sliver_triangles, report.n_degenerate_triangles), (1, 2));
    }

    /// A frame: a square with a square hole, drawn as a closed solid of genus 1.
    #[test]
    fn a_ring_has_one_through_hole_and_two_rings_have_two() {
        let ring = ring(12, 6);
        let report = QualityReport::of(&ring);
        assert_eq!((report.n_bodies, report.genus, report.is_closed()), (1, Some(1), true));
        let n = ring.vertices().len() as u32;
        let far = ring.transformed(&Matrix4::new_translation(&Vector3::x())).unwrap();
        let vertices = [ring.vertices(), far.vertices()].concat();
        let shifted = far.triangles().iter().map(|t| t.map(|v| v + n));
        let triangles = ring.triangles().iter().copied().chain(shifted).collect();
        let report = QualityReport::of(&SurfaceMesh::new(vertices, triangles).unwrap());
        assert_eq!((report.n_bodies, report.genus), (2, Some(2)));
    }

    /// The torus with radii 0.1 and 0.03 m: V = 2π² R r², A = 4π² R r.
    fn ring(n: u32, m: u32) -> SurfaceMesh {
        let angle = |i: u32, n: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        let vertex = |k: u32| {
            let (u, v) = (angle(k / m, n), angle(k % m, m));
            let radius = 0.1 + 0.03 * v.cos();
            Point3::new(radius * u.cos(), radius * u.sin(), 0.03 * v.sin())
        };
        let quad = |k: u32| {
            let at = |i: u32, j: u32| (i % n) * m + j % m;
            let (i, j) = (k / m, k % m);
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        let triangles = (0..n * m).flat_map(quad).collect();
        SurfaceMesh::new((0..n * m).map(vertex).collect(), triangles).unwrap()
    }

    #[test]
    fn a_fine_ring_has_the_volume_and_area_of_a_torus() {
        let report = QualityReport::of(&ring(200, 100));
        let pi2 = std::f64::consts::PI.powi(2);
        assert!((report.signed_volume_m3 / (2.0 * pi2 * 0.1 * 0.0009) - 1.0).abs() < 2e-3);
        assert!((report.area_m2 / (4.0 * pi2 * 0.1 * 0.03) - 1.0).abs() < 2e-3);
    }

    #[test]
    fn a_sphere_reads_well() {
        let report = QualityReport::of(&sphere(3).scaled(0.1).unwrap());
        let text = report.to_string();
        assert!(text.contains("size                200.0 × 200.0 × 200.0 mm"), "{text}");
        assert!(text.contains("open edges          0\n"), "{text}");
    }
}
