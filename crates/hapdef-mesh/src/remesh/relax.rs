//! Tangential smoothing, and the way back to the surface and its creases.

use nalgebra::{Point3, Vector3};

use super::sweep::Ring;
use super::work::{Kind, Work, normal};
use crate::SurfaceMesh;
use crate::surface::closest::ClosestPoint;

/// A vertex goes back to triangles whose normal is within 60° of its own, so that it can't land on
/// the other side of a thin wall; a crease vertex to edges within 45° of its crease.
const MIN_NORMAL_COS: f64 = 0.5;
const MIN_CREASE_COS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The given surface and its creases, to go back to.
pub(super) struct Origin {
    surface: ClosestPoint,
    creases: ClosestPoint,
}

impl Origin {
    pub fn new(mesh: &SurfaceMesh, work: &Work) -> Self {
        let ends = work.creases.iter().map(|edge| edge.map(|v| work.at(v)));
        Self { surface: ClosestPoint::of_surface(mesh), creases: ClosestPoint::of_edges(ends) }
    }

    fn on_surface(&self, place: &Point3<f64>, normal: &Vector3<f64>) -> Option<Point3<f64>> {
        let agrees = |other: &Vector3<f64>| other.dot(normal) >= MIN_NORMAL_COS;
        Some(self.surface.nearest_that(place, agrees)?.point)
    }

    fn on_crease(&self, place: &Point3<f64>, along: &Vector3<f64>) -> Option<Point3<f64>> {
        let agrees = |other: &Vector3<f64>| other.dot(along).abs() >= MIN_CREASE_COS;
        Some(self.creases.nearest_that(place, agrees)?.point)
    }
}

/// Moves every vertex towards the middle of its faces, within the surface or along its crease, and
/// back to the given surface; by half or a quarter of the way, or not at all, where a face would
/// turn over or lose its shape.
pub(super) fn relax(work: &mut Work, origin: &Origin) {
    for vertex in 0..work.points.len() as u32 {
        if work.around[vertex as usize].is_empty() {
            continue;
        }
        let found = [1.0, 0.5, 0.25, 0.0].into_iter().find_map(|share| {
            let place = moved(work, origin, vertex, share)?;
            is_allowed(work, vertex, place).then_some(place)
        });
        if let Some(place) = found {
            work.points[vertex as usize] = place;
        }
    }
}

fn moved(work: &Work, origin: &Origin, vertex: u32, share: f64) -> Option<Point3<f64>> {
    let here = work.at(vertex);
    match work.kinds[vertex as usize] {
        Kind::Corner => None,
        Kind::Crease => {
            let [a, b] = work.crease_neighbours(vertex)[..] else {
                return None;
            };
            let (a, b) = (work.at(a), work.at(b));
            let along = (b - a).try_normalize(0.0)?;
            let step = along * along.dot(&(nalgebra::center(&a, &b) - here));
            origin.on_crease(&(here + step * share), &along)
        }
        Kind::Free => {
            let (centre, normal) = centre_and_normal(work, vertex)?;
            let way = centre - here;
            let step = way - normal * normal.dot(&way);
            origin.on_surface(&(here + step * share), &normal)
        }
    }
}

/// The centroid of the faces around a vertex, and their mean normal, both weighted by area.
fn centre_and_normal(work: &Work, vertex: u32) -> Option<(Point3<f64>, Vector3<f64>)> {
    let (mut sum, mut total, mut direction) = (Vector3::zeros(), 0.0, Vector3::zeros());
    for &face in &work.around[vertex as usize] {
        let corners = work.corners(face);
        let n = normal(&corners);
        let third = (corners[0].coords + corners[1].coords + corners[2].coords) / 3.0;
        sum += third * n.norm();
        total += n.norm();
        direction += n;
    }
    Some((Point3::from(sum / total), direction.try_normalize(0.0)?))
}

fn is_allowed(work: &Work, vertex: u32, place: Point3<f64>) -> bool {
    let faces = &work.around[vertex as usize];
    let all: Vec<[Point3<f64>; 3]> = faces.iter().map(|face| work.corners(*face)).collect();
    let ring = Ring::of(&all);
    let mut moved = faces.iter().map(|face| work.corners_with(*face, vertex, place));
    all.iter().all(|old| moved.next().is_some_and(|new| ring.allows(old, &new)))
}
