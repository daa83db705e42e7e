//! Gauge patches: the FE nodes around a gauge on the wall it is glued to.

use nalgebra::{Point3, Vector3};

use crate::skin::regions::face_positions;
use crate::solid::boundary::connected_faces;
use crate::{FeNodeId, MeshError, Tet10Mesh, Tri6Face, tri6};

/// A face belongs to the gauge's wall only if its normal is within 60° of the normal where the
/// gauge sits, so that a patch can't run over a rim to the other side of the wall.
const MIN_NORMAL_AGREEMENT: f64 = 0.5;

/// The FE nodes that stand for one gauge.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugePatch {
    /// The nodes by ascending distance from the gauge centre, ties by id.
    pub nodes: Vec<FeNodeId>,
    /// Distance from the gauge centre to the wall, m.
    pub distance_to_wall_m: f64,
    /// The wall's outward unit normal, taken at the middle of the face nearest to the centre.
    pub normal: Vector3<f64>,
}

/// The `n` FE nodes nearest to `centre` on the wall that a gauge there is glued to.
///
/// The wall is what can be reached from the face nearest to `centre` over faces of `wall_faces`
/// that share an edge and whose normal agrees with the normal there: the two sides of a thin wall
/// don't mix, even if `wall_faces` is the whole boundary.
///
/// # Errors
/// [`MeshError::GaugeOffWall`] if `centre` is not finite or farther than `max_distance_m` from every
/// face; [`MeshError::GaugePatchTooSmall`] if the wall has fewer than `n` nodes.
pub fn gauge_patch(
    mesh: &Tet10Mesh,
    wall_faces: &[Tri6Face],
    centre: &Point3<f64>,
    n: usize,
    max_distance_m: f64,
) -> Result<GaugePatch, MeshError> {
    let (start, distance_to_wall_m) = nearest_face(mesh, wall_faces, centre);
    let on_wall = distance_to_wall_m <= max_distance_m;
    let (Some(start), true) = (start, on_wall) else {
        return Err(MeshError::GaugeOffWall {
            centre_m: centre.coords.into(),
            distance_m: distance_to_wall_m,
            max_distance_m,
        });
    };
    let normals: Vec<Option<Vector3<f64>>> =
        wall_faces.iter().map(|face| centroid_normal(mesh, face)).collect();
    let normal = normals[start].unwrap_or_else(Vector3::zeros);
    let agrees =
        |face: usize| normals[face].is_some_and(|other| other.dot(&normal) > MIN_NORMAL_AGREEMENT);
    let reached = connected_faces(wall_faces, start, agrees);
    let on_wall = wall_faces.iter().zip(reached).filter(|(_, reached)| *reached);
    let wall: Vec<Tri6Face> = on_wall.map(|(face, _)| *face).collect();
    let nodes = nearest_nodes(mesh, &wall, centre, n);
    if nodes.len() < n {
        return Err(MeshError::GaugePatchTooSmall {
            centre_m: centre.coords.into(),
            expected: n,
            found: nodes.len(),
        });
    }
    Ok(GaugePatch { nodes, distance_to_wall_m, normal })
}

/// The face nearest to `point` and its distance; ties go to the first.
fn nearest_face(mesh: &Tet10Mesh, faces: &[Tri6Face], point: &Point3<f64>) -> (Option<usize>, f64) {
    let mut best = (None, f64::INFINITY);
    for (i, face) in faces.iter().enumerate() {
        let distance = distance_to_face(&face_positions(mesh, face), point);
        if distance < best.1 {
            best = (Some(i), distance);
        }
    }
    best
}

/// Distance to the four flat triangles between a face's six nodes, m.
fn distance_to_face(nodes: &[Point3<f64>; 6], point: &Point3<f64>) -> f64 {
    [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
        .map(|t| distance_to_triangle(&t.map(|i| nodes[i]), point))
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}

/// Distance from `p` to a triangle (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
fn distance_to_triangle([a, b, c]: &[Point3<f64>; 3], p: &Point3<f64>) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(&ac);
    let area_2 = normal.norm_squared();
    let v = normal.dot(&ap.cross(&ac)) / area_2;
    let w = normal.dot(&ab.cross(&ap)) / area_2;
    if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        return (normal.dot(&ap) / area_2.sqrt()).abs();
    }
    [(a, b), (b, c), (c, a)]
        .map(|(a, b)| distance_to_segment(a, b, p))
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}

fn distance_to_segment(a: &Point3<f64>, b: &Point3<f64>, p: &Point3<f64>) -> f64 {
    let ab = b - a;
    let length_2 = ab.norm_squared();
    let t = if length_2 > 0.0 { ((p - a).dot(&ab) / length_2).clamp(0.0, 1.0) } else { 0.0 };
    (p - (a + ab * t)).norm()
}

fn centroid_normal(mesh: &Tet10Mesh, face: &Tri6Face) -> Option<Vector3<f64>> {
    tri6::area_vector(&face_positions(mesh, face), 1.0 / 3.0, 1.0 / 3.0).try_normalize(0.0)
}

fn nearest_nodes(
    mesh: &Tet10Mesh,
    faces: &[Tri6Face],
    centre: &Point3<f64>,
    n: usize,
) -> Vec<FeNodeId> {
    let mut nodes: Vec<(f64, FeNodeId)> = crate::solid::boundary::nodes_of(faces)
        .into_iter()
        .map(|node| ((mesh.position(node) - centre).norm_squared(), node))
        .collect();
    nodes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    nodes.truncate(n);
    nodes.into_iter().map(|(_, node)| node).collect()
}
