//! Six-node faces cut into four, for maps that vary more than the faces' nodes can represent.

use std::collections::BTreeMap;

use crate::basis;
use crate::skin::Skin;
use crate::skin_point::SkinPoint;

/// Parts of a face: one at each corner, and the middle.
pub(crate) const N_PARTS: usize = 4;

/// Barycentric coordinates, in quarters, of a face's 15 points: its six nodes, then two on each edge,
/// the one near the edge's first corner first, then one between the midpoints of the edges at each
/// corner.
const POINTS: [[u8; 3]; 15] = [
    [4, 0, 0],
    [0, 4, 0],
    [0, 0, 4],
    [2, 2, 0],
    [0, 2, 2],
    [2, 0, 2],
    [3, 1, 0],
    [1, 3, 0],
    [0, 3, 1],
    [0, 1, 3],
    [1, 0, 3],
    [3, 0, 1],
    [2, 1, 1],
    [1, 2, 1],
    [1, 1, 2],
];

/// The six points of each part, in the order of a face's nodes.
const PARTS: [[usize; 6]; N_PARTS] =
    [[0, 3, 5, 6, 12, 11], [1, 4, 3, 8, 13, 7], [2, 5, 4, 10, 14, 9], [3, 4, 5, 13, 14, 12]];

/// The points at which a map on the subdivided faces of a skin has its values, the skin's nodes first.
pub(crate) struct SubdividedFaces {
    pub(crate) points: Vec<SkinPoint>,
    /// Points of each part `[n_faces × N_PARTS]`.
    pub(crate) rows_of_part: Vec<[u32; 6]>,
}

impl SubdividedFaces {
    pub(crate) fn new(skin: &Skin) -> Self {
        let mut points = vec![SkinPoint::trusted(0, [1.0, 0.0, 0.0]); skin.n_nodes()];
        let mut on_edges = BTreeMap::new();
        let mut rows_of_part = Vec::with_capacity(N_PARTS * skin.n_faces());
        for face in 0..skin.n_faces() {
            let nodes = skin.face(face as u32);
            let at = |i: usize| {
                SkinPoint::trusted(
                    face as u32,
                    POINTS[i].map(|quarters| 0.25 * f64::from(quarters)),
                )
            };
            let mut rows = [0; POINTS.len()];
            for (i, row) in rows.iter_mut().enumerate() {
                *row = match i {
                    0..6 => {
                        points[nodes[i] as usize] = at(i);
                        nodes[i]
                    }
                    6..12 => {
                        let (edge, end) = ((i - 6) / 2, (i - 6) % 2);
                        let ends = (nodes[3 + edge], nodes[(edge + end) % 3]);
                        *on_edges.entry(ends).or_insert_with(|| added(&mut points, at(i)))
                    }
                    _ => added(&mut points, at(i)),
                };
            }
            rows_of_part.extend(PARTS.map(|part| part.map(|i| rows[i])));
        }
        Self { points, rows_of_part }
    }
}

impl Skin {
    /// The points at which a map on subdivided faces has its values: the nodes, then on each
    /// edge a quarter from either end, and three within each face.
    ///
    /// None on a skin of three-node faces.
    #[must_use]
    pub fn subdivided_points(&self) -> Vec<SkinPoint> {
        if !self.is_quadratic() {
            return Vec::new();
        }
        SubdividedFaces::new(self).points
    }
}

fn added(points: &mut Vec<SkinPoint>, point: SkinPoint) -> u32 {
    points.push(point);
    points.len() as u32 - 1
}

/// The part that `bary` lies in, and its coordinates there.
pub(crate) fn part_of(bary: &[f64; 3]) -> (usize, [f64; 3]) {
    let corner = (0..3).find(|&i| bary[i] >= 0.5);
    match corner {
        Some(i) => {
            let (a, b) = (2.0 * bary[(i + 1) % 3], 2.0 * bary[(i + 2) % 3]);
            (i, [1.0 - a - b, a, b])
        }
        None => {
            let [a, b, c] = bary.map(|b| 1.0 - 2.0 * b);
            (3, [c, a, b])
        }
    }
}

/// Slopes (∂/∂ξ, ∂/∂η) of the face's six shape functions of the part at `bary`.
pub(crate) fn gradient(bary: &[f64; 3]) -> [[f64; 6]; 2] {
    let (part, inner) = part_of(bary);
    let by_inner = basis::quadratic_gradient(&inner);
    // ∂(l₁, l₂)/∂(b₀, b₁, b₂), where (ξ, η) = (b₁, b₂) and b₀ = 1 − ξ − η
    let by_bary = match part {
        3 => [[-2.0, 0.0, 0.0], [0.0, -2.0, 0.0]],
        i => [unit(2.0, (i + 1) % 3), unit(2.0, (i + 2) % 3)],
    };
    let along = |k: usize| {
        let by_parent = by_bary.map(|row| row[k] - row[0]);
        std::array::from_fn(|i| by_parent[0] * by_inner[0][i] + by_parent[1] * by_inner[1][i])
    };
    [along(1), along(2)]
}

fn unit(size: f64, at: usize) -> [f64; 3] {
    std::array::from_fn(|i| if i == at { size } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const INSIDE: [[f64; 3]; 4] =
        [[0.62, 0.21, 0.17], [0.11, 0.71, 0.18], [0.24, 0.13, 0.63], [0.31, 0.42, 0.27]];

    #[test]
    fn a_parts_coordinates_lead_to_the_point() {
        for (part, bary) in INSIDE.iter().enumerate() {
            let (found, inner) = part_of(bary);
            assert_eq!(found, part);
            let corners = [0, 1, 2].map(|i| POINTS[PARTS[part][i]].map(|q| 0.25 * f64::from(q)));
            for k in 0..3 {
                let sum: f64 = (0..3).map(|i| inner[i] * corners[i][k]).sum();
                assert!((sum - bary[k]).abs() < 1e-15, "{part}: {sum} {}", bary[k]);
            }
        }
    }

    #[test]
    fn nodes_of_a_part_between_its_corners_are_halfway() {
        for part in PARTS {
            for edge in 0..3 {
                let ends = [part[edge], part[(edge + 1) % 3]].map(|i| POINTS[i]);
                let halfway: [u8; 3] = std::array::from_fn(|k| (ends[0][k] + ends[1][k]) / 2);
                assert_eq!(POINTS[part[3 + edge]], halfway);
            }
        }
    }

    #[test]
    fn slopes_are_central_differences() {
        let h = 1e-6;
        for bary in INSIDE {
            let found = gradient(&bary);
            for (axis, slopes) in found.iter().enumerate() {
                let moved = |by: f64| {
                    let mut b = bary;
                    b[0] -= by;
                    b[1 + axis] += by;
                    basis::quadratic(&part_of(&b).1)
                };
                let (up, down) = (moved(h), moved(-h));
                for i in 0..6 {
                    let expected = (up[i] - down[i]) / (2.0 * h);
                    assert!((slopes[i] - expected).abs() < 1e-8, "{} {expected}", slopes[i]);
                }
            }
        }
    }
}
