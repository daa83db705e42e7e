//! MacNeal and Harder's beams, as solids and as shells.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Point3;

use super::prelude::*;

/// Name, title, axis of the force and of what is read, and the published value.
type Pulled = (&'static str, &'static str, usize, f64);

const STRAIGHT: &[Pulled] = &[
    ("straight.extension", "Straight cantilever, extension", 0, 3e-5),
    ("straight.in_plane", "Straight cantilever, in-plane shear", 1, 0.1081),
    ("straight.out_of_plane", "Straight cantilever, out-of-plane shear", 2, 0.4321),
];
const TWISTED: &[Pulled] = &[
    ("twisted.in_plane", "Twisted beam, in-plane shear", 2, 5.424e-3),
    ("twisted.out_of_plane", "Twisted beam, out-of-plane shear", 1, 1.754e-3),
];
const TWISTED_THIN: &[Pulled] = &[
    ("twisted_thin.in_plane", "Thin twisted beam, in-plane shear", 2, 5.256e-3),
    ("twisted_thin.out_of_plane", "Thin twisted beam, out-of-plane shear", 1, 1.294e-3),
];

const STRAIGHT_SOURCE: &str = "MacNeal and Harder, A proposed standard set of problems to test finite \
    element accuracy, Finite Elem. Anal. Des. 1, 1985, table 3 (value from memory); it agrees with \
    the Timoshenko beam";
const TWISTED_SOURCE: &str = "MacNeal and Harder, 1985, as quoted by Altair OptiStruct OS-V:0700";

/// A case for each row, `base` in all else; the model follows from the axis.
fn pulled(rows: &[Pulled], base: &Case, models: fn(usize) -> Vec<Model>) -> Vec<Case> {
    let case = |&(name, title, axis, value): &Pulled| Case {
        name,
        title,
        unit: "in",
        reference: Reference::Published(value),
        solve: Solve::Models(models(axis)),
        ..base.clone()
    };
    rows.iter().map(case).collect()
}

/// Rows of solids: a force or torque at the end, and the motion along it.
pub(super) fn solids() -> Vec<Case> {
    let base = Case {
        quantity: "mean displacement of the tip face along a unit force, L = 6, 0.2 × 0.1, E = 1e7, ν = 0.3",
        source: STRAIGHT_SOURCE,
        meshes: &[[15, 1, 1], [30, 2, 2], [60, 4, 4]],
        ..Case::default()
    };
    let mut cases = pulled(STRAIGHT, &base, |axis| {
        vec![Model { load: Load::Total(X(6.0), axis, 1.0), ..STRAIGHT_SOLID }]
    });
    cases.push(Case {
        name: "straight.twist",
        title: "Straight cantilever, twist",
        quantity: "twist between x = 2 and x = 4 times 3 under a unit torque, sections free to warp",
        unit: "rad",
        reference: Reference::Exact(6.0 / (1e7 / 2.6 * torsion_constant(0.1, 0.05))),
        source: "Saint-Venant torsion of a rectangle, Timoshenko and Goodier, 3rd ed., article 109, \
            eq. 160. MacNeal and Harder print 0.03208 (value from memory), 6 % less than Saint-Venant",
        solve: Solve::of(Model {
            load: Load::Torque(X(6.0), [6.0, 0.0, 0.0]),
            probe: Probe::Value(|s| Ok(3.0 * (rotation(s, 4.0)? - rotation(s, 2.0)?))),
            ..STRAIGHT_SOLID
        }),
        ..base
    });
    let curved = Case {
        quantity: "mean displacement of the free end along a unit force, 90° arc, radii 4.12 and \
            4.32, thickness 0.1, E = 1e7, ν = 0.25",
        unit: "in",
        meshes: &[[2, 24, 2], [4, 48, 4], [6, 72, 6]],
        ..Case::default()
    };
    cases.push(Case {
        name: "curved.in_plane",
        title: "Curved beam, in-plane shear",
        reference: Reference::Exact(ring_tip()),
        source: "Golovin's curved bar, δ = π P (a² + b²) / (E t N) with N = a² − b² + (a² + b²) ln(b/a), \
            Timoshenko and Goodier, 3rd ed., article 33. MacNeal and Harder print 0.08734, 1.4 % less",
        solve: Solve::of(Model {
            supports: PLANE_SECTION,
            load: Load::Total(X(0.0), 1, 1.0),
            ..RING_SOLID
        }),
        ..curved.clone()
    });
    cases.push(Case {
        name: "curved.out_of_plane",
        title: "Curved beam, out-of-plane shear",
        reference: Reference::Published(0.5022),
        source: "MacNeal and Harder, 1985, as quoted by the MIDAS/Gen verification manual, example 17; thin \
            curved-beam theory with Saint-Venant torsion gives 0.5003",
        solve: Solve::of(RING_SOLID),
        ..curved
    });
    let base = Case {
        quantity: "mean displacement of the tip face along a unit force, L = 12, 1.1 × 0.32, twist 90°, E = \
            29e6, ν = 0.22",
        source: TWISTED_SOURCE,
        meshes: &[[12, 2, 1], [24, 4, 2], [48, 8, 4]],
        ..Case::default()
    };
    cases.extend(pulled(TWISTED, &base, |axis| {
        vec![Model { load: Load::Total(X(12.0), axis, 1.0), ..TWISTED_SOLID }]
    }));
    cases
}

