//! A point of the skin: its place, normal and tangents.

use nalgebra::{Point3, Vector3};

use crate::basis;
use crate::error::InverseError;
use crate::skin::{Side, Skin};

/// How far barycentric coordinates may miss the face when a point is made.
const SLACK: f64 = 1e-9;

/// A face and barycentric coordinates on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinPoint {
    face: u32,
    bary: [f64; 3],
}

impl SkinPoint {
    /// The point of `skin` on `face` with coordinates `bary`, which sum to 1.
    ///
    /// # Errors
    /// [`InverseError::FaceOutOfRange`], [`InverseError::PointOffSkin`].
    pub fn new(skin: &Skin, face: usize, bary: [f64; 3]) -> Result<Self, InverseError> {
        let n_faces = skin.n_faces();
        if face >= n_faces {
            return Err(InverseError::FaceOutOfRange { face, n_faces });
        }
        let sum: f64 = bary.iter().sum();
        let is_inside = bary.iter().all(|&b| b >= -SLACK) && (sum - 1.0).abs() <= SLACK;
        if !is_inside {
            let coordinates = bary;
            return Err(InverseError::PointOffSkin { face, coordinates });
        }
        let inside = bary.map(|b| b.max(0.0));
        let sum: f64 = inside.iter().sum();
        Ok(Self::trusted(face as u32, inside.map(|b| b / sum)))
    }

    /// The point of `skin` on `face` that two numbers of [0, 1] stand for; uniform over the face where
    /// they are drawn uniformly.
    ///
    /// # Errors
    /// [`InverseError::FaceOutOfRange`], [`InverseError::PointOffSkin`].
    pub fn drawn(skin: &Skin, face: usize, [a, b]: [f64; 2]) -> Result<Self, InverseError> {
        let [a, b] = if a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] };
        Self::new(skin, face, [1.0 - a - b, a, b])
    }

    /// Index of the face.
    #[must_use]
    pub fn face(&self) -> usize {
        self.face as usize
    }

    /// Barycentric coordinates on the face; they sum to 1.
    #[must_use]
    pub fn bary(&self) -> [f64; 3] {
        self.bary
    }

    pub(crate) const fn trusted(face: u32, bary: [f64; 3]) -> Self {
        Self { face, bary }
    }

    pub(crate) fn face_id(&self) -> u32 {
        self.face
    }

    /// The corner with the largest coordinate.
    pub(crate) fn nearest_corner(&self) -> usize {
        let [a, b, c] = self.bary;
        if a >= b && a >= c {
            0
        } else if b >= c {
            1
        } else {
            2
        }
    }
}

/// Where a point is and how a step along its tangents moves it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// ∂x/∂ξ, ∂x/∂η, m.
    pub(crate) by_parent: [Vector3<f64>; 2],
    /// Two unit tangents, at right angles; t₁ × t₂ points outwards.
    pub(crate) tangents: [Vector3<f64>; 2],
    /// `[t]`: (dξ, dη) of a step of one metre along tangent t.
    pub(crate) parent_by_step: [[f64; 2]; 2],
}

impl Frame {
    fn new(by_parent: [Vector3<f64>; 2]) -> Self {
        let [a, b] = by_parent;
        let length = a.norm().max(f64::MIN_POSITIVE);
        let along = a / length;
        let shear = b.dot(&along);
        let across = b - along * shear;
        let height = across.norm().max(f64::MIN_POSITIVE);
        Self {
            by_parent,
            tangents: [along, across / height],
            parent_by_step: [[1.0 / length, 0.0], [-shear / (length * height), 1.0 / height]],
        }
    }

    /// (dξ, dη) of the tangential part of `step`.
    pub(crate) fn parent_step(&self, step: &Vector3<f64>) -> [f64; 2] {
        let s = self.tangents.map(|t| t.dot(step));
        std::array::from_fn(|c| s[0] * self.parent_by_step[0][c] + s[1] * self.parent_by_step[1][c])
    }

    /// ∂x along edge `edge` of the face, from its corner `edge` on, unit length.
    pub(crate) fn edge_direction(&self, edge: usize) -> Vector3<f64> {
        let [a, b] = self.by_parent;
        let d = [a, b - a, -b][edge];
        d / d.norm().max(f64::MIN_POSITIVE)
    }

