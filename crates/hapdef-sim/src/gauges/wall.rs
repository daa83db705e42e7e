//! The piece of wall a gauge is glued to, and points on it.

use hapdef_mesh::{Tet10Mesh, Tri6Face, connected_faces, face_positions, tri6};
use nalgebra::{Matrix2, Point3, Vector2, Vector3};

/// A face belongs to the wall only if its normal is within 60° of the normal at the gauge, the
/// rule of [`hapdef_mesh::gauge_patch`].
const MIN_NORMAL_AGREEMENT: f64 = 0.5;

/// Parent coordinates may leave the face by this much before a point counts as off it.
const EDGE_TOLERANCE: f64 = 1e-9;

/// No point of a quadratic triangle is farther from its first node than this many times the farthest node is: the
/// absolute values of its shape functions add up to at most 5/3; the rest is for rounding.
const FARTHEST_POINT: f64 = 1.7;

/// A wall: faces reachable from the one under the gauge over shared edges.
pub(crate) struct Wall {
    faces: Vec<PlacedFace>,
    /// The point of the wall nearest to the gauge's centre, m.
    pub(crate) origin: Point3<f64>,
    /// The outward unit normal there.
    pub(crate) normal: Vector3<f64>,
}

/// A point on a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallPoint {
    pub(crate) face: Tri6Face,
    pub(crate) xi: f64,
    pub(crate) eta: f64,
    /// The outward unit normal there.
    pub(crate) normal: Vector3<f64>,
}

impl Wall {
    /// The wall at the point of `faces` nearest to `centre`, and the distance to it, m; only faces
    /// within `reach_m` of that point are kept. Nothing if there are no usable faces.
    pub(crate) fn at(
        mesh: &Tet10Mesh,
        faces: &[Tri6Face],
        centre: &Point3<f64>,
        reach_m: f64,
    ) -> Option<(Self, f64)> {
        let (under, [xi, eta], distance_m) = face_under(mesh, faces, centre)?;
        let origin = tri6::position(&under.nodes, xi, eta);
        let normal = unit_normal(&under.nodes, xi, eta)?;
        let placed = faces.iter().map(|face| PlacedFace::new(mesh, face));
        let near: Vec<PlacedFace> = placed
            .filter(|face| face.face == under.face || face.has_node_near(&origin, reach_m))
            .collect();
        let start = near.iter().position(|face| face.face == under.face)?;
        let agrees = |i: usize| {
            unit_normal(&near[i].nodes, 1.0 / 3.0, 1.0 / 3.0)
                .is_some_and(|other| other.dot(&normal) > MIN_NORMAL_AGREEMENT)
        };
        let near_faces: Vec<Tri6Face> = near.iter().map(|face| face.face).collect();
        let reached = connected_faces(&near_faces, start, agrees);
        let faces = near.into_iter().zip(reached).filter(|(_, r)| *r).map(|(f, _)| f).collect();
        Some((Self { faces, origin, normal }, distance_m))
    }

    /// Where the line through `point` along the wall's normal meets the wall, nearest to `point` and
    /// within `reach_m` of it.
    pub(crate) fn project(&self, point: &Point3<f64>, reach_m: f64) -> Option<WallPoint> {
        let [u, v] = tangents_of(&self.normal);
        self.faces
            .iter()
            .filter(|face| {
                let to_face = face.nodes[0] - point;
                to_face.dot(&u).hypot(to_face.dot(&v)) <= face.farthest_m
            })
            .filter_map(|PlacedFace { face, nodes, .. }| {
                let (xi, eta) = meet_line(nodes, point, &u, &v)?;
                let height_m = (tri6::position(nodes, xi, eta) - point).norm();
                let normal = unit_normal(nodes, xi, eta)?;
                let hit = WallPoint { face: *face, xi, eta, normal };
                (height_m <= reach_m).then_some((height_m, hit))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, hit)| hit)
    }
}

/// A face with its nodes, m.
struct PlacedFace {
    face: Tri6Face,
    nodes: [Point3<f64>; 6],
    /// The largest distance of a node from the first, m.
    extent_m: f64,
    /// No point of the face is farther from the first node, m.
    farthest_m: f64,
}

impl PlacedFace {
    fn new(mesh: &Tet10Mesh, face: &Tri6Face) -> Self {
        let nodes = face_positions(mesh, face);
        let extent_m = nodes.iter().map(|p| (p - nodes[0]).norm()).fold(0.0, f64::max);
        Self { face: *face, nodes, extent_m, farthest_m: FARTHEST_POINT * extent_m }
    }

    fn has_node_near(&self, point: &Point3<f64>, reach_m: f64) -> bool {
        self.nodes.iter().any(|node| (node - point).norm() <= reach_m + self.extent_m)
    }
}

