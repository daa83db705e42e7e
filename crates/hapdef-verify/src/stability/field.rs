//! Displacement fields that ten-node tetrahedra with straight sides meet exactly, with the
//! stresses that belong to them.

use hapdef_sim::{IsotropicMaterial, stress};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::VerifyError;

/// A displacement field and its stress.
pub(super) struct Field {
    /// The displacement at a point.
    pub(super) u: Box<dyn Fn(&Point3<f64>) -> Vector3<f64>>,
    /// The stress at a point of an element, given the factor on its modulus.
    pub(super) stress: Box<dyn Fn(&Point3<f64>, f64) -> Matrix3<f64>>,
}

/// The material of modulus `e` and Poisson's ratio `nu`.
pub(super) fn material(e: f64, nu: f64) -> Result<IsotropicMaterial, VerifyError> {
    Ok(IsotropicMaterial::new(e, nu, 1.0)?)
}

/// One strain everywhere: all six components, with the upper triangular gradient that three nodes'
/// holds leave free.
pub(super) fn stretch(material: IsotropicMaterial) -> Field {
    let gradient = Matrix3::new(1.0, 0.4, -0.3, 0.0, -0.7, 0.5, 0.0, 0.0, 0.6) * 1e-3;
    let strain = (gradient + gradient.transpose()) * 0.5;
    Field {
        u: Box::new(move |p| gradient * p.coords),
        stress: Box::new(move |_, factor| stress(&material, &strain) * factor),
    }
}

/// A plate `size` bent about y to the curvature c: σxx = E c z, u = c xz, v = −ν c yz,
/// w = −c/2 (x² + ν(z² − y²)), turned back so that w vanishes at the corners (lx, 0, 0) and
/// (0, ly, 0) (Timoshenko and Goodier, Theory of Elasticity, 3rd ed., article 102).
pub(super) fn bend(material: IsotropicMaterial, size: [f64; 3]) -> Field {
    let c = 1e-3 / size[0];
    let (e, nu) = (material.youngs_modulus_pa(), material.poissons_ratio());
    let (turn_x, turn_y) = (0.5 * c * size[0], -0.5 * c * nu * size[1]);
    Field {
        u: Box::new(move |p| {
            let (x, y, z) = (p.x, p.y, p.z);
            Vector3::new(
                c * x * z - turn_x * z,
                -c * nu * y * z - turn_y * z,
                -0.5 * c * (x * x + nu * (z * z - y * y)) + turn_x * x + turn_y * y,
            )
        }),
        stress: Box::new(move |p, factor| along_x(factor * e * c * p.z)),
    }
}

/// Bars in series along x with ν = 0, clamped at x = 0: one axial force and one bending moment go
/// through parts of compliance `compliances`, each from one of `cuts` to the next; 0 is rigid.
///
/// u = p(x) − w′(x) z and w with w″ = −c(x), where p′ and c are the compliance times a constant.
pub(super) fn series(e: f64, cuts: Vec<f64>, compliances: Vec<f64>) -> Field {
    let (pull, curvature) = (1e-3, 1e-3);
    Field {
        u: Box::new(move |point| {
            let (mut p, mut slope, mut w) = (0.0, 0.0, 0.0);
            for (ends, part) in cuts.windows(2).zip(&compliances) {
                let length = (point.x.min(ends[1]) - ends[0]).max(0.0);
                p += part * pull * length;
                w += slope * length - 0.5 * part * curvature * length * length;
                slope -= part * curvature * length;
            }
            Vector3::new(p - slope * point.z, 0.0, w)
        }),
        stress: Box::new(move |point, _| along_x(e * (pull + curvature * point.z))),
    }
}

fn along_x(value: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(value, 0.0, 0.0))
}
