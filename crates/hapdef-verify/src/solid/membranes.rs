//! Plane-stress benchmarks on thin slabs, and the elliptic plate of NAFEMS.
//!
//! A slab's lower face is its plane of symmetry, so that the model is half as thick as the slab;
//! with a traction-free upper face the mean over the thickness is plane stress up to (t/L)².

use std::f64::consts::FRAC_PI_2;

use hapdef_mesh::Tet10Mesh;
use nalgebra::{Point3, Vector3};

use super::problem::{Problem, same};
use super::row::{Load, Probe, Row};
use crate::meshes::Blocks;
use crate::{Case, Reference, VerifyError};

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    [COOK, LE1, LE10].map(Row::case).into()
}

const COOK: Row = Row {
    id: "solid.cook",
    title: "Cook's membrane",
    quantity: "v at (48, 52) under unit shear, E = 1, ν = 1/3; a slab of thickness 1 for plane stress",
    unit: "1",
    reference: Reference::Published(23.96),
    source: "Cook, J. Struct. Div. ASCE 100, 1974; the converged 23.96 at (48, 52) is quoted by many \
        later papers, here from memory",
    cells: [[4, 4, 1], [8, 8, 1], [16, 16, 1]],
    mesh: |n| {
        let trapezium = |p: Point3<f64>| {
            let (low, height) = (44.0 * p.x, 44.0 - 28.0 * p.x);
            Point3::new(48.0 * p.x, low + height * p.y, 0.5 * p.z)
        };
        Blocks::new(1e-6).block(n, trapezium).finish()
    },
    material: [1.0, 1.0 / 3.0],
    // z is free at the wall, as in plane stress
    supports: |problem| {
        problem.hold(0, |p| same(p.x, 0.0)).hold(1, |p| same(p.x, 0.0)).hold(2, |p| same(p.z, 0.0))
    },
    load: Load::Force(|p| same(p.x, 48.0), [0.0, 1.0, 0.0], 0.5),
    probe: Probe::Displacement([48.0, 52.0, 0.0], 1),
    ..Row::EMPTY
};

const LE1: Row = Row {
    id: "solid.le1",
    title: "NAFEMS LE1, elliptic membrane",
    quantity: "σyy at D (2, 0); a slab of thickness 0.1 m for plane stress",
    unit: "MPa",
    reference: Reference::Published(92.7),
    source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE1, as quoted by Altair \
        OptiStruct OS-V:0010 and FeenoX",
    cells: [[8, 12, 1], [16, 24, 1], [32, 48, 1]],
    mesh: |n| elliptic(n, 0.05),
    material: [210e9, 0.3],
    supports: |problem| mirrored(problem).hold(2, |p| same(p.z, 0.0)),
    load: Load::Traction(on_outer, |_, normal| normal * 10e6),
    probe: Probe::Stress([2.0, 0.0, 0.0], 1, 1),
    ..Row::EMPTY
};

const LE10: Row = Row {
    id: "solid.le10",
    title: "NAFEMS LE10, thick plate",
    quantity: "σyy at D (2, 0, 0.6) under 1 MPa on the upper face, thickness 0.6 m",
    unit: "MPa",
    reference: Reference::Published(-5.38),
    source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE10, as quoted by Seamplex \
        (Fino, FeenoX) and CoFEA",
    cells: [[4, 6, 2], [8, 12, 4], [16, 24, 8]],
    mesh: |n| elliptic(n, 0.6),
    material: [210e9, 0.3],
    supports: |problem| {
        mirrored(problem)
            .hold(0, on_outer)
            .hold(1, on_outer)
            .hold(2, |p| on_outer(p) && same(p.z, 0.3))
    },
    load: Load::Traction(|p| same(p.z, 0.6), |_, normal| -normal * 1e6),
    probe: Probe::Stress([2.0, 0.0, 0.6], 1, 1),
    ..Row::EMPTY
};

/// The quarter between the ellipses (2, 1) and (3.25, 2.75), from z = 0 to `height`.
fn elliptic(n: [usize; 3], height: f64) -> Result<Tet10Mesh, VerifyError> {
    Blocks::new(1e-6)
        .block(n, |p| {
            let (s, c) = (FRAC_PI_2 * p.y).sin_cos();
            let inner = Vector3::new(2.0 * c, s, 0.0);
            let outer = Vector3::new(3.25 * c, 2.75 * s, 0.0);
            let at = inner + (outer - inner) * p.x;
            // cos(π/2) is not quite zero, and the symmetry planes are picked by coordinate
            let clean = |v: f64| if v.abs() < 1e-12 { 0.0 } else { v };
            Point3::new(clean(at.x), clean(at.y), height * p.z)
        })
        .finish()
}

fn mirrored(problem: Problem) -> Problem {
    problem.hold(1, |p| same(p.y, 0.0)).hold(0, |p| same(p.x, 0.0))
}

fn on_outer(p: &Point3<f64>) -> bool {
    // a mid-side node lies on the ellipse too
    ((p.x / 3.25).powi(2) + (p.y / 2.75).powi(2) - 1.0).abs() < 1e-9
}
