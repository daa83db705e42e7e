//! A manufactured solution: the order at which errors fall.

use std::f64::consts::PI;

use hapdef_mesh::tet10;
use hapdef_sim::{NodalLoad, strain, stress};
use nalgebra::{Matrix3, Point3, Vector3};

use super::problem::{Problem, Solution};
use crate::meshes::Blocks;
use crate::{Case, Measured, Reference, Target, VerifyError};

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let case = |id, title, target, run: fn(usize) -> Result<Measured, VerifyError>| Case {
        id,
        title,
        element: "TET10",
        quantity: "relative error of u = (1, 0.5, −0.7) sin πx sin πy sin πz on a cube with curved \
            inner faces",
        unit: "1",
        reference: Reference::Zero,
        source: "the body force that makes it exact; Roache, J. Fluids Eng. 124, 2002; a quadratic \
            element has order 3 in L² and 2 in energy",
        target,
        n_levels: 3,
        known_miss: None,
        run: Box::new(run),
    };
    vec![
        case(
            "solid.manufactured.l2",
            "Manufactured solution, L² norm",
            Target::within(0.01).and_order(2.8),
            |level| errors(level, |e| e.l2),
        ),
        case(
            "solid.manufactured.energy",
            "Manufactured solution, energy norm",
            Target::within(0.05).and_order(1.85),
            |level| errors(level, |e| e.energy),
        ),
    ]
}

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

fn errors(level: usize, pick: fn(&Norms) -> [f64; 2]) -> Result<Measured, VerifyError> {
    let n = [4, 8, 12][level];
    let mesh = Blocks::new(1e-9)
        .block([n; 3], |p| p + Vector3::new(0.06, -0.05, 0.04) * bump(&p).0)
        .finish()?;
    let wall = |p: &Point3<f64>| p.iter().any(|c| c.abs() < 1e-12 || (c - 1.0).abs() < 1e-12);
    let problem = Problem::new(mesh, 1.0, 0.3)?.clamp(wall);
    let (lambda, mu) = (problem.material.lame_lambda_pa(), problem.material.shear_modulus_pa());
    // −div σ of u = φ c: −μ Δφ c − (λ + μ) ∇∇φ c
    let load = NodalLoad::body_force(&problem.mesh, |p| {
        let (phi, _, hessian) = bump(p);
        direction() * (3.0 * PI * PI * mu * phi) - hessian * direction() * (lambda + mu)
    });
    let solution = problem.solve(&load)?;
    let [error, whole] = pick(&norms(&problem, &solution));
    Ok(solution.measured((error / whole).sqrt(), format!("{n}³ cells"), 1.0 / n as f64))
}

fn norms(problem: &Problem, solution: &Solution<'_>) -> Norms {
    let mut norms = Norms::default();
    for (element, ids) in problem.mesh.elements().iter().enumerate() {
        let nodes = problem.mesh.element_positions(element);
        let own = ids.map(|id| solution.u[id.index()]);
        for (r, weight) in fine_rule() {
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
                *sum += stress(&problem.material, &eps).component_mul(&eps).sum() * volume;
            }
        }
    }
    norms
}

/// Four Gauss–Legendre points a direction under Duffy's map, exact to degree 5: an error integral
/// needs more than the stiffness rule, at whose points strains superconverge.
fn fine_rule() -> impl Iterator<Item = ([f64; 3], f64)> {
    const GAUSS4: [(f64, f64); 4] = [
        (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
        (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
    ];
    GAUSS4.into_iter().flat_map(|(a, wa)| {
        GAUSS4.into_iter().flat_map(move |(b, wb)| {
            GAUSS4.into_iter().map(move |(c, wc)| {
                let (ra, rb) = (1.0 - a, 1.0 - b);
                ([a, b * ra, c * ra * rb], wa * wb * wc * ra * ra * rb)
            })
        })
    })
}
