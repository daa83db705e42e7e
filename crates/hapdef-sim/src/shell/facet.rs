//! The flat facet under a shell triangle and the twelve numbers that deform it.

use nalgebra::{Matrix3, Point3, RowSVector, SMatrix, Vector2, Vector3};

use super::ShellElementProblem;

/// Deformation by the 18 nodal displacements and rotations: rows 0..3 are the strains
/// (ε₁₁, ε₂₂, γ₁₂) of the linear triangle, rows 3..6 the drilling rotations and rows 6..12 the tilts
/// (β₁, β₂) of the three directors, both relative to the facet's own rotation.
pub(super) type Deformation = SMatrix<f64, 12, 18>;

/// The least cosine between a director and its facet's normal: 60°.
pub(super) const MIN_COS: f64 = 0.5;

/// A facet in its own frame.
#[derive(Clone, Debug)]
pub(super) struct Facet {
    /// Unit axes in space: along the first side, across it in the plane, and the normal.
    pub axes: [Vector3<f64>; 3],
    /// Corners in the plane from the first one, m.
    pub corners: [Vector2<f64>; 3],
    /// Area, m².
    pub area_m2: f64,
    /// Gradients of the barycentric coordinates in the plane, 1/m.
    pub gradients: [Vector2<f64>; 3],
    /// At each corner the director and the two plane axes turned with it.
    frames: [Matrix3<f64>; 3],
}

impl Facet {
    /// The facet on `nodes`, with the unit `directors` of its corners, or its own normal without.
    pub(super) fn new(
        nodes: &[Point3<f64>; 3],
        directors: Option<&[Vector3<f64>; 3]>,
    ) -> Result<Self, ShellElementProblem> {
        let [a, b] = [nodes[1] - nodes[0], nodes[2] - nodes[0]];
        let twice_area = a.cross(&b).norm();
        let longest = a.norm().max(b.norm()).max((b - a).norm());
        if !(twice_area.is_finite() && twice_area > f64::EPSILON * longest * longest) {
            let area_m2 = 0.5 * twice_area;
            return Err(ShellElementProblem::Flat { area_m2 });
        }
        let axis = a / a.norm();
        let normal = a.cross(&b) / twice_area;
        let axes = [axis, normal.cross(&axis), normal];
        let plane = |v: Vector3<f64>| Vector2::new(v.dot(&axes[0]), v.dot(&axes[1]));
        let corners = [Vector2::zeros(), plane(a), plane(b)];
        let gradient = |i: usize| {
            let side = corners[(i + 2) % 3] - corners[(i + 1) % 3];
            Vector2::new(-side.y, side.x) / twice_area
        };
        let mut frames = [Matrix3::from_columns(&axes); 3];
        if let Some(directors) = directors {
            for (corner, director) in directors.iter().enumerate() {
                frames[corner] = turned(&axes, corner, director)?;
            }
        }
        Ok(Self {
            axes,
            corners,
            area_m2: 0.5 * twice_area,
            gradients: [gradient(0), gradient(1), gradient(2)],
            frames,
        })
    }

    /// The side that starts at corner `i`, in the plane, m.
    pub(super) fn side(&self, i: usize) -> Vector2<f64> {
        self.corners[(i + 1) % 3] - self.corners[i]
    }

    /// h² of the longest side, m².
    pub(super) fn longest_side_squared(&self) -> f64 {
        let sides = [0, 1, 2].map(|i| self.side(i).norm_squared());
        sides.into_iter().fold(0.0, f64::max)
    }

    /// The director's part along the plane vector `along`.
    pub(super) fn lean(&self, corner: usize, along: &Vector2<f64>) -> f64 {
        let director = self.frames[corner].column(2);
        director.dot(&self.axes[0]) * along.x + director.dot(&self.axes[1]) * along.y
    }

    /// Drilling along side `i`: the mean director of its ends times the difference of their
    /// rotations, by the twelve deformations.
    pub(super) fn drilling_step(&self, i: usize) -> RowSVector<f64, 12> {
        let ends = [i, (i + 1) % 3];
        let mean = (self.frames[ends[0]].column(2) + self.frames[ends[1]].column(2)) * 0.5;
        let mut row = RowSVector::zeros();
        for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
            for (column, axis) in self.rotation_axes(end) {
                row[column] = sign * mean.dot(&axis);
            }
        }
        row
    }

    /// The operator from nodal displacements and rotations to deformation.
    ///
    /// The facet's rotation ω = (∂w/∂y, −∂w/∂x, ½(∂v/∂x − ∂u/∂y)) is taken from the nodal rotations
    /// Rᵢ before they are read in the frame of the director dᵢ: drilling is dᵢ·(Rᵢ − ω) and tilt is
    /// (Rᵢ − ω) × dᵢ. Rigid motions then deform nothing, whatever the directors, and on a curved
    /// surface bending never meets the drilling stiffness of its neighbours.
    pub(super) fn deformation(&self) -> Deformation {
        let mut d = Deformation::zeros();
        let [e1, e2, e3] = &self.axes;
        for (node, g) in self.gradients.iter().enumerate() {
            for c in 0..3 {
                let column = 6 * node + c;
                d[(0, column)] = g.x * e1[c];
                d[(1, column)] = g.y * e2[c];
                d[(2, column)] = g.y * e1[c] + g.x * e2[c];
                let rotation = e1 * (g.y * e3[c]) - e2 * (g.x * e3[c])
                    + e3 * (0.5 * (g.x * e2[c] - g.y * e1[c]));
                for corner in 0..3 {
                    for (row, axis) in self.rotation_axes(corner) {
                        d[(row, column)] = -axis.dot(&rotation);
                    }
                }
            }
            for (row, axis) in self.rotation_axes(node) {
                for c in 0..3 {
                    d[(row, 6 * node + 3 + c)] = axis[c];
                }
            }
        }
        d
    }

    /// Deformation rows of a corner and the axis about which each reads the relative rotation.
    fn rotation_axes(&self, corner: usize) -> [(usize, Vector3<f64>); 3] {
        let frame = &self.frames[corner];
        let axis = |k: usize| frame.column(k).into_owned();
        [(3 + corner, axis(2)), (6 + 2 * corner, axis(1)), (7 + 2 * corner, -axis(0))]
    }
}

/// The symmetric gradient (ε₁₁, ε₂₂, γ₁₂) of `shape(x) · e_axis` with gradient `gradient`.
pub(super) fn strain_column(gradient: &Vector2<f64>, axis: usize) -> Vector3<f64> {
    match axis {
        0 => Vector3::new(gradient.x, 0.0, gradient.y),
        _ => Vector3::new(0.0, gradient.y, gradient.x),
    }
}

/// The axes turned by the smallest rotation that takes the normal to `director`.
fn turned(
    axes: &[Vector3<f64>; 3],
    corner: usize,
    director: &Vector3<f64>,
) -> Result<Matrix3<f64>, ShellElementProblem> {
    let normal = &axes[2];
    let cos = normal.dot(director);
    if !(cos >= MIN_COS && (director.norm() - 1.0).abs() < 1e-6) {
        return Err(ShellElementProblem::Director { corner, director: (*director).into(), cos });
    }
    let k = normal.cross(director);
    let turn = |v: &Vector3<f64>| {
        let kv = k.cross(v);
        v + kv + k.cross(&kv) / (1.0 + cos)
    };
    Ok(Matrix3::from_columns(&[turn(&axes[0]), turn(&axes[1]), *director]))
}
