//! MacNeal and Harder's beams.

use std::f64::consts::{FRAC_PI_2, PI};

use hapdef_mesh::Tet10Mesh;
use nalgebra::{Point3, Vector3};

use super::problem::{Problem, cells, same};
use crate::meshes::{Blocks, faces_where, nodes_where};
use crate::{Case, Measured, Reference, Target, VerifyError};

const STRAIGHT: &str = "MacNeal and Harder, A proposed standard set of problems to test finite \
    element accuracy, Finite Elem. Anal. Des. 1, 1985, table 3 (value from memory); it agrees with \
    the Timoshenko beam";

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    vec![
        straight("solid.straight.extension", "Straight cantilever, extension", 0, 3e-5),
        straight("solid.straight.in_plane", "Straight cantilever, in-plane shear", 1, 0.1081),
        straight(
            "solid.straight.out_of_plane",
            "Straight cantilever, out-of-plane shear",
            2,
            0.4321,
        ),
        twist(),
        curved_in_plane(),
        curved_out_of_plane(),
        twisted("solid.twisted.in_plane", "Twisted beam, in-plane shear", 2, 5.424e-3),
        twisted("solid.twisted.out_of_plane", "Twisted beam, out-of-plane shear", 1, 1.754e-3),
    ]
}

/// A unit force at the tip of `problem`, spread over the faces where `tip`, and the mean
/// displacement along it.
fn tip_displacement(
    problem: &Problem,
    direction: Vector3<f64>,
    tip: impl Fn(&Point3<f64>) -> bool,
    n: [usize; 3],
) -> Result<Measured, VerifyError> {
    let faces = faces_where(&problem.mesh, tip);
    let pull = problem.traction(&faces, |_, _| direction);
    let load = pull.scaled(1.0 / pull.total_n().dot(&direction));
    let solution = problem.solve(&load)?;
    let value = load.work_j(&solution.u)?;
    Ok(solution.measured(value, cells(n), 1.0 / n.into_iter().max().unwrap_or(1) as f64))
}

fn straight(id: &'static str, title: &'static str, axis: usize, reference: f64) -> Case {
    Case {
        id,
        title,
        element: "TET10",
        quantity: "mean displacement of the tip face along a unit force, L = 6, 0.2 × 0.1, E = 1e7, ν = 0.3",
        unit: "in",
        reference: Reference::Published(reference),
        source: STRAIGHT,
        target: Target::within(0.01),
        n_levels: 3,
        known_miss: None,
        run: Box::new(move |level| {
            let (n, mesh) = straight_mesh(level)?;
            let problem = Problem::new(mesh, 1e7, 0.3)?.clamp(|p| same(p.x, 0.0));
            let direction = Vector3::from_fn(|i, _| f64::from(u8::from(i == axis)));
            tip_displacement(&problem, direction, |p| same(p.x, 6.0), n)
        }),
    }
}

fn straight_mesh(level: usize) -> Result<([usize; 3], Tet10Mesh), VerifyError> {
    let n = [[15, 1, 1], [30, 2, 2], [60, 4, 4]][level];
    let map = |p: Point3<f64>| Point3::new(6.0 * p.x, 0.2 * (p.y - 0.5), 0.1 * (p.z - 0.5));
    Ok((n, Blocks::new(1e-6).block(n, map).finish()?))
}

/// Torsion constant of a rectangle with half sides a ≥ b:
/// J = 16 a b³ (1/3 − 64/π⁵ b/a Σ tanh(nπa/2b)/n⁵), n odd
/// (Timoshenko and Goodier, Theory of Elasticity, 3rd ed., article 109, eq. 160).
fn torsion_constant(a: f64, b: f64) -> f64 {
    let term = |n: f64| (n * PI * a / (2.0 * b)).tanh() / n.powi(5);
    let sum: f64 = (0..20).map(|i| term(f64::from(2 * i + 1))).sum();
    16.0 * a * b.powi(3) * (1.0 / 3.0 - 64.0 / PI.powi(5) * b / a * sum)
}

fn twist() -> Case {
    let shear_modulus = 1e7 / 2.6;
    Case {
        id: "solid.straight.twist",
        title: "Straight cantilever, twist",
        element: "TET10",
        quantity: "twist between x = 2 and x = 4 times 3 under a unit torque, sections free to warp",
        unit: "rad",
        reference: Reference::Exact(6.0 / (shear_modulus * torsion_constant(0.1, 0.05))),
        source: "Saint-Venant torsion of a rectangle, Timoshenko and Goodier, 3rd ed., article 109, \
            eq. 160. MacNeal and Harder print 0.03208 (value from memory), 6 % less than Saint-Venant",
        target: Target::within(0.01),
        n_levels: 3,
        known_miss: None,
        run: Box::new(|level| {
            let (n, mesh) = straight_mesh(level)?;
            let problem = Problem::new(mesh, 1e7, 0.3)?.clamp(|p| same(p.x, 0.0));
            let tip = faces_where(&problem.mesh, |p| same(p.x, 6.0));
            let turn = problem.traction(&tip, |p, _| Vector3::new(0.0, -p.z, p.y));
            let torque = turn.moment_nm(&problem.mesh, &Point3::new(6.0, 0.0, 0.0))?.x;
            let solution = problem.solve(&turn.scaled(1.0 / torque))?;
            // the rotation of a section from its upper and lower edge
            let rotation = |x: f64| -> Result<f64, VerifyError> {
                let [low, high] = [-0.1, 0.1].map(|y| solution.displacement([x, y, -0.05]));
                Ok((high?.z - low?.z) / 0.2)
            };
            let value = 3.0 * (rotation(4.0)? - rotation(2.0)?);
            Ok(solution.measured(value, cells(n), 1.0 / n[0] as f64))
        }),
    }
}

