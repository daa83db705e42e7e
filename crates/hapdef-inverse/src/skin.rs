//! The touchable surface: faces, normals, who neighbours whom.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::basis::{self, NODES};
use crate::error::{InverseError, check_finite, check_length};

/// The faces of a skin, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug)]
pub enum SkinFaces<'a> {
    /// Flat faces of three nodes.
    Linear(&'a [[u32; 3]]),
    /// Curved faces of six: corners 0, 1, 2, then the mid-side nodes of 0–1, 1–2, 2–0.
    Quadratic(&'a [[u32; 6]]),
}

/// How a skin's edges are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinParams {
    /// Two faces whose normals differ by more than this at their common edge form a fold, which no
    /// walk crosses, rad.
    pub max_fold_rad: f64,
}

impl Default for SkinParams {
    /// 45°: a coarse mesh of a round limb turns by up to 30° at an edge, a rim or rib by 90°.
    fn default() -> Self {
        Self { max_fold_rad: std::f64::consts::FRAC_PI_4 }
    }
}

/// A triangulated surface on which contacts sit and move.
#[derive(Clone, Debug)]
pub struct Skin {
    nodes: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    faces: Vec<[u32; 6]>,
    is_quadratic: bool,
    sides: Vec<[Side; 3]>,
    forbidden: Vec<bool>,
    area_m2: f64,
}

/// What lies beyond an edge; edge e of a face runs from its corner e to corner e + 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Side {
    Across { face: u32, edge: u8 },
    Rim,
    Fold,
}

impl Skin {
    /// A skin of `nodes` (m) and `faces`; `normals` are the outward directions at the nodes
    /// `[n_nodes]`, of any length, or `None` for the mean of the faces' area vectors at each node.
    ///
    /// # Errors
    /// [`InverseError`] naming the face or node that can't be used.
    pub fn new(
        nodes: Vec<Point3<f64>>,
        faces: SkinFaces<'_>,
        normals: Option<&[Vector3<f64>]>,
        params: &SkinParams,
    ) -> Result<Self, InverseError> {
        let (faces, is_quadratic) = match faces {
            SkinFaces::Linear(list) => {
                (list.iter().map(|&[a, b, c]| [a, b, c, a, b, c]).collect(), false)
            }
            SkinFaces::Quadratic(list) => (list.to_vec(), true),
        };
        let n_faces = faces.len();
        let mut skin = Self {
            normals: vec![Vector3::zeros(); nodes.len()],
            nodes,
            faces,
            is_quadratic,
            sides: vec![[Side::Rim; 3]; n_faces],
            forbidden: vec![false; n_faces],
            area_m2: 0.0,
        };
        skin.check(params)?;
        skin.area_m2 = (0..n_faces).map(|face| skin.face_area_m2(face)).sum();
        skin.join_faces(params)?;
        skin.set_normals(normals)?;
        Ok(skin)
    }

    /// The same skin with faces that no contact may enter.
    ///
    /// # Errors
    /// [`InverseError::FaceOutOfRange`].
    pub fn forbid(mut self, faces: &[usize]) -> Result<Self, InverseError> {
        for &face in faces {
            let n_faces = self.n_faces();
            *self
                .forbidden
                .get_mut(face)
                .ok_or(InverseError::FaceOutOfRange { face, n_faces })? = true;
        }
        Ok(self)
    }

    /// Number of nodes.
    #[must_use]
    pub fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Number of faces.
    #[must_use]
    pub fn n_faces(&self) -> usize {
        self.faces.len()
    }

    /// Positions of the nodes `[n_nodes]`, m.
    #[must_use]
    pub fn nodes(&self) -> &[Point3<f64>] {
        &self.nodes
    }

    /// Outward unit normals at the nodes `[n_nodes]`.
    #[must_use]
    pub fn normals(&self) -> &[Vector3<f64>] {
        &self.normals
    }

    /// Whether the faces have mid-side nodes.
    #[must_use]
    pub fn is_quadratic(&self) -> bool {
        self.is_quadratic
    }

    /// Whether no contact may enter `face`.
    ///
    /// # Panics
    /// If the skin has no such face.
    #[must_use]
    pub fn is_forbidden(&self, face: usize) -> bool {
        self.forbidden[face]
    }

