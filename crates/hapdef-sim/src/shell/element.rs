//! The stiffness of one shell triangle.

use nalgebra::{Matrix3, Point3, SMatrix, Vector3};

use super::facet::{Deformation, Facet};
use super::problem::ShellElementProblem;
use super::quadrature::seven_points;
use super::{bending_thick, bending_thin, membrane};
use crate::IsotropicMaterial;

/// The stiffness of one shell element: row and column 6i + c belong to node i; c counts
/// ux, uy, uz (N/m) and rx, ry, rz (N m/rad) along the global axes.
pub type ShellElementMatrix = [[f64; 18]; 18];

/// α of the stabilised transverse shear t²/(t² + α h²) with the longest side h: the value of M. Lyly,
/// R. Stenberg and T. Vihinen, A stable bilinear element for the Reissner–Mindlin plate model,
/// Comput. Methods Appl. Mech. Eng. 110 (1993) 343–357. It vanishes with refinement.
const STABILISATION: f64 = 0.1;

/// The bending theory of a shell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShellKind {
    /// Kirchhoff, without transverse shear: the discrete Kirchhoff triangle.
    Thin,
    /// Reissner–Mindlin, with first-order transverse shear: MITC3+ with stabilised shear.
    #[default]
    Thick,
}

/// The stiffness of the shell triangle on `nodes`.
///
/// `directors` are the unit surface normals at the corners, on the side of the triangle's own
/// normal (counter-clockwise corners seen from its tip); without them the facet's normal is used,
/// which is right at folds. `thickness_m` varies linearly between the corners.
///
/// # Errors
/// [`ShellElementProblem`] on a triangle without area, a director more than 60° off, or a thickness
/// that is not positive.
pub fn shell_stiffness(
    kind: ShellKind,
    nodes: &[Point3<f64>; 3],
    directors: Option<&[Vector3<f64>; 3]>,
    thickness_m: &[f64; 3],
    material: &IsotropicMaterial,
) -> Result<ShellElementMatrix, ShellElementProblem> {
    let section = Section::new(thickness_m, material)?;
    let facet = Facet::new(nodes, directors)?;
    let mut k = membrane::stiffness(&facet, &section.membrane());
    let bending = match kind {
        ShellKind::Thin => thin_bending(&facet, &section),
        ShellKind::Thick => bending_thick::condense(&thick_bending(&facet, &section)).0,
    };
    let mut block = k.fixed_view_mut::<6, 6>(6, 6);
    block += bending;
    Ok(symmetric(&facet.deformation(), &k))
}

/// Thickness and plane-stress moduli of an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    /// At the corners, m.
    pub thickness_m: [f64; 3],
    /// Plane stress: (σ₁₁, σ₂₂, σ₁₂) by (ε₁₁, ε₂₂, γ₁₂), Pa.
    pub plane_stress_pa: Matrix3<f64>,
    /// 5/6 of the shear modulus, Pa (Reissner's factor).
    pub shear_pa: f64,
}

impl Section {
    pub(super) fn new(
        thickness_m: &[f64; 3],
        material: &IsotropicMaterial,
    ) -> Result<Self, ShellElementProblem> {
        for (corner, &thickness_m) in thickness_m.iter().enumerate() {
            if !(thickness_m.is_finite() && thickness_m > 0.0) {
                return Err(ShellElementProblem::Thickness { corner, thickness_m });
            }
        }
        let nu = material.poissons_ratio();
        let e = material.youngs_modulus_pa() / (1.0 - nu * nu);
        let g = material.shear_modulus_pa();
        Ok(Self {
            thickness_m: *thickness_m,
            plane_stress_pa: Matrix3::new(e, e * nu, 0.0, e * nu, e, 0.0, 0.0, 0.0, g),
            shear_pa: 5.0 / 6.0 * g,
        })
    }

    /// The thickness at the barycentric point `at`, m.
    pub(super) fn thickness_at(&self, at: &[f64; 3]) -> f64 {
        self.thickness_m.iter().zip(at).map(|(t, l)| t * l).sum()
    }

    fn membrane(&self) -> Matrix3<f64> {
        self.plane_stress_pa * self.thickness_at(&[1.0 / 3.0; 3])
    }
}

fn thin_bending(facet: &Facet, section: &Section) -> SMatrix<f64, 6, 6> {
    let mut k = SMatrix::zeros();
    for (at, weight) in seven_points() {
        let b = bending_thin::curvature(facet, &at);
        let scale = section.thickness_at(&at).powi(3) / 12.0 * weight * facet.area_m2;
        k += b.transpose() * section.plane_stress_pa * b * scale;
    }
    k
}

pub(super) fn thick_bending(facet: &Facet, section: &Section) -> SMatrix<f64, 8, 8> {
    let mut k = SMatrix::zeros();
    let stabilised = STABILISATION * facet.longest_side_squared();
    for (at, weight) in seven_points() {
        let thickness = section.thickness_at(&at);
        let b = bending_thick::curvature(facet, &at);
        let shear = bending_thick::shear(facet, &at);
        let scale = weight * facet.area_m2;
        k += b.transpose() * section.plane_stress_pa * b * (thickness.powi(3) / 12.0 * scale);
        let softened = thickness.powi(3) / (thickness * thickness + stabilised);
        k += shear.transpose() * shear * (section.shear_pa * softened * scale);
    }
    k
}

/// Tᵀ K T, the same above and below the diagonal.
fn symmetric(t: &Deformation, k: &SMatrix<f64, 12, 12>) -> ShellElementMatrix {
    let kt = k * t;
    let mut matrix = [[0.0; 18]; 18];
    for i in 0..18 {
        for j in i..18 {
            matrix[i][j] = t.column(i).dot(&kt.column(j));
            matrix[j][i] = matrix[i][j];
        }
    }
    matrix
}
