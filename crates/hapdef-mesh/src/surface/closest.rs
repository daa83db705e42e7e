//! The nearest point of a triangle surface or of a set of edges.

use nalgebra::{Point3, Vector3};
use rstar::{AABB, PointDistance, RTree, RTreeObject};

use crate::SurfaceMesh;

/// Triangles, or edges as triangles of two corners, indexed for nearest-point queries.
#[derive(Debug)]
pub struct ClosestPoint {
    tree: RTree<Entry>,
}

/// What a query found.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// The nearest point, m.
    pub point: Point3<f64>,
    /// Its distance from the query, m.
    pub distance_m: f64,
}

/// How many candidates are asked whether they agree before the nearest is taken after all.
const MAX_CANDIDATES: usize = 64;

impl ClosestPoint {
    /// The triangles of a surface.
    #[must_use]
    pub fn of_surface(mesh: &SurfaceMesh) -> Self {
        let entry = |triangle| {
            let normal = mesh.area_normal_m2(triangle).try_normalize(0.0);
            Entry {
                corners: mesh.corners(triangle),
                direction: normal.unwrap_or_else(Vector3::zeros),
            }
        };
        Self { tree: RTree::bulk_load((0..mesh.triangles().len()).map(entry).collect()) }
    }

    pub(crate) fn of_edges(edges: impl Iterator<Item = [Point3<f64>; 2]>) -> Self {
        let entry = |[a, b]: [Point3<f64>; 2]| Entry {
            corners: [a, b, b],
            direction: (b - a).try_normalize(0.0).unwrap_or_else(Vector3::zeros),
        };
        Self { tree: RTree::bulk_load(edges.map(entry).collect()) }
    }

    /// The nearest point; `None` only where there is nothing.
    #[must_use]
    pub fn nearest(&self, query: &Point3<f64>) -> Option<Closest> {
        let entry = self.tree.nearest_neighbor(query.coords.into())?;
        Some(entry.closest(query))
    }

    /// The nearest point among triangles whose unit normal, or edges whose direction, `agrees`;
    /// the nearest of all if the nearest 64 don't.
    pub(crate) fn nearest_that(
        &self,
        query: &Point3<f64>,
        agrees: impl Fn(&Vector3<f64>) -> bool,
    ) -> Option<Closest> {
        let mut candidates = self.tree.nearest_neighbor_iter(query.coords.into());
        let found = candidates.by_ref().take(MAX_CANDIDATES).find(|entry| agrees(&entry.direction));
        match found {
            Some(entry) => Some(entry.closest(query)),
            None => self.nearest(query),
        }
    }
}

#[derive(Debug)]
struct Entry {
    corners: [Point3<f64>; 3],
    direction: Vector3<f64>,
}

impl RTreeObject for Entry {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(self.corners.map(|p| p.coords.into()).iter())
    }
}

impl PointDistance for Entry {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let query = Point3::from(*point);
        (closest_on_triangle(&self.corners, &query) - query).norm_squared()
    }
}

impl Entry {
    fn closest(&self, query: &Point3<f64>) -> Closest {
        let point = closest_on_triangle(&self.corners, query);
        Closest { point, distance_m: (point - query).norm() }
    }
}

/// The nearest point of a triangle, degenerate or not: inside if the query projects there, else on
/// the nearest edge (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
fn closest_on_triangle([a, b, c]: &[Point3<f64>; 3], p: &Point3<f64>) -> Point3<f64> {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(&ac);
    let area_2 = normal.norm_squared();
    if area_2 > 0.0 {
        let v = normal.dot(&ap.cross(&ac)) / area_2;
        let w = normal.dot(&ab.cross(&ap)) / area_2;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return a + ab * v + ac * w;
        }
    }
    let mut best = closest_on_edge(a, b, p);
    for (from, to) in [(b, c), (c, a)] {
        let other = closest_on_edge(from, to, p);
        if (other - p).norm_squared() < (best - p).norm_squared() {
            best = other;
        }
    }
    best
}

fn closest_on_edge(a: &Point3<f64>, b: &Point3<f64>, p: &Point3<f64>) -> Point3<f64> {
    let ab = b - a;
    let length_2 = ab.norm_squared();
    if length_2 > 0.0 { a + ab * ((p - a).dot(&ab) / length_2).clamp(0.0, 1.0) } else { *a }
}
