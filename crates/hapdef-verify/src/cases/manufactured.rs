//! A manufactured solution: the order at which errors fall.

use std::f64::consts::PI;

use hapdef_mesh::tet10;
use hapdef_sim::{strain, stress, tet_rule};
use nalgebra::{Matrix3, Point3, Vector3};

use super::prelude::*;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let l2 = Case {
        name: "manufactured.l2",
        title: "Manufactured solution, L² norm",
        quantity: "relative error of u = (1, 0.5, −0.7) sin πx sin πy sin πz on a cube with curved \
            inner faces",
        source: "the body force that makes it exact; Roache, J. Fluids Eng. 124, 2002; a quadratic \
            element has order 3 in L² and 2 in energy",
        target: Target::within(0.01).and_order(2.8),
        meshes: &[[4; 3], [8; 3], [12; 3]],
        solve: Solve::of(MODEL),
        ..Case::default()
    };
    let probe = Probe::Value(|s| relative_error(s, |norms| norms.energy));
    let energy = Case {
        name: "manufactured.energy",
        title: "Manufactured solution, energy norm",
        target: Target::within(0.05).and_order(1.85),
        solve: Solve::of(Model { probe, ..MODEL }),
        ..l2.clone()
    };
    vec![l2, energy]
}

const MODEL: Model = Model {
    mesh: Mesh::Other(|n| {
        let curved = |p: Point3<f64>| p + Vector3::new(0.06, -0.05, 0.04) * bump(&p).0;
        let mesh = Blocks::default().block(n, curved).finish()?;
        Ok(Body::solid(mesh, n).named(format!("{}³ cells", n[0])))
    }),
    material: [1.0, 0.3],
    supports: &[(All, Where(|p| p.iter().any(|&c| same(c, 0.0) || same(c, 1.0))))],
    // −div σ of u = φ c: −μ Δφ c − (λ + μ) ∇∇φ c
    load: Load::Volume(|material, p| {
        let (lambda, mu) = (material.lame_lambda_pa(), material.shear_modulus_pa());
        let (phi, _, hessian) = bump(p);
        direction() * (3.0 * PI * PI * mu * phi) - hessian * direction() * (lambda + mu)
    }),
    probe: Probe::Value(|s| relative_error(s, |norms| norms.l2)),
};

/// Squares of norms, of the error and of the solution.
#[derive(Default)]
struct Norms {
    l2: [f64; 2],
    energy: [f64; 2],
}

fn direction() -> Vector3<f64> {
    Vector3::new(1.0, 0.5, -0.7)
}

/// φ = sin πx sin πy sin πz with gradient and Hessian.
fn bump(p: &Point3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let s = p.coords.map(|c| (PI * c).sin());
    let c = p.coords.map(|c| (PI * c).cos() * PI);
    let phi = s.x * s.y * s.z;
    let gradient = Vector3::new(c.x * s.y * s.z, s.x * c.y * s.z, s.x * s.y * c.z);
    let hessian = Matrix3::from_fn(|i, j| match i == j {
        true => -PI * PI * phi,
        false => c[i] * c[j] * s[3 - i - j],
    });
    (phi, gradient, hessian)
}

fn relative_error(s: &Solution, pick: fn(&Norms) -> [f64; 2]) -> Result<f64, VerifyError> {
    let [error, whole] = pick(&norms(s)?);
    Ok((error / whole).sqrt())
}

fn norms(s: &Solution) -> Result<Norms, VerifyError> {
    let mut norms = Norms::default();
    let mesh = s.problem.body.tets()?;
    for (element, ids) in mesh.elements().iter().enumerate() {
        let nodes = mesh.element_positions(element);
        let own = ids.map(|id| s.motion.displacement[id.index()]);
        // an error integral needs more than the stiffness rule, at whose points strains superconverge
        for (r, weight) in tet_rule() {
            let volume = weight * tet10::jacobian(&nodes, r).determinant();
            let (phi, gradient, _) = bump(&tet10::position(&nodes, r));
            let found: Vector3<f64> = own.iter().zip(tet10::shape(r)).map(|(u, n)| u * n).sum();
            let exact = direction() * phi;
            norms.l2[0] += (found - exact).norm_squared() * volume;
            norms.l2[1] += exact.norm_squared() * volume;
            let gradient = direction() * gradient.transpose();
            let exact = (gradient + gradient.transpose()) * 0.5;
            let error = strain(&nodes, &own, r) - exact;
            for (sum, eps) in norms.energy.iter_mut().zip([error, exact]) {
                *sum += stress(&s.problem.material, &eps).component_mul(&eps).sum() * volume;
            }
        }
    }
    Ok(norms)
}
