//! Where a triangle surface goes through itself.

mod pair;

use rstar::{AABB, RTree, RTreeObject};

use super::crossing::{Crossing, MOST_CROSSINGS};
use crate::surface::topology::repeats;
use crate::{SurfaceFault, SurfaceMesh};
use pair::{Overlap, overlap};

/// Triangles that share less than this part of the surface's longest extent only touch: a few
/// roundings of 32-bit coordinates.
const LEAST_LENGTH: f64 = 1e-6;

/// All pairs of triangles of `mesh` that cross, by the numbers of their triangles; of a tangle the
/// first million.
///
/// Pairs that share a vertex are neighbours and left out, so weld first ([`SurfaceMesh::weld`]).
/// Pairs that only touch are left out, too: they meet in a point, along an edge of one, or over
/// less than a millionth of the surface's longest extent; so are triangles without area.
/// Candidates are those whose boxes meet; they are told apart by signs of determinants that are
/// exact (Shewchuk, Discrete & Computational Geometry 18, 1997).
#[must_use]
pub fn self_intersections(mesh: &SurfaceMesh) -> Vec<Crossing> {
    let least_m = LEAST_LENGTH * mesh.bounding_box().longest_m();
    let boxed = |triangle| Boxed::new(mesh, triangle);
    let boxes: Vec<Boxed> = (0..mesh.triangles().len()).map(boxed).collect();
    let tree = RTree::bulk_load(boxes.clone());
    let mut crossings = Vec::new();
    let mut partners = Vec::new();
    for one in &boxes {
        if crossings.len() >= MOST_CROSSINGS {
            break;
        }
        let near = tree.locate_in_envelope_intersecting(one.envelope);
        let later = near.map(|other| other.triangle as usize);
        partners.clear();
        partners.extend(later.filter(|&other| is_partner(mesh, one.triangle as usize, other)));
        partners.sort_unstable();
        crossings.extend(partners.iter().filter_map(|&other| {
            let triangles = [one.triangle as usize, other];
            let Overlap { place, length_m } = overlap(triangles.map(|t| mesh.corners(t)))?;
            (length_m >= least_m).then_some(Crossing { triangles, place, length_m })
        }));
    }
    crossings.truncate(MOST_CROSSINGS);
    crossings
}

/// Refuses a surface that goes through itself.
pub(crate) fn check_uncrossed(
    mesh: &SurfaceMesh,
    what: &'static str,
    advice: &'static str,
) -> Result<(), SurfaceFault> {
    let crossings = self_intersections(mesh);
    if crossings.is_empty() {
        return Ok(());
    }
    Err(SurfaceFault::Crosses { what, crossings, advice })
}

/// Whether `other` is to be tried with `one`: it comes later, shares no vertex, names none twice.
fn is_partner(mesh: &SurfaceMesh, one: usize, other: usize) -> bool {
    let [a, b] = [one, other].map(|t| &mesh.triangles()[t]);
    other > one && !repeats(a) && !repeats(b) && !a.iter().any(|v| b.contains(v))
}

/// A triangle's box.
#[derive(Clone, Debug)]
struct Boxed {
    triangle: u32,
    envelope: AABB<[f64; 3]>,
}

impl Boxed {
    fn new(mesh: &SurfaceMesh, triangle: usize) -> Self {
        let corners = mesh.corners(triangle).map(|p| p.coords.into());
        Self { triangle: triangle as u32, envelope: AABB::from_points(corners.iter()) }
    }
}

impl RTreeObject for Boxed {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        self.envelope
    }
}

#[cfg(test)]
mod tests;