    /// The unit tangent at right angles to edge `edge` that points into the face.
    pub(crate) fn inward(&self, edge: usize) -> Vector3<f64> {
        let [a, b] = self.by_parent;
        let along = self.edge_direction(edge);
        let to_corner = [b, -(a + b), a][edge];
        let across = to_corner - along * along.dot(&to_corner);
        across / across.norm().max(f64::MIN_POSITIVE)
    }
}

impl Skin {
    /// Position of `point`, m.
    ///
    /// # Panics
    /// If `point` is of another, larger skin.
    #[must_use]
    pub fn position(&self, point: &SkinPoint) -> Point3<f64> {
        let nodes = self.face(point.face);
        let sum = |weights: &[f64]| -> Vector3<f64> {
            nodes
                .iter()
                .zip(weights)
                .map(|(&node, w)| self.nodes()[node as usize].coords * *w)
                .sum()
        };
        Point3::from(if self.is_quadratic() {
            sum(&basis::quadratic(&point.bary))
        } else {
            sum(&point.bary)
        })
    }

    /// The smooth outward unit normal at `point`: node normals, interpolated.
    ///
    /// # Panics
    /// If `point` is of another, larger skin.
    #[must_use]
    pub fn normal(&self, point: &SkinPoint) -> Vector3<f64> {
        let weights = self.value_weights(&point.bary);
        let nodes = self.face(point.face);
        let sum: Vector3<f64> =
            (0..self.n_face_nodes()).map(|i| self.normals()[nodes[i] as usize] * weights[i]).sum();
        let face_normal = || self.area_vector(point.face, &point.bary);
        sum.try_normalize(1e-9)
            .or_else(|| face_normal().try_normalize(0.0))
            .unwrap_or_else(Vector3::z)
    }

    /// Two unit tangents of the face at `point`, at right angles to each other; their cross product
    /// points outwards. Gradients and covariances on the surface are with respect to them.
    ///
    /// # Panics
    /// If `point` is of another, larger skin.
    #[must_use]
    pub fn tangents(&self, point: &SkinPoint) -> [Vector3<f64>; 2] {
        self.frame(point).tangents
    }

    /// The skin point of a node, on the first face that has it and may be entered.
    #[must_use]
    pub fn node_points(&self) -> Vec<Option<SkinPoint>> {
        let mut points = vec![None; self.n_nodes()];
        for face in (0..self.n_faces()).rev() {
            if self.is_forbidden(face) {
                continue;
            }
            for (&node, b) in self.face_nodes(face).iter().zip(&basis::NODES) {
                points[node as usize] = Some(SkinPoint::trusted(face as u32, *b));
            }
        }
        points
    }

    pub(crate) fn n_face_nodes(&self) -> usize {
        if self.is_quadratic() { 6 } else { 3 }
    }

    /// Shape functions of the face's own nodes.
    pub(crate) fn value_weights(&self, bary: &[f64; 3]) -> [f64; 6] {
        if self.is_quadratic() {
            return basis::quadratic(bary);
        }
        let [a, b, c] = *bary;
        [a, b, c, 0.0, 0.0, 0.0]
    }

    pub(crate) fn frame(&self, point: &SkinPoint) -> Frame {
        Frame::new(self.by_parent(point.face, &point.bary))
    }

    /// Whether `point` lies on an edge that no walk crosses and `step` points over it: the edge's
    /// direction and the inward tangent at right angles to it.
    pub(crate) fn wall_at(
        &self,
        point: &SkinPoint,
        step: &Vector3<f64>,
    ) -> Option<[Vector3<f64>; 2]> {
        let frame = self.frame(point);
        (0..3).find_map(|edge| {
            let is_on = point.bary[(edge + 2) % 3] == 0.0;
            if !is_on || !self.is_wall(point.face, edge) {
                return None;
            }
            let inward = frame.inward(edge);
            (step.dot(&inward) < 0.0).then(|| [frame.edge_direction(edge), inward])
        })
    }

    pub(crate) fn is_wall(&self, face: u32, edge: usize) -> bool {
        match self.side(face, edge) {
            Side::Across { face, .. } => self.is_forbidden(face as usize),
            Side::Rim | Side::Fold => true,
        }
    }
}
