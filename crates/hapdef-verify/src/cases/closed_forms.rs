//! Thick sphere and cylinder, a hole in a plate, a plate in three dimensions.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Point3, Vector3};

use super::nafems_solids::clean;
use super::prelude::*;
use crate::meshes::hollow_octant;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let spheres = [
        ("sphere", "Thick sphere under inner pressure, ν = 0.3", 0.3),
        ("incompressible.0_49", "Nearly incompressible sphere, ν = 0.49", 0.49),
        ("incompressible.0_4999", "Nearly incompressible sphere, ν = 0.4999", 0.4999),
        ("incompressible.0_499999", "Nearly incompressible sphere, ν = 0.499999", 0.499_999),
        ("incompressible.0_4999999", "Nearly incompressible sphere, ν = 0.4999999", 0.499_999_9),
    ];
    let mut cases: Vec<Case> = spheres.map(sphere).into();
    cases.splice(1..1, cylinder().into_iter().chain([kirsch(), plate()]));
    cases
}

const E: f64 = 1e9;
const INNER: f64 = 1.0;
const OUTER: f64 = 2.0;
const PRESSURE: f64 = 1e6;

/// u(a) of a hollow sphere under inner pressure p: p a / E · ((1 − 2ν) a³ + (1 + ν) b³/2) / (b³ − a³)
/// from u = A r + B / r² with A = (1 − 2ν) p a³ / (E (b³ − a³)), B = (1 + ν) p a³ b³ / (2 E (b³ − a³)).
fn sphere_displacement(nu: f64) -> f64 {
    let (a3, b3) = (INNER.powi(3), OUTER.powi(3));
    PRESSURE * INNER / E * ((1.0 - 2.0 * nu) * a3 + (1.0 + nu) * b3 / 2.0) / (b3 - a3)
}

fn sphere((name, title, nu): (&'static str, &'static str, f64)) -> Case {
    Case {
        name,
        title,
        quantity: "mean radial displacement of the inner surface, radii 1 and 2, an octant",
        unit: "m",
        reference: Reference::Exact(sphere_displacement(nu)),
        source: "Lamé, Timoshenko and Goodier, Theory of Elasticity, 3rd ed., article 136",
        meshes: &[[2; 3], [4; 3], [6; 3]],
        solve: Solve::of(Model {
            mesh: Mesh::Other(|n| {
                let words = format!("{} cells through the wall", n[0]);
                Ok(Body::solid(hollow_octant(n[0])?, n).named(words))
            }),
            material: [E, nu],
            supports: &[(Mirror(0), X(0.0)), (Mirror(1), Y(0.0)), (Mirror(2), Z(0.0))],
            load: Load::Traction(Where(|p| same(p.coords.norm(), INNER)), |_, normal| {
                -normal * PRESSURE
            }),
            // the work of a unit pressure is the mean normal displacement times the area
            probe: Probe::Work(PRESSURE * (0.5 * PI * INNER * INNER)),
        }),
        ..Case::default()
    }
}

/// A quarter of a thick cylinder in plane strain: displacement and stress inside.
fn cylinder() -> [Case; 2] {
    let (a2, b2, nu) = (INNER * INNER, OUTER * OUTER, 0.3);
    let displacement = (1.0 + nu) * PRESSURE * INNER / E * ((1.0 - 2.0 * nu) * a2 + b2) / (b2 - a2);
    let rows = [
        (
            "cylinder.displacement",
            "Thick cylinder under inner pressure, displacement",
            "radial displacement of the inner surface, radii 1 and 2, plane strain",
            ("m", displacement),
            Probe::U(Place::At([INNER, 0.0, 0.0]), 0),
        ),
        (
            "cylinder.stress",
            "Thick cylinder under inner pressure, hoop stress",
            "hoop stress at the inner surface, radii 1 and 2, plane strain",
            ("MPa", PRESSURE * (a2 + b2) / (b2 - a2) / 1e6),
            Probe::Stress([INNER, 0.0, 0.0], 1, 1),
        ),
    ];
    rows.map(|(name, title, quantity, (unit, value), probe)| Case {
        name,
        title,
        quantity,
        unit,
        reference: Reference::Exact(value),
        source: "Lamé, Timoshenko and Goodier, Theory of Elasticity, 3rd ed., article 28, with \
            plane strain",
        meshes: &[[2, 4, 1], [4, 8, 1], [8, 16, 2]],
        solve: Solve::of(Model {
            mesh: Mesh::Block(|p| quarter_ring(p, |radius, _| radius)),
            material: [E, nu],
            supports: PLANE_STRAIN_QUARTER,
            load: Load::Traction(Where(|p| same(p.xy().coords.norm(), INNER)), |_, normal| {
                -normal * PRESSURE
            }),
            probe,
        }),
        ..Case::default()
    })
}