    /// Area, m².
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        self.area_m2
    }

    /// The nodes of `face`: three or six.
    ///
    /// # Panics
    /// If the skin has no such face.
    #[must_use]
    pub fn face_nodes(&self, face: usize) -> &[u32] {
        &self.faces[face][..if self.is_quadratic { 6 } else { 3 }]
    }

    pub(crate) fn face(&self, face: u32) -> &[u32; 6] {
        &self.faces[face as usize]
    }

    /// What lies beyond `edge`, forbidden faces seen as walls.
    pub(crate) fn side(&self, face: u32, edge: usize) -> Side {
        self.sides[face as usize][edge]
    }

    /// Area by the three edge midpoints, exact for flat faces.
    fn face_area_m2(&self, face: usize) -> f64 {
        let at = |b: &[f64; 3]| self.area_vector(face as u32, b).norm();
        NODES[3..].iter().map(at).sum::<f64>() / 6.0
    }

    /// ∂x/∂ξ × ∂x/∂η, m².
    pub(crate) fn area_vector(&self, face: u32, bary: &[f64; 3]) -> Vector3<f64> {
        let [a, b] = self.by_parent(face, bary);
        a.cross(&b)
    }

    /// ∂x/∂ξ, ∂x/∂η, m.
    pub(crate) fn by_parent(&self, face: u32, bary: &[f64; 3]) -> [Vector3<f64>; 2] {
        let nodes = self.face(face);
        let at = |i: usize| self.nodes()[nodes[i] as usize].coords;
        if !self.is_quadratic() {
            let origin = at(0);
            return [at(1) - origin, at(2) - origin];
        }
        let weights = basis::quadratic_gradient(bary);
        let mut sums = [Vector3::zeros(); 2];
        for i in 0..6 {
            let x = at(i);
            sums[0] += x * weights[0][i];
            sums[1] += x * weights[1][i];
        }
        sums
    }

    fn check(&self, params: &SkinParams) -> Result<(), InverseError> {
        let fold = params.max_fold_rad;
        if !(fold > 0.0 && fold <= std::f64::consts::PI) {
            return Err(InverseError::Parameter {
                what: "max_fold_rad",
                found: fold,
                expected: "above 0 and at most π",
            });
        }
        if self.faces.is_empty() {
            return Err(InverseError::Length { what: "the skin's faces", expected: 1, found: 0 });
        }
        for node in &self.nodes {
            check_finite("the skin's node positions", node.coords.as_slice())?;
        }
        let n_nodes = self.n_nodes();
        for (face, nodes) in self.faces.iter().enumerate() {
            if let Some(&node) = nodes.iter().find(|&&node| node as usize >= n_nodes) {
                let node = node as usize;
                return Err(InverseError::NodeOutOfRange { face, node, n_nodes });
            }
            let at = |i: usize| self.nodes[nodes[i] as usize];
            let flat = (at(1) - at(0)).cross(&(at(2) - at(0)));
            let middle = self.area_vector(face as u32, &[1.0 / 3.0; 3]);
            // towards a corner a curved face may bend far, as at the edge of a drilled hole
            if middle.dot(&flat).is_nan() || middle.dot(&flat) <= 0.0 {
                return Err(InverseError::BadFace { face });
            }
        }
        Ok(())
    }

    fn set_normals(&mut self, given: Option<&[Vector3<f64>]>) -> Result<(), InverseError> {
        let sums = match given {
            Some(given) => {
                check_length("the skin's normals", self.n_nodes(), given.len())?;
                given.to_vec()
            }
            None => self.summed_area_vectors(),
        };
        let mut used = vec![false; self.n_nodes()];
        for node in self.faces.iter().flatten() {
            used[*node as usize] = true;
        }
        for (node, sum) in sums.into_iter().enumerate() {
            let unit = sum
                .try_normalize(0.0)
                .filter(|unit| used[node] && unit.iter().all(|c| c.is_finite()));
            self.normals[node] = unit.ok_or(InverseError::NoNormal { node })?;
        }
        Ok(())
    }

    fn summed_area_vectors(&self) -> Vec<Vector3<f64>> {
        let mut sums = vec![Vector3::zeros(); self.n_nodes()];
        for face in 0..self.n_faces() {
            for (&node, b) in self.face_nodes(face).iter().zip(&NODES) {
                sums[node as usize] += self.area_vector(face as u32, b);
            }
        }
        sums
    }

    fn join_faces(&mut self, params: &SkinParams) -> Result<(), InverseError> {
        let mut seen: BTreeMap<(u32, u32), (usize, usize)> = BTreeMap::new();
        for face in 0..self.n_faces() {
            for edge in 0..3 {
                let (a, b) = self.edge_nodes(face, edge);
                if let Some(&(other, _)) = seen.get(&(a, b)) {
                    let (first, second) = (other, face);
                    return Err(InverseError::BadEdge { first, second });
                }
                seen.insert((a, b), (face, edge));
                let Some(&(other, its_edge)) = seen.get(&(b, a)) else {
                    continue;
                };
                if self.faces[face][3 + edge] != self.faces[other][3 + its_edge]
                    && self.is_quadratic
                {
                    let (first, second) = (other, face);
                    return Err(InverseError::BadEdge { first, second });
                }
                let is_fold = self.turn_rad(face, edge, other, its_edge) > params.max_fold_rad;
                let side = |face: usize, edge: usize| {
                    if is_fold {
                        return Side::Fold;
                    }
                    let (face, edge) = (face as u32, edge as u8);
                    Side::Across { face, edge }
                };
                self.sides[face][edge] = side(other, its_edge);
                self.sides[other][its_edge] = side(face, edge);
            }
        }
        Ok(())
    }

    fn edge_nodes(&self, face: usize, edge: usize) -> (u32, u32) {
        (self.faces[face][edge], self.faces[face][(edge + 1) % 3])
    }

    /// Angle between the normals of two faces at the middle of their common edge.
    fn turn_rad(&self, face: usize, edge: usize, other: usize, its_edge: usize) -> f64 {
        let a = self.area_vector(face as u32, &NODES[3 + edge]);
        let b = self.area_vector(other as u32, &NODES[3 + its_edge]);
        a.angle(&b)
    }
}

