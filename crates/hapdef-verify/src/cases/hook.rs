//! The Raasch hook.

use nalgebra::{Point3, Vector3};

use super::prelude::*;

/// Rows of the table: the thick kind, since its torsion needs transverse shear.
pub(super) fn cases() -> Vec<Case> {
    vec![
        Case {
            name: "raasch",
            element: Element::ThickShell,
            title: "Raasch hook",
            quantity: "tip displacement under a unit shear along the width, radii 14 (60°) and 46 (150°), width \
                20, thickness 2, E = 3300, ν = 0.35",
            unit: "in",
            reference: Reference::Published(4.9352),
            source: "Knight, The Raasch challenge for shell elements, AIAA J. 35, 1997 (value from memory); \
                sources differ between 4.9 and 5.02",
            target: Target::within(0.02),
            meshes: &[[40, 8, 1], [80, 16, 1], [160, 32, 1]],
            solve: Solve::of(SHELL),
            ..Case::default()
        },
        Case {
            name: "raasch_solid",
            element: Element::ThickShell,
            title: "Raasch hook against the same hook in TET10",
            quantity: "difference of the tip's displacement, relative to the solid's",
            source: "TET10 on 80 × 20 × 1 cells, mean over the loaded face",
            meshes: &[[160, 32, 1]],
            solve: Solve::by(|element, n| {
                let shell = SHELL.measure(element, n, Pattern::Up)?;
                let solid = SOLID.measure(Element::Tet10, [80, 20, 1], Pattern::Up)?;
                Ok(Measured { value: shell.value / solid.value - 1.0, ..shell })
            }),
            ..Case::default()
        },
    ]
}

const SHELL: Model = Model {
    mesh: Mesh::Grid(2.0, Pattern::ALL, |p| hook_at(p.x).0 + Vector3::z() * (20.0 * p.y)),
    material: [3300.0, 0.35],
    supports: START,
    load: Load::Total(Where(at_end), 2, 1.0),
    probe: Probe::U(Place::Grid(1.0, 0.5), 2),
};

/// Read by the mean displacement of its end.
const SOLID: Model = Model {
    mesh: Mesh::Block(|p| {
        let (middle, normal) = hook_at(p.x);
        middle + normal * (1.0 - 2.0 * p.z) + Vector3::z() * (20.0 * p.y)
    }),
    probe: Probe::Work(1.0),
    ..SHELL
};

const START: &[(Held, On)] = &[(All, Where(|p| p.y.abs() < 1e-9 && p.x < 2.0))];

fn at_end(p: &Point3<f64>) -> bool {
    let (end, normal) = hook_at(1.0);
    (p - end).dot(&normal.cross(&Vector3::z())).abs() < 1e-6
}

/// A point of the middle line at the share `u` of its cells, and the normal there.
fn hook_at(u: f64) -> (Point3<f64>, Vector3<f64>) {
    let (r1, r2, bend) = (14.0, 46.0, 60.0_f64.to_radians());
    let (s1, s2) = (r1 * bend, r2 * 150.0_f64.to_radians());
    // 3 of 10 cells on the small arc
    let s = if u <= 0.3 { s1 * u / 0.3 } else { s1 + s2 * (u - 0.3) / 0.7 };
    if s <= s1 {
        let (sin, cos) = (s / r1).sin_cos();
        let middle = Point3::new(r1 * (1.0 - cos), r1 * sin, 0.0);
        (middle, Vector3::new(-cos, sin, 0.0))
    } else {
        let centre = Point3::new(r1 - (r1 + r2) * bend.cos(), (r1 + r2) * bend.sin(), 0.0);
        let (sin, cos) = (bend - (s - s1) / r2).sin_cos();
        let out = Vector3::new(cos, -sin, 0.0);
        (centre + out * r2, -out)
    }
}
