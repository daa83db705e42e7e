//! NAFEMS LE1, LE10 and LE11.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use nalgebra::{Point3, Vector3};

use super::prelude::*;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    vec![
        Case {
            name: "le1",
            title: "NAFEMS LE1, elliptic membrane",
            quantity: "σyy at D (2, 0); a slab of thickness 0.1 m for plane stress",
            unit: "MPa",
            reference: Reference::Published(92.7),
            source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE1, as quoted by Altair \
                OptiStruct OS-V:0010 and FeenoX",
            meshes: &[[8, 12, 1], [16, 24, 1], [32, 48, 1]],
            solve: Solve::of(LE1),
            ..Case::default()
        },
        Case {
            name: "le10",
            title: "NAFEMS LE10, thick plate",
            quantity: "σyy at D (2, 0, 0.6) under 1 MPa on the upper face, thickness 0.6 m",
            unit: "MPa",
            reference: Reference::Published(-5.38),
            source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE10, as quoted by Seamplex \
                (Fino, FeenoX) and CoFEA",
            meshes: &[[4, 6, 2], [8, 12, 4], [16, 24, 8]],
            solve: Solve::of(LE10),
            ..Case::default()
        },
        Case {
            name: "le11",
            title: "NAFEMS LE11, cylinder, taper and sphere under temperature",
            quantity: "σzz at A (1, 0, 0) under T = √(x² + y²) + z, a quarter",
            unit: "MPa",
            reference: Reference::Published(-105.0),
            source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE11, as quoted by FinEtools \
                and FeenoX, whose key points are taken; FeenoX prints −105.04",
            meshes: &[[2, 3, 8], [4, 6, 16], [8, 12, 32]],
            solve: Solve::of(LE11),
            ..Case::default()
        },
    ]
}

/// Half of the slab, cut at its plane of symmetry.
const LE1: Model = Model {
    mesh: Mesh::Block(|p| elliptic(p, 0.05)),
    material: [210e9, 0.3],
    supports: &[(Mirror(1), Y(0.0)), (Mirror(0), X(0.0)), (Mirror(2), Z(0.0))],
    load: Load::Traction(Where(on_outer), |_, normal| normal * 10e6),
    probe: Probe::Stress([2.0, 0.0, 0.0], 1, 1),
};

const LE10: Model = Model {
    mesh: Mesh::Block(|p| elliptic(p, 0.6)),
    supports: &[
        (Mirror(1), Y(0.0)),
        (Mirror(0), X(0.0)),
        (Only(&[0, 1]), Where(on_outer)),
        (Only(&[2]), Where(|p| on_outer(p) && same(p.z, 0.3))),
    ],
    load: Load::Traction(Z(0.6), |_, normal| -normal * 1e6),
    probe: Probe::Stress([2.0, 0.0, 0.6], 1, 1),
    ..LE1
};

/// The quarter between the ellipses (2, 1) and (3.25, 2.75), from z = 0 to `height`.
fn elliptic(p: Point3<f64>, height: f64) -> Point3<f64> {
    let (s, c) = (FRAC_PI_2 * p.y).sin_cos();
    let inner = Vector3::new(2.0 * c, s, 0.0);
    let outer = Vector3::new(3.25 * c, 2.75 * s, 0.0);
    clean(Point3::from(inner + (outer - inner) * p.x + Vector3::z() * (height * p.z)))
}

/// cos(π/2) is not quite zero, and nodes are picked by coordinate.
pub(super) fn clean(p: Point3<f64>) -> Point3<f64> {
    p.map(|c| if c.abs() < 1e-12 { 0.0 } else { c })
}

fn on_outer(p: &Point3<f64>) -> bool {
    // a mid-side node lies on the ellipse too
    ((p.x / 3.25).powi(2) + (p.y / 2.75).powi(2) - 1.0).abs() < 1e-9
}

/// Cells through the wall, around, and along the meridian; the meridian's eighths lie between the
/// key points of the original figure.
const LE11: Model = Model {
    mesh: Mesh::Block(|p| {
        let (inner, outer) = meridian(8.0 * p.z);
        let at = [0, 1].map(|i| inner[i] + (outer[i] - inner[i]) * p.x);
        let (s, c) = (FRAC_PI_2 * p.y).sin_cos();
        clean(Point3::new(at[0] * c, at[0] * s, at[1]))
    }),
    material: [210e9, 0.3],
    supports: &[
        (Mirror(1), Y(0.0)),
        (Mirror(0), X(0.0)),
        (Mirror(2), Where(|p| same(p.z, 0.0) || same(p.z, TOP))),
    ],
    load: Load::Thermal(2.3e-4, |p| p.x.hypot(p.y) + p.z),
    probe: Probe::Stress([1.0, 0.0, 0.0], 2, 2),
};

const TOP: f64 = 1.79;

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