const CURVED: &str = "mean displacement of the free end along a unit force, 90° arc, radii 4.12 and \
    4.32, thickness 0.1, E = 1e7, ν = 0.25";

fn curved(level: usize) -> Result<([usize; 3], Problem), VerifyError> {
    let n = [[2, 24, 2], [4, 48, 4], [6, 72, 6]][level];
    let mesh = Blocks::new(1e-6)
        .block(n, |p| {
            let (r, phi) = (4.12 + 0.2 * p.x, FRAC_PI_2 * p.y);
            Point3::new(r * phi.cos(), r * phi.sin(), 0.1 * (p.z - 0.5))
        })
        .finish()?;
    Ok((n, Problem::new(mesh, 1e7, 0.25)?))
}

fn curved_in_plane() -> Case {
    let (a, b) = (4.12_f64, 4.32_f64);
    let n = a * a - b * b + (a * a + b * b) * (b / a).ln();
    Case {
        id: "solid.curved.in_plane",
        title: "Curved beam, in-plane shear",
        element: "TET10",
        quantity: CURVED,
        unit: "in",
        reference: Reference::Exact(PI * (a * a + b * b) / (1e7 * 0.1 * n)),
        source: "Golovin's curved bar, δ = π P (a² + b²) / (E t N) with N = a² − b² + (a² + b²) ln(b/a), \
            Timoshenko and Goodier, 3rd ed., article 33. MacNeal and Harder print 0.08734, 1.4 % less",
        target: Target::within(0.01),
        n_levels: 3,
        known_miss: None,
        run: Box::new(|level| {
            let (n, problem) = curved(level)?;
            // the section at y = 0 stays plane and free to slide; its mid node is held
            let problem = problem.hold(1, |p| same(p.y, 0.0));
            let middle = nodes_where(&problem.mesh, |p| {
                same(p.y, 0.0) && same(p.z, -0.05) && same(p.x, 4.12)
            });
            let plane = nodes_where(&problem.mesh, |p| same(p.y, 0.0) && same(p.z, -0.05));
            let problem = problem.hold_nodes(0, middle).hold_nodes(2, plane);
            tip_displacement(&problem, Vector3::y(), |p| p.x.abs() < 1e-9, n)
        }),
    }
}

fn curved_out_of_plane() -> Case {
    Case {
        id: "solid.curved.out_of_plane",
        title: "Curved beam, out-of-plane shear",
        element: "TET10",
        quantity: CURVED,
        unit: "in",
        reference: Reference::Published(0.5022),
        source: "MacNeal and Harder, 1985, as quoted by the MIDAS/Gen verification manual, example 17; thin curved-beam theory with Saint-Venant torsion gives 0.5003",
        target: Target::within(0.01),
        n_levels: 3,
        known_miss: None,
        run: Box::new(|level| {
            let (n, problem) = curved(level)?;
            let problem = problem.clamp(|p| same(p.y, 0.0));
            tip_displacement(&problem, Vector3::z(), |p| p.x.abs() < 1e-9, n)
        }),
    }
}

fn twisted(id: &'static str, title: &'static str, axis: usize, reference: f64) -> Case {
    Case {
        id,
        title,
        element: "TET10",
        quantity: "mean displacement of the tip face along a unit force, L = 12, 1.1 × 0.32, twist 90°, E = 29e6, ν = 0.22",
        unit: "in",
        reference: Reference::Published(reference),
        source: "MacNeal and Harder, 1985, as quoted by Altair OptiStruct OS-V:0700",
        target: Target::within(0.01),
        n_levels: 3,
        known_miss: None,
        run: Box::new(move |level| {
            let n = [[12, 2, 1], [24, 4, 2], [48, 8, 4]][level];
            // at the root the width lies along y, at the tip along z
            let mesh = Blocks::new(1e-6)
                .block(n, |p| {
                    let (y, z, phi) = (1.1 * (p.y - 0.5), 0.32 * (p.z - 0.5), FRAC_PI_2 * p.x);
                    let (s, c) = phi.sin_cos();
                    Point3::new(12.0 * p.x, y * c - z * s, y * s + z * c)
                })
                .finish()?;
            let problem = Problem::new(mesh, 29e6, 0.22)?.clamp(|p| same(p.x, 0.0));
            let direction = Vector3::from_fn(|i, _| f64::from(u8::from(i == axis)));
            tip_displacement(&problem, direction, |p| same(p.x, 12.0), n)
        }),
    }
}
