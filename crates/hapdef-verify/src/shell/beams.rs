//! MacNeal and Harder's beams, meshed as shells.

use std::f64::consts::{FRAC_PI_2, PI};
use std::rc::Rc;

use hapdef_sim::ShellKind;
use nalgebra::Point3;

use super::benchmark::{Benchmark, ids};
use super::grid::{Grid, Mesh, Pattern};
use super::model::{Load, Model, Probe, clamped_start};
use super::problem::{Problem, Solution};
use crate::{Case, Measured, Reference, Target, VerifyError};

const SOURCE: &str = "MacNeal and Harder, A proposed standard set of problems to test finite element \
    accuracy, Finite Elem. Anal. Des. 1, 1985, table 3 (value from memory); it agrees with the \
    Timoshenko beam";

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let straight = [
        (ids!("straight.extension"), "Straight cantilever, extension", 0, 3e-5),
        (ids!("straight.in_plane"), "Straight cantilever, in-plane shear", 1, 0.1081),
        (ids!("straight.out_of_plane"), "Straight cantilever, out-of-plane shear", 2, 0.4321),
    ];
    let mut cases = Vec::new();
    for (ids, title, axis, tip) in straight {
        let solve = move |kind, mesh| worst_cell(kind, mesh, axis, tip);
        let quantity = "mean displacement of the tip's corners along a unit force, L = 6, 0.2 × 0.1, E = 1e7, \
            ν = 0.3; the worst of rectangles, trapezoids and parallelograms";
        let reference = Reference::Published(tip);
        let case = beam(ids, title, quantity, reference, SOURCE, &[8, 16, 32]);
        cases.extend(case(Rc::new(solve)).both());
    }
    cases.push(twist());
    cases.extend(curved());
    cases.extend(twisted());
    cases
}