/// A plate of `n` by `n` cells of `cell_m`, in two faces each.
#[cfg(test)]
pub(crate) fn plate(n: u32, cell_m: f64) -> Skin {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let node = |k: u32| Point3::new(f64::from(k / (n + 1)), f64::from(k % (n + 1)), 0.0) * cell_m;
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let halves = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    let (nodes, faces) = ((0..(n + 1).pow(2)).map(node).collect(), halves.collect::<Vec<_>>());
    Skin::new(nodes, SkinFaces::Linear(&faces), None, &SkinParams::default()).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<Point3<f64>> {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| Point3::new(x, y, 0.0))
            .to_vec()
    }

    #[track_caller]
    fn refused(faces: &[[u32; 3]], expected: &InverseError) {
        let faces = SkinFaces::Linear(faces);
        let found = Skin::new(square(), faces, None, &SkinParams::default());
        assert_eq!(found.map(|_| ()), Err(expected.clone()));
    }

    #[test]
    fn a_square_has_its_area_and_normals() {
        let faces = SkinFaces::Linear(&[[0, 1, 2], [0, 2, 3]]);
        let skin = Skin::new(square(), faces, None, &SkinParams::default()).unwrap();
        assert!((skin.area_m2() - 1.0).abs() < 1e-15);
        assert!(skin.normals().iter().all(|n| (n.z - 1.0).abs() < 1e-15));
        assert_eq!(skin.side(0, 2), Side::Across { face: 1, edge: 0 });
        assert_eq!(skin.side(0, 0), Side::Rim);
    }

    #[test]
    fn bad_faces_are_named() {
        let (first, second) = (0, 1);
        refused(&[[0, 1, 2], [0, 3, 2]], &InverseError::BadEdge { first, second });
        refused(&[[0, 1, 1]], &InverseError::BadFace { face: 0 });
        refused(&[[0, 1, 2]], &InverseError::NoNormal { node: 3 });
        let (face, node, n_nodes) = (0, 9, 4);
        refused(&[[0, 1, 9]], &InverseError::NodeOutOfRange { face, node, n_nodes });
    }
}
