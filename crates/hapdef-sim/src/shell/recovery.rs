//! Strain and section forces inside a shell element, as linear functionals of its 18 degrees of
//! freedom.

use nalgebra::{Matrix3, Point3, SMatrix, SVector, Vector3};

use super::element::{Section, thick_bending};
use super::facet::Facet;
use super::{ShellElementProblem, ShellKind, bending_thick, bending_thin, membrane};
use crate::IsotropicMaterial;

/// Strain at a point of a shell element by its 18 degrees of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellStrain {
    axes: [Vector3<f64>; 3],
    membrane: SMatrix<f64, 3, 18>,
    curvature: SMatrix<f64, 3, 18>,
}

/// Forces and moments per length of a shell section, in the element's plane axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShellResultants {
    /// N₁₁, N₂₂, N₁₂, N/m.
    pub force_n_m: [f64; 3],
    /// M₁₁, M₂₂, M₁₂, N; positive where the top (director) side is in tension.
    pub moment_n: [f64; 3],
}

impl ShellStrain {
    /// The strain at the barycentric point `at` of the element that [`super::shell_stiffness`]
    /// makes of the same arguments.
    ///
    /// # Errors
    /// As [`super::shell_stiffness`].
    pub fn new(
        kind: ShellKind,
        nodes: &[Point3<f64>; 3],
        directors: Option<&[Vector3<f64>; 3]>,
        thickness_m: &[f64; 3],
        material: &IsotropicMaterial,
        at: &[f64; 3],
    ) -> Result<Self, ShellElementProblem> {
        let section = Section::new(thickness_m, material)?;
        let facet = Facet::new(nodes, directors)?;
        let t = facet.deformation();
        let bending = match kind {
            ShellKind::Thin => bending_thin::curvature(&facet, at),
            ShellKind::Thick => {
                let (_, bubble) = bending_thick::condense(&thick_bending(&facet, &section));
                let b = bending_thick::curvature(&facet, at);
                b.fixed_columns::<6>(0) + b.fixed_columns::<2>(6) * bubble
            }
        };
        Ok(Self {
            axes: facet.axes,
            membrane: membrane::basic_strain(&facet) * t,
            curvature: bending * t.fixed_rows::<6>(6),
        })
    }

    /// The strain along the unit direction `axis` at the signed distance `z_m` from the
    /// mid-surface (positive on the director's side), as 18 factors of the degrees of freedom in
    /// the order of [`super::ShellElementMatrix`]; the part of `axis` along the normal is left out.
    #[must_use]
    pub fn along(&self, axis: &Vector3<f64>, z_m: f64) -> [f64; 18] {
        let (a, b) = (axis.dot(&self.axes[0]), axis.dot(&self.axes[1]));
        let project = Vector3::new(a * a, b * b, a * b);
        let row = (self.membrane + self.curvature * z_m).transpose() * project;
        row.into()
    }

    /// The strain tensor in space at the distance `z_m` for the degrees of freedom `values`, with
    /// zero strain along the normal.
    #[must_use]
    pub fn tensor(&self, values: &[f64; 18], z_m: f64) -> Matrix3<f64> {
        let q = SVector::<f64, 18>::from(*values);
        let e = self.membrane * q + self.curvature * q * z_m;
        let [e1, e2, _] = &self.axes;
        e1 * e1.transpose() * e[0]
            + e2 * e2.transpose() * e[1]
            + (e1 * e2.transpose() + e2 * e1.transpose()) * (0.5 * e[2])
    }

    /// The element's axes in space: two in its plane, and its normal.
    #[must_use]
    pub fn axes(&self) -> &[Vector3<f64>; 3] {
        &self.axes
    }

    /// The section's forces and moments for the degrees of freedom `values` at a thickness.
    #[must_use]
    pub fn resultants(
        &self,
        values: &[f64; 18],
        thickness_m: f64,
        material: &IsotropicMaterial,
    ) -> ShellResultants {
        let q = SVector::<f64, 18>::from(*values);
        let nu = material.poissons_ratio();
        let e = material.youngs_modulus_pa() / (1.0 - nu * nu);
        let stress = |s: Vector3<f64>| {
            let half = 0.5 * (1.0 - nu);
            [e * (s.x + nu * s.y), e * (nu * s.x + s.y), e * half * s.z]
        };
        ShellResultants {
            force_n_m: stress(self.membrane * q).map(|s| s * thickness_m),
            moment_n: stress(self.curvature * q).map(|s| s * thickness_m.powi(3) / 12.0),
        }
    }
}