const CLAMPED_START: &[(Held, On)] = &[(All, X(0.0))];

const STRAIGHT_SOLID: Model = Model {
    mesh: Mesh::Block(|p| Point3::new(6.0 * p.x, 0.2 * (p.y - 0.5), 0.1 * (p.z - 0.5))),
    material: [1e7, 0.3],
    supports: CLAMPED_START,
    load: Load::All(&[]),
    probe: Probe::Work(1.0),
};

/// Torsion constant of a rectangle with half sides a ≥ b:
/// J = 16 a b³ (1/3 − 64/π⁵ b/a Σ tanh(nπa/2b)/n⁵), n odd
/// (Timoshenko and Goodier, Theory of Elasticity, 3rd ed., article 109, eq. 160).
fn torsion_constant(a: f64, b: f64) -> f64 {
    let term = |n: f64| (n * PI * a / (2.0 * b)).tanh() / n.powi(5);
    let sum: f64 = (0..20).map(|i| term(f64::from(2 * i + 1))).sum();
    16.0 * a * b.powi(3) * (1.0 / 3.0 - 64.0 / PI.powi(5) * b / a * sum)
}

/// The rotation of a section from its upper and lower edge.
fn rotation(s: &Solution, x: f64) -> Result<f64, VerifyError> {
    let [low, high] = [-0.1, 0.1].map(|y| s.u(Place::At([x, y, -0.05]), 2));
    Ok((high? - low?) / 0.2)
}

/// Golovin's quarter ring: π P (a² + b²) / (E t N), N = (a² + b²) ln(b/a) − (b² − a²).
fn ring_tip() -> f64 {
    let (a, b) = (4.12_f64, 4.32_f64);
    let (sum, difference) = (a * a + b * b, b * b - a * a);
    PI * sum / (1e7 * 0.1 * (sum * (b / a).ln() - difference))
}

/// A quarter ring from (r, 0) to (0, r), pulled along z.
const RING_SOLID: Model = Model {
    mesh: Mesh::Block(|p| {
        let (r, phi) = (4.12 + 0.2 * p.x, FRAC_PI_2 * p.y);
        Point3::new(r * phi.cos(), r * phi.sin(), 0.1 * (p.z - 0.5))
    }),
    material: [1e7, 0.25],
    supports: &[(All, Y(0.0))],
    load: Load::Total(X(0.0), 2, 1.0),
    probe: Probe::Work(1.0),
};

/// The section at y = 0 stays plane and free to slide; its mid node is held.
const PLANE_SECTION: &[(Held, On)] = &[
    (Only(&[1]), Y(0.0)),
    (Only(&[0]), Where(|p| same(p.y, 0.0) && same(p.z, -0.05) && same(p.x, 4.12))),
    (Only(&[2]), Where(|p| same(p.y, 0.0) && same(p.z, -0.05))),
];