const PLANE_STRAIN_QUARTER: &[(Held, On)] = &[
    (Mirror(1), Y(0.0)),
    (Mirror(0), X(0.0)),
    (Mirror(2), Where(|p| same(p.z, 0.0) || same(p.z, 0.5))),
];

/// A quarter ring from radius 1, of thickness ½; `outer(ρ, φ)` is the radius at ρ in 1..2.
fn quarter_ring(p: Point3<f64>, outer: fn(f64, f64) -> f64) -> Point3<f64> {
    let phi = FRAC_PI_2 * p.y;
    let r = outer(INNER + (OUTER - INNER) * p.x, phi);
    clean(Point3::new(r * phi.cos(), r * phi.sin(), 0.5 * p.z))
}

/// In-plane stress beside a hole of radius 1 under unit tension along x at infinity
/// (Timoshenko and Goodier, 3rd ed., article 35, eq. 61), as a tensor in x and y.
fn kirsch_stress(p: &Point3<f64>, nu: f64) -> Matrix3<f64> {
    let (r2, phi) = (p.x * p.x + p.y * p.y, p.y.atan2(p.x));
    let (q, q2) = (1.0 / r2, 1.0 / (r2 * r2));
    let (c2, s2) = ((2.0 * phi).cos(), (2.0 * phi).sin());
    let radial = 0.5 * (1.0 - q) + 0.5 * (1.0 + 3.0 * q2 - 4.0 * q) * c2;
    let hoop = 0.5 * (1.0 + q) - 0.5 * (1.0 + 3.0 * q2) * c2;
    let shear = -0.5 * (1.0 - 3.0 * q2 + 2.0 * q) * s2;
    let (s, c) = phi.sin_cos();
    let turn = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
    let polar = Matrix3::new(radial, shear, 0.0, shear, hoop, 0.0, 0.0, 0.0, nu * (radial + hoop));
    turn * polar * turn.transpose()
}

fn kirsch() -> Case {
    Case {
        name: "kirsch",
        title: "Kirsch, a hole in an infinite plate",
        quantity: "σxx at (0, 1) per tension; the exact tractions act on a square of half side 4, plane strain",
        reference: Reference::Exact(3.0),
        source: "Kirsch 1898, Timoshenko and Goodier, Theory of Elasticity, 3rd ed., article 35, eq. 61",
        meshes: &[[6, 8, 1], [12, 16, 1], [24, 32, 1]],
        solve: Solve::of(Model {
            // the radius runs from the hole to the square, finer at the hole; the corner of the square
            // lies on the line φ = 45° between two cells
            mesh: Mesh::Block(|p| {
                quarter_ring(p, |rho, phi| {
                    let side = 4.0 / phi.cos().max(phi.sin());
                    let t = rho - INNER;
                    1.0 + (side - 1.0) * t * (0.25 + 0.75 * t)
                })
            }),
            material: [E, 0.3],
            supports: PLANE_STRAIN_QUARTER,
            load: Load::Traction(Where(|p| same(p.x, 4.0) || same(p.y, 4.0)), |p, normal| {
                kirsch_stress(p, 0.3) * normal * 1e6
            }),
            probe: Probe::Stress([0.0, 1.0, 0.0], 0, 0),
        }),
        ..Case::default()
    }
}

const SIDE: f64 = 1.0;
const THICKNESS: f64 = 0.1;

