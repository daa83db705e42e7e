//! Displacement fields that ten-node tetrahedra with straight sides meet exactly, with the
//! stresses that belong to them.

use hapdef_sim::{IsotropicMaterial, stress};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::VerifyError;

/// A displacement field and its stress.
pub(crate) struct Field {
    /// The displacement at a point.
    pub(crate) u: Displacement,
    /// The stress at a point of an element, given the factor on its modulus.
    pub(crate) stress: Stress,
}

type Displacement = Box<dyn Fn(&Point3<f64>) -> Vector3<f64>>;

type Stress = Box<dyn Fn(&Point3<f64>, f64) -> Matrix3<f64>>;

/// The material of modulus `e` and Poisson's ratio `nu`.
pub(crate) fn material(e: f64, nu: f64) -> Result<IsotropicMaterial, VerifyError> {
    Ok(IsotropicMaterial::new(e, nu, 1.0)?)
}

/// One strain everywhere: all six components, with the upper triangular gradient that three nodes'
/// holds leave free.
pub(crate) fn stretch(material: IsotropicMaterial) -> Field {
    uniform(material, Matrix3::new(1.0, 0.4, -0.3, 0.0, -0.7, 0.5, 0.0, 0.0, 0.6) * 1e-3)
}

/// One displacement gradient everywhere.
pub(crate) fn uniform(material: IsotropicMaterial, gradient: Matrix3<f64>) -> Field {
    let strain = (gradient + gradient.transpose()) * 0.5;
    Field {
        u: Box::new(move |p| gradient * p.coords),
        stress: Box::new(move |_, factor| stress(&material, &strain) * factor),
    }
}

/// A plate `size` bent about y to the curvature c: σxx = E c z, u = c xz, v = −ν c yz,
/// w = −c/2 (x² + ν(z² − y²)), turned back so that w vanishes at the corners (lx, 0, 0) and
/// (0, ly, 0) (Timoshenko and Goodier, Theory of Elasticity, 3rd ed., article 102).
pub(crate) fn bend(material: IsotropicMaterial, size: [f64; 3]) -> Field {
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
pub(crate) fn series(e: f64, cuts: Vec<f64>, compliances: Vec<f64>) -> Field {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The stress of the displacement's central differences is the field's own.
    #[track_caller]
    fn agrees(field: &Field, material: &IsotropicMaterial, at: [f64; 3], factor: f64) {
        let (at, h) = (Point3::from(at), 1e-5);
        let mut gradient = Matrix3::zeros();
        for axis in 0..3 {
            let step = Vector3::ith(axis, h);
            let slope = ((field.u)(&(at + step)) - (field.u)(&(at - step))) / (2.0 * h);
            gradient.set_column(axis, &slope);
        }
        let strain = (gradient + gradient.transpose()) * 0.5;
        let found = stress(material, &strain) * factor;
        let expected = (field.stress)(&at, factor);
        let error = (found - expected).amax() / expected.amax();
        assert!(error < 1e-8, "{error:e} at {at}");
    }

    #[test]
    fn stress_belongs_to_displacement() {
        let soft = material(2e9, 0.3).unwrap();
        agrees(&stretch(soft), &soft, [0.2, 0.3, 0.4], 7.0);
        agrees(&bend(soft, [1.0, 1.0, 0.1]), &soft, [0.2, 0.3, 0.04], 1.0);
        let plain = material(2e9, 0.0).unwrap();
        let bars = series(2e9, vec![0.0, 0.5, 1.5, 2.0], vec![1.0, 0.25, 1.0]);
        agrees(&bars, &plain, [0.3, 0.2, 0.6], 1.0);
        agrees(&bars, &plain, [1.2, 0.2, 0.6], 4.0);
        agrees(&bars, &plain, [1.8, 0.2, 0.6], 1.0);
    }
}