/// A benchmark of beams: in inches, within one percent, on all patterns.
fn beam(
    ids: [&'static str; 2],
    title: &'static str,
    quantity: &'static str,
    reference: Reference,
    source: &'static str,
    n: &'static [usize],
) -> impl FnOnce(super::benchmark::Solve) -> Benchmark {
    move |solve| Benchmark {
        ids,
        title,
        quantity,
        unit: "in",
        reference,
        source,
        target: Target::within(0.01),
        n,
        patterns: &Pattern::ALL,
        solve,
    }
}

/// Offsets of MacNeal and Harder's cell corners in units of the width, at station and side.
const SHAPES: [fn(usize, usize) -> f64; 3] = [
    |_, _| 0.0,
    |i, j| if (i + j).is_multiple_of(2) { 0.5 } else { -0.5 },
    |_, j| if j == 1 { 0.5 } else { -0.5 },
];

/// The shape of cells furthest from `reference`.
fn worst_cell(
    kind: ShellKind,
    mesh: Mesh,
    axis: usize,
    reference: f64,
) -> Result<Measured, VerifyError> {
    let mut worst: Option<Measured> = None;
    for shape in SHAPES {
        let (grid, mut p) = straight(mesh, shape)?;
        let end = grid.side_u(true);
        p.line_load(&end, axis, 1.0);
        let found = at_ends(&p.solve(kind)?, &grid, axis);
        let apart = |m: &Measured| (m.value - reference).abs();
        if worst.as_ref().is_none_or(|w| apart(&found) > apart(w)) {
            worst = Some(found);
        }
    }
    worst.ok_or_else(|| VerifyError::not_run("no shape of cells"))
}

/// The mean displacement of the end's two corners along an axis.
fn at_ends(s: &Solution, grid: &Grid, axis: usize) -> Measured {
    let end = grid.side_u(true);
    let value = 0.5 * (s.u(end[0], axis) + s.u(end[grid.nv], axis));
    s.measured(value, grid.cells(), 1.0 / grid.nv as f64)
}

/// The cantilever of 6 × 0.2 × 0.1, clamped at x = 0 (MacNeal and Harder 1985, figure 3).
fn straight(mesh: Mesh, shape: fn(usize, usize) -> f64) -> Result<(Grid, Problem), VerifyError> {
    let shift = |u: f64, v: f64| {
        // offsets at the six coarse stations, linear in between
        let s = u * 6.0;
        let i = (s.floor() as usize).min(5);
        let f = s - i as f64;
        let at = |i: usize| {
            if i == 0 || i == 6 { 0.0 } else { shape(i, 0) * (1.0 - v) + shape(i, 1) * v }
        };
        (at(i) * (1.0 - f) + at(i + 1) * f) * 0.2
    };
    let grid = Grid::new(6 * mesh.n, mesh.n, mesh.pattern, |u, v| {
        Point3::new(6.0 * u + shift(u, v), 0.2 * (v - 0.5), 0.0)
    });
    let mut p = Problem::new(&grid, 0.1, 1e7, 0.3)?;
    p.clamp(&grid.side_u(false));
    Ok((grid, p))
}

/// J of a rectangle of 0.2 × 0.1: 0.2287 a b³ (Timoshenko and Goodier, Theory of Elasticity, 3rd
/// ed., article 109, table for a/b = 2).
const TORSION: f64 = 0.2287 * 0.2 * 1e-3;

fn twist() -> Case {
    let solve = |kind, mesh: Mesh| {
        let (grid, mut p) = straight(mesh, SHAPES[0])?;
        let end = grid.side_u(true);
        p.force(end[0], 2, -5.0);
        p.force(end[grid.nv], 2, 5.0);
        let s = p.solve(kind)?;
        let value = (s.u(end[grid.nv], 2) - s.u(end[0], 2)) / 0.2;
        Ok(s.measured(value, grid.cells(), 1.0 / grid.nv as f64))
    };
    let case = beam(
        ids!("straight.twist"),
        "Straight cantilever, twist",
        "twist of the tip under a unit couple at its corners",
        Reference::Exact(6.0 / (1e7 / 2.6 * TORSION)),
        "Saint-Venant torsion of a rectangle, T L / (G J) with J = 0.2287 a b³, Timoshenko and \
            Goodier, 3rd ed., article 109. MacNeal and Harder print 0.03208 (from memory), 6 % less. \
            Thin shells have no transverse shear, which the torsion of a rectangle of 2 : 1 needs",
        &[8, 16, 32],
    );
    let benchmark = Benchmark { unit: "rad", ..case(Rc::new(solve)) };
    benchmark.case(ShellKind::Thick)
}

/// Golovin's quarter ring: π P (a² + b²) / (E t N), N = (a² + b²) ln(b/a) − (b² − a²).
fn ring_tip() -> f64 {
    let (a, b) = (4.12_f64, 4.32_f64);
    let (sum, difference) = (a * a + b * b, b * b - a * a);
    PI * sum / (1e7 * 0.1 * (sum * (b / a).ln() - difference))
}

/// P R³ (π/4 / (E I) + (3π/4 − 2) / (G J)) + 6/5 P L / (G A).
fn ring_lift() -> f64 {
    let (r, e, g) = (4.22_f64, 1e7, 4e6);
    let second_moment = 0.2 * 1e-3 / 12.0;
    let bending = 0.25 * PI / (e * second_moment) + (0.75 * PI - 2.0) / (g * TORSION);
    r.powi(3) * bending + 1.2 * r * FRAC_PI_2 / (g * 0.02)
}

/// A quarter ring, radii 4.12 and 4.32, thickness 0.1 (MacNeal and Harder 1985, figure 4).
fn ring(axis: usize) -> Model {
    Model {
        grid: |mesh| {
            Grid::new(6 * mesh.n, mesh.n, mesh.pattern, |u, v| {
                let (r, a) = (4.32 - 0.2 * v, u * FRAC_PI_2);
                Point3::new(r * a.sin(), r * a.cos(), 0.0)
            })
        },
        thickness: 0.1,
        material: [1e7, 0.25],
        supports: clamped_start,
        load: Load::End(axis, 1.0),
        probe: Probe::EndCorners(axis),
    }
}

fn curved() -> Vec<Case> {
    let quantity = "mean displacement of the free end's corners along a unit force, 90° arc, radii 4.12 and \
        4.32, thickness 0.1, E = 1e7, ν = 0.25";
    let in_plane = beam(
        ids!("curved.in_plane"),
        "Curved beam, in-plane shear",
        quantity,
        Reference::Exact(ring_tip()),
        "Golovin's curved bar, δ = π P (a² + b²) / (E t N) with N = (a² + b²) ln(b/a) − (b² − a²), \
            Timoshenko and Goodier, 3rd ed., article 33. MacNeal and Harder print 0.08734, 1.4 % less",
        &[4, 8, 16],
    );
    let out_of_plane = beam(
        ids!("curved.out_of_plane"),
        "Curved beam, out-of-plane shear",
        quantity,
        Reference::Exact(ring_lift()),
        "curved-beam theory with Saint-Venant torsion and shear, Roark's Formulas, 7th ed., table 9.4. \
            MacNeal and Harder print 0.5022, 0.3 % more. Thin shells miss the torsion, see the twist",
        &[8, 16, 32],
    );
    let mut cases = in_plane(ring(0).solve()).both();
    let out_of_plane = out_of_plane(ring(2).solve());
    cases.push(out_of_plane.case(ShellKind::Thick));
    cases
}

/// Length 12, width 1.1, twist 90° (MacNeal and Harder 1985, figure 5); the tip's width lies along z.
fn twist_90(thickness: f64, axis: usize) -> Model {
    Model {
        grid: |mesh| {
            Grid::new(6 * mesh.n, mesh.n, mesh.pattern, |u, v| {
                let (y, a) = (1.1 * (v - 0.5), u * FRAC_PI_2);
                Point3::new(12.0 * u, y * a.cos(), y * a.sin())
            })
        },
        thickness,
        material: [29e6, 0.22],
        supports: clamped_start,
        load: Load::End(axis, if thickness < 0.1 { 1e-6 } else { 1.0 }),
        probe: Probe::EndMiddle(axis),
    }
}

fn twisted() -> Vec<Case> {
    let thick =
        "middle of the tip along a unit force, L = 12, 1.1 × 0.32, twist 90°, E = 29e6, ν = 0.22";
    let thin = "middle of the tip along a force of 1e-6, L = 12, 1.1 × 0.0032, twist 90°, E = 29e6, ν = 0.22";
    let published = "MacNeal and Harder, 1985, as quoted by Altair OptiStruct OS-V:0700";
    let later =
        "Belytschko, Wong and Stolarski, Int. J. Numer. Methods Eng. 28, 1989 (from memory)";
    let rows = [
        (
            ids!("twisted.in_plane"),
            "Twisted beam, in-plane shear",
            (thick, published),
            (0.32, 2, 5.424e-3),
        ),
        (
            ids!("twisted.out_of_plane"),
            "Twisted beam, out-of-plane shear",
            (thick, published),
            (0.32, 1, 1.754e-3),
        ),
        (
            ids!("twisted_thin.in_plane"),
            "Thin twisted beam, in-plane shear",
            (thin, later),
            (0.0032, 2, 5.256e-3),
        ),
        (
            ids!("twisted_thin.out_of_plane"),
            "Thin twisted beam, out-of-plane shear",
            (thin, later),
            (0.0032, 1, 1.294e-3),
        ),
    ];
    let cases = rows.into_iter().flat_map(|(ids, title, (quantity, source), row)| {
        let (thickness, axis, tip) = row;
        let reference = Reference::Published(tip);
        beam(ids, title, quantity, reference, source, &[4, 8, 16])(
            twist_90(thickness, axis).solve(),
        )
        .both()
    });
    cases.collect()
}
