//! MacNeal and Harder's beams.

use std::f64::consts::{FRAC_PI_2, PI};

use hapdef_mesh::Tet10Mesh;
use nalgebra::Point3;

use super::problem::{Problem, Solution, same};
use super::row::{Load, Probe, Row};
use crate::meshes::{Blocks, nodes_where};
use crate::{Case, Reference, VerifyError};

const STRAIGHT_SOURCE: &str = "MacNeal and Harder, A proposed standard set of problems to test finite \
    element accuracy, Finite Elem. Anal. Des. 1, 1985, table 3 (value from memory); it agrees with \
    the Timoshenko beam";

/// Rows of the table: a force or torque at the end, and the motion along it.
pub(super) fn cases() -> Vec<Case> {
    let mut rows = Vec::new();
    for (id, title, direction, value) in [
        ("solid.straight.extension", "Straight cantilever, extension", X, 3e-5),
        ("solid.straight.in_plane", "Straight cantilever, in-plane shear", Y, 0.1081),
        ("solid.straight.out_of_plane", "Straight cantilever, out-of-plane shear", Z, 0.4321),
    ] {
        let reference = Reference::Published(value);
        let load = Load::Force(|p| same(p.x, 6.0), direction, 1.0);
        rows.push(Row { id, title, reference, load, ..STRAIGHT });
    }
    rows.extend([twist(), curved_in_plane(), CURVED_OUT_OF_PLANE]);
    for (id, title, direction, value) in [
        ("solid.twisted.in_plane", "Twisted beam, in-plane shear", Z, 5.424e-3),
        ("solid.twisted.out_of_plane", "Twisted beam, out-of-plane shear", Y, 1.754e-3),
    ] {
        let reference = Reference::Published(value);
        let load = Load::Force(|p| same(p.x, 12.0), direction, 1.0);
        rows.push(Row { id, title, reference, load, ..TWISTED });
    }
    rows.into_iter().map(Row::case).collect()
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

const STRAIGHT: Row = Row {
    quantity: "mean displacement of the tip face along a unit force, L = 6, 0.2 × 0.1, E = 1e7, ν = 0.3",
    unit: "in",
    source: STRAIGHT_SOURCE,
    cells: [[15, 1, 1], [30, 2, 2], [60, 4, 4]],
    mesh: |n| block(n, |p| Point3::new(6.0 * p.x, 0.2 * (p.y - 0.5), 0.1 * (p.z - 0.5))),
    material: [1e7, 0.3],
    supports: |problem| problem.clamp(|p| same(p.x, 0.0)),
    ..Row::EMPTY
};

fn block(
    n: [usize; 3],
    map: impl Fn(Point3<f64>) -> Point3<f64>,
) -> Result<Tet10Mesh, VerifyError> {
    Blocks::new(1e-6).block(n, map).finish()
}

/// Torsion constant of a rectangle with half sides a ≥ b:
/// J = 16 a b³ (1/3 − 64/π⁵ b/a Σ tanh(nπa/2b)/n⁵), n odd
/// (Timoshenko and Goodier, Theory of Elasticity, 3rd ed., article 109, eq. 160).
fn torsion_constant(a: f64, b: f64) -> f64 {
    let term = |n: f64| (n * PI * a / (2.0 * b)).tanh() / n.powi(5);
    let sum: f64 = (0..20).map(|i| term(f64::from(2 * i + 1))).sum();
    16.0 * a * b.powi(3) * (1.0 / 3.0 - 64.0 / PI.powi(5) * b / a * sum)
}

fn twist() -> Row {
    let shear_modulus = 1e7 / 2.6;
    Row {
        id: "solid.straight.twist",
        title: "Straight cantilever, twist",
        quantity: "twist between x = 2 and x = 4 times 3 under a unit torque, sections free to warp",
        unit: "rad",
        reference: Reference::Exact(6.0 / (shear_modulus * torsion_constant(0.1, 0.05))),
        source: "Saint-Venant torsion of a rectangle, Timoshenko and Goodier, 3rd ed., article 109, \
            eq. 160. MacNeal and Harder print 0.03208 (value from memory), 6 % less than Saint-Venant",
        load: Load::Torque(|p| same(p.x, 6.0), [6.0, 0.0, 0.0]),
        probe: Probe::Value(|solution| {
            Ok(3.0 * (section_rotation(solution, 4.0)? - section_rotation(solution, 2.0)?))
        }),
        ..STRAIGHT
    }
}

/// The rotation of a section from its upper and lower edge.
fn section_rotation(solution: &Solution<'_>, x: f64) -> Result<f64, VerifyError> {
    let [low, high] = [-0.1, 0.1].map(|y| solution.displacement([x, y, -0.05]));
    Ok((high?.z - low?.z) / 0.2)
}

const CURVED: Row = Row {
    quantity: "mean displacement of the free end along a unit force, 90° arc, radii 4.12 and \
        4.32, thickness 0.1, E = 1e7, ν = 0.25",
    unit: "in",
    cells: [[2, 24, 2], [4, 48, 4], [6, 72, 6]],
    mesh: |n| {
        block(n, |p| {
            let (r, phi) = (4.12 + 0.2 * p.x, FRAC_PI_2 * p.y);
            Point3::new(r * phi.cos(), r * phi.sin(), 0.1 * (p.z - 0.5))
        })
    },
    material: [1e7, 0.25],
    ..Row::EMPTY
};

fn curved_in_plane() -> Row {
    let (a, b) = (4.12_f64, 4.32_f64);
    let n = a * a - b * b + (a * a + b * b) * (b / a).ln();
    Row {
        id: "solid.curved.in_plane",
        title: "Curved beam, in-plane shear",
        reference: Reference::Exact(PI * (a * a + b * b) / (1e7 * 0.1 * n)),
        source: "Golovin's curved bar, δ = π P (a² + b²) / (E t N) with N = a² − b² + (a² + b²) ln(b/a), \
            Timoshenko and Goodier, 3rd ed., article 33. MacNeal and Harder print 0.08734, 1.4 % less",
        supports: plane_section,
        load: Load::Force(|p| p.x.abs() < 1e-9, Y, 1.0),
        ..CURVED
    }
}

/// The section at y = 0 stays plane and free to slide; its mid node is held.
fn plane_section(problem: Problem) -> Problem {
    let problem = problem.hold(1, |p| same(p.y, 0.0));
    let plane = |p: &Point3<f64>| same(p.y, 0.0) && same(p.z, -0.05);
    let middle = nodes_where(&problem.mesh, |p| plane(p) && same(p.x, 4.12));
    let plane = nodes_where(&problem.mesh, plane);
    problem.hold_nodes(0, middle).hold_nodes(2, plane)
}

const CURVED_OUT_OF_PLANE: Row = Row {
    id: "solid.curved.out_of_plane",
    title: "Curved beam, out-of-plane shear",
    reference: Reference::Published(0.5022),
    source: "MacNeal and Harder, 1985, as quoted by the MIDAS/Gen verification manual, example 17; thin curved-beam theory with Saint-Venant torsion gives 0.5003",
    supports: |problem| problem.clamp(|p| same(p.y, 0.0)),
    load: Load::Force(|p| p.x.abs() < 1e-9, Z, 1.0),
    ..CURVED
};

const TWISTED: Row = Row {
    quantity: "mean displacement of the tip face along a unit force, L = 12, 1.1 × 0.32, twist 90°, E = 29e6, ν = 0.22",
    unit: "in",
    source: "MacNeal and Harder, 1985, as quoted by Altair OptiStruct OS-V:0700",
    cells: [[12, 2, 1], [24, 4, 2], [48, 8, 4]],
    // at the root the width lies along y, at the tip along z
    mesh: |n| {
        block(n, |p| {
            let (y, z, phi) = (1.1 * (p.y - 0.5), 0.32 * (p.z - 0.5), FRAC_PI_2 * p.x);
            let (s, c) = phi.sin_cos();
            Point3::new(12.0 * p.x, y * c - z * s, y * s + z * c)
        })
    },
    material: [29e6, 0.22],
    supports: |problem| problem.clamp(|p| same(p.x, 0.0)),
    ..Row::EMPTY
};
