//! The nearest point of the skin.

use nalgebra::{Point3, Vector3};

use crate::basis::NODES;
use crate::error::{InverseError, check_finite};
use crate::skin::Skin;
use crate::skin_point::SkinPoint;
use crate::walk::AtWall;

/// Newton-like steps on a curved face.
const MAX_STEPS: usize = 20;

/// The four flat triangles between a curved face's nodes.
const PARTS: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

impl Skin {
    /// The point nearest to `target` (m) that a contact may be at, and its distance, m. On curved
    /// faces the nearest point of the flat triangles between the nodes is improved by steps along
    /// the surface.
    ///
    /// # Errors
    /// [`InverseError::NotFinite`]; [`InverseError::Length`] if every face is forbidden.
    pub fn nearest(&self, target: &Point3<f64>) -> Result<(SkinPoint, f64), InverseError> {
        check_finite("the target", target.coords.as_slice())?;
        let mut best: Option<(SkinPoint, f64)> = None;
        for face in (0..self.n_faces()).filter(|&face| !self.is_forbidden(face)) {
            let (point, distance_m) = self.nearest_on_face(face as u32, target);
            if best.is_none_or(|(_, least)| distance_m < least) {
                best = Some((point, distance_m));
            }
        }
        let (point, _) = best.ok_or(InverseError::Length {
            what: "the faces that are not forbidden",
            expected: 1,
            found: 0,
        })?;
        let point = if self.is_quadratic() { self.drop_foot(point, target) } else { point };
        Ok((point, (self.position(&point) - target).norm()))
    }

    fn nearest_on_face(&self, face: u32, target: &Point3<f64>) -> (SkinPoint, f64) {
        let nodes = self.face(face);
        let at = |i: usize| self.nodes()[nodes[i] as usize];
        let parts: &[[usize; 3]] = if self.is_quadratic() { &PARTS } else { &[[0, 1, 2]] };
        let mut best = (SkinPoint::trusted(face, NODES[0]), f64::INFINITY);
        for part in parts {
            let inner = nearest_on_triangle(&part.map(at), target);
            let foot: Vector3<f64> = (0..3).map(|i| at(part[i]).coords * inner[i]).sum();
            let distance_m = (foot - target.coords).norm();
            if distance_m < best.1 {
                let bary =
                    std::array::from_fn(|c| (0..3).map(|i| NODES[part[i]][c] * inner[i]).sum());
                best = (SkinPoint::trusted(face, bary), distance_m);
            }
        }
        best
    }

    fn drop_foot(&self, start: SkinPoint, target: &Point3<f64>) -> SkinPoint {
        let mut point = start;
        let mut least = (self.position(&point) - target).norm();
        for _ in 0..MAX_STEPS {
            let step = target - self.position(&point);
            let next = self.walk(&point, &step, AtWall::Slide).point;
            let distance_m = (self.position(&next) - target).norm();
            if distance_m >= least {
                break;
            }
            (point, least) = (next, distance_m);
        }
        point
    }
}

/// Barycentric coordinates of the nearest point of a triangle (Ericson, Real-Time Collision
/// Detection, 2005, section 5.1.5).
fn nearest_on_triangle(corners: &[Point3<f64>; 3], target: &Point3<f64>) -> [f64; 3] {
    let [a, b, c] = *corners;
    let (ab, ac, ap) = (b - a, c - a, target - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = target - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = target - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}