/// Deflection of the mid-plane at the centre of a simply supported square plate under the pressure
/// q sin(πx/a) sin(πy/a), three-dimensional.
///
/// In-plane displacements are U(z) ∇φ / k and w is W(z) φ with φ = sin sin and k = π√2/a, since
/// ∇²φ = −k²φ turns the equations into those of a strip in plane strain (Timoshenko and Goodier, 3rd
/// ed., article 24): W = A cosh kz + B kz sinh kz, U = (A + (3 − 4ν)B) sinh kz + B kz cosh kz. No
/// shear at z = ±c gives A = −B(2 − 2ν + kc tanh kc); half the pressure on each face gives
/// 2μk((A + (1 − 2ν)B) sinh kc + B kc cosh kc) = q/2. The other half, a uniform squeeze, leaves the
/// mid-plane where it is.
fn plate_deflection(nu: f64, pressure: f64) -> f64 {
    let (k, c) = (PI * 2.0_f64.sqrt() / SIDE, 0.5 * THICKNESS);
    let (kc, mu) = (k * c, E / (2.0 + 2.0 * nu));
    let a_over_b = -(2.0 - 2.0 * nu + kc * kc.tanh());
    let per_b = (a_over_b + 1.0 - 2.0 * nu) * kc.sinh() + kc * kc.cosh();
    a_over_b * (0.5 * pressure / (2.0 * mu * k * per_b))
}

fn plate() -> Case {
    Case {
        name: "plate",
        title: "Simply supported square plate, sinusoidal pressure",
        quantity: "mid-plane deflection at the centre, thickness a/10, ν = 0.3",
        unit: "m",
        reference: Reference::Exact(plate_deflection(0.3, PRESSURE)),
        source: "three-dimensional closed form of Navier's load term (a strip in plane strain with \
            k² = 2π²/a², Timoshenko and Goodier, article 24); thin-plate theory (Timoshenko and \
            Woinowsky-Krieger, article 27) gives 5 % less at this thickness",
        meshes: &[[4, 4, 2], [8, 8, 2], [16, 16, 4]],
        solve: Solve::of(Model {
            mesh: Mesh::Block(|p| {
                Point3::new(0.5 * SIDE * p.x, 0.5 * SIDE * p.y, THICKNESS * (p.z - 0.5))
            }),
            material: [E, 0.3],
            // edges at x = 0 and y = 0 with w = 0 and no motion along the edge; symmetry at a/2
            supports: &[
                (Only(&[2]), Where(|p| same(p.x, 0.0) || same(p.y, 0.0))),
                (Only(&[1]), Where(|p| same(p.x, 0.0) || same(p.y, 0.5 * SIDE))),
                (Only(&[0]), Where(|p| same(p.y, 0.0) || same(p.x, 0.5 * SIDE))),
            ],
            load: Load::Traction(Z(0.5 * THICKNESS), |p, _| {
                let wave = (PI * p.x / SIDE).sin() * (PI * p.y / SIDE).sin();
                Vector3::z() * (PRESSURE * wave)
            }),
            probe: Probe::U(Place::At([0.5 * SIDE, 0.5 * SIDE, 0.0]), 2),
        }),
        ..Case::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For kh → 0 the three-dimensional form is q / (D k⁴) (1 + (8 − 3ν)/(40(1 − ν)) k²h² + …).
    #[test]
    fn plate_form_is_thin_plate_theory_with_its_next_term() {
        let nu = 0.3;
        let rigidity = E * THICKNESS.powi(3) / (12.0 * (1.0 - nu * nu));
        let thin = PRESSURE * SIDE.powi(4) / (4.0 * PI.powi(4) * rigidity);
        let kh2 = 2.0 * (PI * THICKNESS / SIDE).powi(2);
        let next = 1.0 + (8.0 - 3.0 * nu) / (40.0 * (1.0 - nu)) * kh2;
        let ratio = plate_deflection(nu, PRESSURE) / (thin * next);
        // what is left is of the order (kh)⁴ / 100
        assert!((ratio - 1.0).abs() < 1e-3, "ratio {ratio}");
    }

    #[test]
    fn the_hole_is_free_and_the_far_field_plain() {
        for phi in [0.1_f64, 0.7, 1.4] {
            let (s, c) = phi.sin_cos();
            let n = Vector3::new(c, s, 0.0);
            assert!((kirsch_stress(&Point3::new(c, s, 0.0), 0.3) * n).norm() < 1e-14);
            let far = kirsch_stress(&Point3::new(1e4 * c, 1e4 * s, 0.0), 0.3);
            assert!((far[(0, 0)] - 1.0).abs() < 1e-7 && far[(1, 1)].abs() < 1e-7);
        }
        assert!((kirsch_stress(&Point3::new(0.0, 1.0, 0.0), 0.3)[(0, 0)] - 3.0).abs() < 1e-14);
    }
}