/// At the root the width lies along y, at the tip along z.
const TWISTED_SOLID: Model = Model {
    mesh: Mesh::Block(|p| {
        let (y, z, (s, c)) = (1.1 * (p.y - 0.5), 0.32 * (p.z - 0.5), (FRAC_PI_2 * p.x).sin_cos());
        Point3::new(12.0 * p.x, y * c - z * s, y * s + z * c)
    }),
    material: [29e6, 0.22],
    ..STRAIGHT_SOLID
};

/// Rows of shells.
pub(super) fn shells() -> Vec<Case> {
    let base = Case {
        quantity: "mean displacement of the tip's corners along a unit force, L = 6, 0.2 × 0.1, E = 1e7, \
            ν = 0.3; the worst of rectangles, trapezoids and parallelograms",
        source: STRAIGHT_SOURCE,
        meshes: FINER,
        ..Case::default()
    };
    let mut cases = both(pulled(STRAIGHT, &base, |axis| {
        let (load, probe) = (Load::Total(X(6.0), axis, 1.0), Probe::Mean(CORNERS, axis));
        SHAPES.map(|mesh| Model { mesh, load, probe, ..STRAIGHT_SHELL }).to_vec()
    }));
    cases.push(Case {
        name: "straight.twist",
        element: Element::ThickShell,
        title: "Straight cantilever, twist",
        quantity: "twist of the tip under a unit couple at its corners",
        unit: "rad",
        reference: Reference::Exact(6.0 / (1e7 / 2.6 * TORSION)),
        source: "Saint-Venant torsion of a rectangle, T L / (G J) with J = 0.2287 a b³, Timoshenko and \
            Goodier, 3rd ed., article 109. MacNeal and Harder print 0.03208 (from memory), 6 % less. \
            Thin shells have no transverse shear, which the torsion of a rectangle of 2 : 1 needs",
        solve: Solve::of(STRAIGHT_SHELL),
        ..base
    });
    let curved = Case {
        quantity: "mean displacement of the free end's corners along a unit force, 90° arc, radii 4.12 and \
            4.32, thickness 0.1, E = 1e7, ν = 0.25",
        unit: "in",
        ..Case::default()
    };
    let in_plane = Case {
        name: "curved.in_plane",
        title: "Curved beam, in-plane shear",
        reference: Reference::Exact(ring_tip()),
        source: "Golovin's curved bar, δ = π P (a² + b²) / (E t N) with N = (a² + b²) ln(b/a) − (b² − a²), \
            Timoshenko and Goodier, 3rd ed., article 33. MacNeal and Harder print 0.08734, 1.4 % less",
        meshes: COARSER,
        solve: Solve::of(ring_shell(0)),
        ..curved.clone()
    };
    cases.extend(in_plane.both());
    cases.push(Case {
        name: "curved.out_of_plane",
        element: Element::ThickShell,
        title: "Curved beam, out-of-plane shear",
        reference: Reference::Exact(ring_lift()),
        source: "curved-beam theory with Saint-Venant torsion and shear, Roark's Formulas, 7th ed., table 9.4. \
            MacNeal and Harder print 0.5022, 0.3 % more. Thin shells miss the torsion, see the twist",
        meshes: FINER,
        solve: Solve::of(ring_shell(2)),
        ..curved
    });
    let thick = Case {
        quantity: "middle of the tip along a unit force, L = 12, 1.1 × 0.32, twist 90°, E = 29e6, ν = 0.22",
        source: TWISTED_SOURCE,
        meshes: COARSER,
        ..Case::default()
    };
    let thin = Case {
        quantity: "middle of the tip along a force of 1e-6, L = 12, 1.1 × 0.0032, twist 90°, E = 29e6, ν = \
            0.22",
        source: "Belytschko, Wong and Stolarski, Int. J. Numer. Methods Eng. 28, 1989 (from memory)",
        ..thick.clone()
    };
    cases.extend(both(pulled(TWISTED, &thick, |axis| vec![twisted_shell(0.32, axis, 1.0)])));
    cases.extend(both(pulled(TWISTED_THIN, &thin, |axis| vec![twisted_shell(0.0032, axis, 1e-6)])));
    cases
}

fn both(cases: Vec<Case>) -> Vec<Case> {
    cases.into_iter().flat_map(Case::both).collect()
}

