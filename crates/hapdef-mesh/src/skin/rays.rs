//! Rays against the boundary of a solid.

use std::cmp::Ordering;

use nalgebra::{Point3, Vector3};
use rstar::{AABB, RTree, RTreeObject, SelectionFunction};

use crate::{SurfaceMesh, Tet10Mesh, Tri6Face, face_positions};

/// Boundary faces indexed for ray queries; each six-node face counts as the four flat triangles
/// between its nodes.
#[derive(Debug)]
pub(crate) struct FaceRays {
    tree: RTree<Triangle>,
}

/// Where a ray first meets a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// Position in the slice of faces.
    pub(crate) face: usize,
    /// Distance along the ray, m.
    pub(crate) distance_m: f64,
}

impl FaceRays {
    pub(crate) fn new(mesh: &Tet10Mesh, faces: &[Tri6Face]) -> Self {
        let triangles = faces
            .iter()
            .enumerate()
            .flat_map(|(face, tri6)| {
                let p = face_positions(mesh, tri6);
                [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
                    .map(|corners| Triangle { face, corners: corners.map(|i| p[i]) })
            })
            .collect();
        Self { tree: RTree::bulk_load(triangles) }
    }

    /// The triangles of a surface, each a face of its own.
    pub(crate) fn of_surface(mesh: &SurfaceMesh) -> Self {
        let triangles = (0..mesh.triangles().len())
            .map(|face| Triangle { face, corners: mesh.corners(face) })
            .collect();
        Self { tree: RTree::bulk_load(triangles) }
    }

    /// Whether the ray meets no face other than `skip` at a distance above 0.
    pub(crate) fn is_free(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        skip: usize,
    ) -> bool {
        self.met(origin, direction, skip).next().is_none()
    }

    /// Every face other than `skip` that the ray meets at a distance above 0, the nearest first,
    /// ties by face.
    pub(crate) fn hits(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        skip: usize,
    ) -> Vec<Hit> {
        let mut hits: Vec<Hit> = self.met(origin, direction, skip).collect();
        hits.sort_by(nearer);
        hits
    }

    /// The first face other than `skip` that the ray from `origin` along the unit vector
    /// `direction` meets at a distance above 0; of equally near faces the first.
    pub(crate) fn first_hit(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        skip: usize,
    ) -> Option<Hit> {
        self.met(origin, direction, skip).min_by(nearer)
    }

    fn met(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        skip: usize,
    ) -> impl Iterator<Item = Hit> {
        let ray = Ray { origin: *origin, direction: *direction };
        self.tree
            .locate_with_selection_function(ray)
            .filter(move |triangle| triangle.face != skip)
            .filter_map(move |triangle| {
                let distance_m = triangle.distance(&ray)?;
                Some(Hit { face: triangle.face, distance_m })
            })
    }
}

/// By distance, ties by face.
fn nearer(a: &Hit, b: &Hit) -> Ordering {
    let distance = a.distance_m.total_cmp(&b.distance_m);
    distance.then(a.face.cmp(&b.face))
}

#[derive(Debug)]
struct Triangle {
    face: usize,
    corners: [Point3<f64>; 3],
}

impl RTreeObject for Triangle {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(self.corners.map(|p| p.coords.into()).iter())
    }
}

impl Triangle {
    /// Distance along the ray to this triangle (Möller and Trumbore, J. Graphics Tools 2(1), 1997).
    fn distance(&self, ray: &Ray) -> Option<f64> {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let p = ray.direction.cross(&ac);
        let determinant = ab.dot(&p);
        if determinant == 0.0 {
            return None;
        }
        let t = ray.origin - a;
        let u = t.dot(&p) / determinant;
        let q = t.cross(&ab);
        let v = ray.direction.dot(&q) / determinant;
        let distance = ac.dot(&q) / determinant;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
    }
}

#[derive(Clone, Copy, Debug)]
struct Ray {
    origin: Point3<f64>,
    direction: Vector3<f64>,
}

impl SelectionFunction<Triangle> for Ray {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 3]>) -> bool {
        let (low, high) = (envelope.lower(), envelope.upper());
        let (mut from, mut to) = (0.0_f64, f64::INFINITY);
        for k in 0..3 {
            let (origin, direction) = (self.origin[k], self.direction[k]);
            if direction == 0.0 {
                if origin < low[k] || origin > high[k] {
                    return false;
                }
                continue;
            }
            let (a, b) = ((low[k] - origin) / direction, (high[k] - origin) / direction);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        // a flat box can lose its thickness to rounding
        from <= to * (1.0 + 1e-12)
    }
}

/// `n` unit vectors spread evenly over the cone of half angle `half_angle_rad` about `axis`
/// (Fibonacci lattice on the spherical cap); the same for the same input.
pub(crate) fn cone(axis: &Vector3<f64>, half_angle_rad: f64, n: usize) -> Vec<Vector3<f64>> {
    let helper = if axis.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let e1 = axis.cross(&helper).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let e2 = axis.cross(&e1);
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..n)
        .map(|i| {
            let height = 1.0 - (1.0 - half_angle_rad.cos()) * (i as f64 + 0.5) / n as f64;
            let across = (1.0 - height * height).max(0.0).sqrt();
            let (sin, cos) = (golden * i as f64).sin_cos();
            axis * height + (e1 * cos + e2 * sin) * across
        })
        .collect()
}