/// The face nearest to a point, where on it in parent coordinates, and how far that is, m.
fn face_under(
    mesh: &Tet10Mesh,
    faces: &[Tri6Face],
    point: &Point3<f64>,
) -> Option<(PlacedFace, [f64; 2], f64)> {
    let mut best: Option<(PlacedFace, [f64; 2], f64)> = None;
    for face in faces {
        let face = PlacedFace::new(mesh, face);
        let best_m = best.as_ref().map_or(f64::INFINITY, |(_, _, distance_m)| *distance_m);
        if (face.nodes[0] - point).norm() - face.farthest_m > best_m {
            continue;
        }
        let (xi, eta, distance_m) = nearest_on_face(&face.nodes, point);
        if distance_m < best_m {
            best = Some((face, [xi, eta], distance_m));
        }
    }
    best
}

fn unit_normal(nodes: &[Point3<f64>; 6], xi: f64, eta: f64) -> Option<Vector3<f64>> {
    tri6::area_vector(nodes, xi, eta).try_normalize(0.0)
}

fn tangents_of(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = (0..3).fold(0, |a, b| if normal[b].abs() < normal[a].abs() { b } else { a });
    let u = normal.cross(&Vector3::ith(least, 1.0));
    let u = u / u.norm();
    [u, normal.cross(&u)]
}

/// Newton's method for (x(ξ, η) − point) · u = 0 and · v = 0, from the face's middle; nothing if the
/// line misses the face.
fn meet_line(
    nodes: &[Point3<f64>; 6],
    point: &Point3<f64>,
    u: &Vector3<f64>,
    v: &Vector3<f64>,
) -> Option<(f64, f64)> {
    let (mut xi, mut eta) = (1.0 / 3.0, 1.0 / 3.0);
    for _ in 0..20 {
        let miss = tri6::position(nodes, xi, eta) - point;
        let [a, b] = tri6::tangents(nodes, xi, eta);
        let slope = Matrix2::new(a.dot(u), b.dot(u), a.dot(v), b.dot(v));
        let step = slope.lu().solve(&Vector2::new(miss.dot(u), miss.dot(v)))?;
        xi -= step.x;
        eta -= step.y;
        if !(xi.abs() < 1e3 && eta.abs() < 1e3) {
            return None;
        }
        if step.norm() < 1e-13 {
            break;
        }
    }
    let inside =
        xi >= -EDGE_TOLERANCE && eta >= -EDGE_TOLERANCE && xi + eta <= 1.0 + EDGE_TOLERANCE;
    inside.then_some((xi, eta))
}

/// The point of the face nearest to `point`, as (ξ, η, distance): on the four flat triangles between
/// its nodes, then lifted to the curved face.
fn nearest_on_face(nodes: &[Point3<f64>; 6], point: &Point3<f64>) -> (f64, f64, f64) {
    [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
        .map(|corners| {
            let (s, t) = nearest_on_triangle(&corners.map(|i| nodes[i]), point);
            let parent = |c: usize| {
                let p = corners.map(|i| tri6::NODE_COORDINATES[i][c]);
                p[0] + s * (p[1] - p[0]) + t * (p[2] - p[0])
            };
            let (xi, eta) = (parent(0), parent(1));
            (xi, eta, (tri6::position(nodes, xi, eta) - point).norm())
        })
        .into_iter()
        .fold((0.0, 0.0, f64::INFINITY), |best, next| if next.2 < best.2 { next } else { best })
}

/// (s, t) of the nearest point a + s (b − a) + t (c − a) of a triangle
/// (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
pub(crate) fn nearest_on_triangle([a, b, c]: &[Point3<f64>; 3], p: &Point3<f64>) -> (f64, f64) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    let (aa, bb, mixed) = (ab.norm_squared(), ac.norm_squared(), ab.dot(&ac));
    let area = aa * bb - mixed * mixed;
    let (s, t) = ((d1 * bb - d2 * mixed) / area, (d2 * aa - d1 * mixed) / area);
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        return (s, t);
    }
    let along =
        |q: &Point3<f64>, e: Vector3<f64>| ((p - q).dot(&e) / e.norm_squared()).clamp(0.0, 1.0);
    let on_bc = along(b, c - b);
    [(along(a, ab), 0.0), (0.0, along(a, ac)), (1.0 - on_bc, on_bc)]
        .into_iter()
        .min_by(|x, y| {
            let distance = |(s, t): &(f64, f64)| (ap - ab * *s - ac * *t).norm_squared();
            distance(x).total_cmp(&distance(y))
        })
        .unwrap_or((0.0, 0.0))
}