const COARSER: &[[usize; 3]] = &[[24, 4, 1], [48, 8, 1], [96, 16, 1]];
const FINER: &[[usize; 3]] = &[[48, 8, 1], [96, 16, 1], [192, 32, 1]];

/// The free end's corners.
const CORNERS: [Place; 2] = [Place::Grid(1.0, 0.0), Place::Grid(1.0, 1.0)];

/// The cantilever of 6 × 0.2 × 0.1 in MacNeal and Harder's rectangles, trapezoids and parallelograms
/// (1985, figure 3): offsets of their corners in units of the width, at station and side.
const SHAPES: [Mesh; 3] = [
    Mesh::Grid(0.1, Pattern::ALL, |p| straight(p, |_, _| 0.0)),
    Mesh::Grid(0.1, Pattern::ALL, |p| {
        straight(p, |i, j| if (i + j).is_multiple_of(2) { 0.5 } else { -0.5 })
    }),
    Mesh::Grid(0.1, Pattern::ALL, |p| straight(p, |_, j| if j == 1 { 0.5 } else { -0.5 })),
];

fn straight(p: Point3<f64>, shape: fn(usize, usize) -> f64) -> Point3<f64> {
    // offsets at the six coarse stations, linear in between
    let s = p.x * 6.0;
    let i = (s.floor() as usize).min(5);
    let f = s - i as f64;
    let at = |i: usize| match i {
        0 | 6 => 0.0,
        _ => shape(i, 0) * (1.0 - p.y) + shape(i, 1) * p.y,
    };
    let shift = (at(i) * (1.0 - f) + at(i + 1) * f) * 0.2;
    Point3::new(s + shift, 0.2 * (p.y - 0.5), 0.0)
}

/// Twisted by a unit couple.
const STRAIGHT_SHELL: Model = Model {
    mesh: SHAPES[0],
    material: [1e7, 0.3],
    supports: CLAMPED_START,
    load: Load::All(&[Load::Node(CORNERS[0], 2, -5.0), Load::Node(CORNERS[1], 2, 5.0)]),
    probe: Probe::Value(|s| Ok((s.u(CORNERS[1], 2)? - s.u(CORNERS[0], 2)?) / 0.2)),
};

/// J of a rectangle of 0.2 × 0.1: 0.2287 a b³ (Timoshenko and Goodier, Theory of Elasticity, 3rd
/// ed., article 109, table for a/b = 2).
const TORSION: f64 = 0.2287 * 0.2 * 1e-3;

/// P R³ (π/4 / (E I) + (3π/4 − 2) / (G J)) + 6/5 P L / (G A).
fn ring_lift() -> f64 {
    let (r, e, g) = (4.22_f64, 1e7, 4e6);
    let second_moment = 0.2 * 1e-3 / 12.0;
    let bending = 0.25 * PI / (e * second_moment) + (0.75 * PI - 2.0) / (g * TORSION);
    r.powi(3) * bending + 1.2 * r * FRAC_PI_2 / (g * 0.02)
}

/// A quarter ring from (0, r) to (r, 0), pulled along an axis (MacNeal and Harder 1985, figure 4).
fn ring_shell(axis: usize) -> Model {
    Model {
        mesh: Mesh::Grid(0.1, Pattern::ALL, |p| {
            let (r, a) = (4.32 - 0.2 * p.y, p.x * FRAC_PI_2);
            Point3::new(r * a.sin(), r * a.cos(), 0.0)
        }),
        material: [1e7, 0.25],
        supports: CLAMPED_START,
        load: Load::Total(Y(0.0), axis, 1.0),
        probe: Probe::Mean(CORNERS, axis),
    }
}

/// Length 12, width 1.1 (MacNeal and Harder 1985, figure 5).
fn twisted_shell(thickness: f64, axis: usize, force: f64) -> Model {
    Model {
        mesh: Mesh::Grid(thickness, Pattern::ALL, |p| {
            let (y, a) = (1.1 * (p.y - 0.5), p.x * FRAC_PI_2);
            Point3::new(12.0 * p.x, y * a.cos(), y * a.sin())
        }),
        material: [29e6, 0.22],
        supports: CLAMPED_START,
        load: Load::Total(X(12.0), axis, force),
        probe: Probe::U(Place::Grid(1.0, 0.5), axis),
    }
}
