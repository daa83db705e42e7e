//! NAFEMS LE11: stress from temperature alone.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use hapdef_mesh::Tet10Mesh;
use nalgebra::Point3;

use super::problem::same;
use super::row::{Load, Probe, Row};
use crate::meshes::Blocks;
use crate::{Case, Reference, VerifyError};

const EXPANSION: f64 = 2.3e-4;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let row = Row {
        id: "solid.le11",
        title: "NAFEMS LE11, cylinder, taper and sphere under temperature",
        quantity: "σzz at A (1, 0, 0) under T = √(x² + y²) + z, a quarter",
        unit: "MPa",
        reference: Reference::Published(-105.0),
        source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE11, as quoted by FinEtools \
            and FeenoX, whose key points are taken; FeenoX prints −105.04",
        cells: [1, 2, 4].map(|refine| [2 * refine, 3 * refine, 8 * refine]),
        mesh,
        material: [210e9, 0.3],
        supports: |problem| {
            problem
                .hold(1, |p| same(p.y, 0.0))
                .hold(0, |p| same(p.x, 0.0))
                .hold(2, |p| same(p.z, 0.0) || same(p.z, TOP))
        },
        load: Load::Thermal(EXPANSION, |p| p.x.hypot(p.y) + p.z),
        probe: Probe::Stress([1.0, 0.0, 0.0], 2, 2),
        ..Row::EMPTY
    };
    vec![row.case()]
}

const TOP: f64 = 1.79;

/// Cells through the wall, around, and along the meridian; the meridian's eighths lie between the
/// key points of the original figure.
fn mesh(n: [usize; 3]) -> Result<Tet10Mesh, VerifyError> {
    Blocks::new(1e-7)
        .block(n, |p| {
            let (inner, outer) = meridian(8.0 * p.z);
            let at = [0, 1].map(|i| inner[i] + (outer[i] - inner[i]) * p.x);
            let (s, c) = (FRAC_PI_2 * p.y).sin_cos();
            let clean = |v: f64| if v.abs() < 1e-12 { 0.0 } else { v };
            Point3::new(clean(at[0] * c), clean(at[0] * s), at[1])
        })
        .finish()
}

/// Inner and outer boundary (r, z) at `t` from 0 at the base to 8 at the top.
///
/// Inner: the sphere of radius 1 to 22.5° at t = 3 and 45° at t = 5, then the cylinder to the top.
/// Outer: the sphere of radius 1.4 to 30° at t = 3, the taper to r = 1 at t = 7 (its middle at
/// t = 5), then the cylinder.
fn meridian(t: f64) -> ([f64; 2], [f64; 2]) {
    let on = |radius: f64, degrees: f64| {
        let (s, c) = degrees.to_radians().sin_cos();
        [radius * c, radius * s]
    };
    let between = |a: [f64; 2], b: [f64; 2], x: f64| [0, 1].map(|i| a[i] + (b[i] - a[i]) * x);
    let neck = [FRAC_1_SQRT_2, FRAC_1_SQRT_2];
    let inner = match t {
        t if t <= 3.0 => on(1.0, 7.5 * t),
        t if t <= 5.0 => on(1.0, 22.5 + 11.25 * (t - 3.0)),
        _ => between(neck, [FRAC_1_SQRT_2, TOP], (t - 5.0) / 3.0),
    };
    let taper = [1.4 * 30.0_f64.to_radians().cos(), 0.7];
    let outer = match t {
        t if t <= 3.0 => on(1.4, 10.0 * t),
        t if t <= 7.0 => between(taper, [1.0, 1.39], (t - 3.0) / 4.0),
        _ => between([1.0, 1.39], [1.0, TOP], t - 7.0),
    };
    (inner, outer)
}
