//! Beams and strips meshed as shells.

use super::grid::{Grid, cells};
use super::problem::Problem;
use super::{CaseResult, Mesh, Pattern};
use hapdef_sim::ShellKind;
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// The loads of the straight cantilever.
#[derive(Clone, Copy, Debug)]
pub enum Tip {
    Extension,
    InPlane,
    OutOfPlane,
    Twist,
}

/// T L / (G J) with T = 1, L = 6, G = E / 2.6 and J = 0.2287 · 0.2 · 0.1³ (Timoshenko and Goodier,
/// Theory of Elasticity, 3rd ed., section 109, table for b/t = 2), rad. MacNeal and Harder print
/// 0.03208, 6 % below.
const SAINT_VENANT_TWIST: f64 = 6.0 / (1e7 / 2.6 * 0.2287 * 0.2 * 1e-3);

/// The tip of a quarter ring under a radial end force: δ = π P (a² + b²) / (E t ((a² + b²) ln(b/a) −
/// (b² − a²))) with radii a, b (Timoshenko and Goodier, 3rd ed., section 33), m. MacNeal and Harder
/// print 0.08734, 1.4 % below.
fn ring_tip_m() -> f64 {
    let (a, b) = (4.12_f64, 4.32_f64);
    let (sum, difference) = (a * a + b * b, b * b - a * a);
    PI * sum / (1e7 * 0.1 * (sum * (b / a).ln() - difference))
}

/// The tip of a quarter ring under an end force across its plane: P R³ (π/4 / (E I) + (3π/4 − 2) /
/// (G J)) and 6/5 P L / (G A) for shear (Roark's Formulas, 7th ed., table 9.4), m. MacNeal and Harder
/// print 0.5022, 0.3 % above.
fn ring_lift_m() -> f64 {
    let (r, e, g) = (4.22_f64, 1e7, 4e6);
    let (second_moment, torsion) = (0.2 * 1e-3 / 12.0, 0.2287 * 0.2 * 1e-3);
    let bending = 0.25 * PI / (e * second_moment) + (0.75 * PI - 2.0) / (g * torsion);
    r.powi(3) * bending + 1.2 * r * FRAC_PI_2 / (g * 0.02)
}

/// MacNeal and Harder (1985), figure 3: 6 × 0.2 × 0.1, E = 1e7, ν = 0.3, unit tip loads.
/// `slant`: offset of cell corners in units of the width, for trapezoids and parallelograms.
pub fn straight(
    tip: Tip,
    slant: fn(usize, usize) -> f64,
) -> impl Fn(ShellKind, Mesh) -> CaseResult {
    move |kind, mesh| {
        let (nu, nv) = (cells(mesh, 6), mesh.n);
        let shift = |u: f64, v: f64| {
            // offsets at the coarse stations, linear in between
            let s = u * 6.0;
            let i = (s.floor() as usize).min(5);
            let f = s - i as f64;
            let at = |i: usize| {
                if i == 0 || i == 6 {
                    0.0
                } else {
                    slant(i, 0) * (1.0 - v) + slant(i, 1) * v
                }
            };
            (at(i) * (1.0 - f) + at(i + 1) * f) * 0.2
        };
        let grid = Grid::new(nu, nv, mesh.pattern, |u, v| {
            Point3::new(6.0 * u + shift(u, v), 0.2 * (v - 0.5), 0.0)
        });
        let mut p = Problem::new(&grid, 0.1, 1e7, 0.3);
        p.clamp(&grid.side_u(false));
        let end = grid.side_u(true);
        match tip {
            Tip::Extension => p.line_force(&end, 0, 1.0),
            Tip::InPlane => p.line_force(&end, 1, 1.0),
            Tip::OutOfPlane => p.line_force(&end, 2, 1.0),
            Tip::Twist => {
                p.force(end[0], 2, -5.0);
                p.force(end[nv], 2, 5.0);
            }
        }
        let s = p.solve(kind);
        let mean = |dof: usize| 0.5 * (s.displacement[end[0]][dof] + s.displacement[end[nv]][dof]);
        let (value, reference) = match tip {
            Tip::Extension => (mean(0), 3e-5),
            Tip::InPlane => (mean(1), 0.1081),
            Tip::OutOfPlane => (mean(2), 0.4321),
            Tip::Twist => (
                (s.displacement[end[nv]][2] - s.displacement[end[0]][2]) / 0.2,
                SAINT_VENANT_TWIST,
            ),
        };
        CaseResult {
            value,
            reference,
            n_nodes: s.n_nodes,
        }
    }
}

/// MacNeal and Harder (1985), figure 4: a quarter ring, radii 4.12 and 4.32, thickness 0.1,
/// E = 1e7, ν = 0.25.
pub fn curved(out: bool) -> impl Fn(ShellKind, Mesh) -> CaseResult {
    move |kind, mesh| {
        let grid = Grid::new(cells(mesh, 6), mesh.n, mesh.pattern, |u, v| {
            let (r, a) = (4.32 - 0.2 * v, u * FRAC_PI_2);
            Point3::new(r * a.sin(), r * a.cos(), 0.0)
        });
        let mut p = Problem::new(&grid, 0.1, 1e7, 0.25);
        p.clamp(&grid.side_u(false));
        let end = grid.side_u(true);
        let (dof, reference) = if out {
            (2, ring_lift_m())
        } else {
            (0, ring_tip_m())
        };
        p.line_force(&end, dof, 1.0);
        let s = p.solve(kind);
        let value = 0.5 * (s.displacement[end[0]][dof] + s.displacement[end[mesh.n]][dof]);
        CaseResult {
            value,
            reference,
            n_nodes: s.n_nodes,
        }
    }
}

/// MacNeal and Harder (1985), figure 5, and Belytschko (1989) for the thin one: length 12, width
/// 1.1, twist 90°, E = 29e6, ν = 0.22; `out`: along the thickness at the tip.
pub fn twisted(thin: bool, out: bool) -> impl Fn(ShellKind, Mesh) -> CaseResult {
    move |kind, mesh| {
        let grid = Grid::new(cells(mesh, 6), mesh.n, mesh.pattern, |u, v| {
            let (y, a) = (1.1 * (v - 0.5), u * FRAC_PI_2);
            Point3::new(12.0 * u, y * a.cos(), y * a.sin())
        });
        let thickness = if thin { 0.0032 } else { 0.32 };
        let mut p = Problem::new(&grid, thickness, 29e6, 0.22);
        p.clamp(&grid.side_u(false));
        let end = grid.side_u(true);
        // the tip's width lies along z
        let dof = if out { 1 } else { 2 };
        let (load, reference) = match (thin, out) {
            (false, false) => (1.0, 5.424e-3),
            (false, true) => (1.0, 1.754e-3),
            (true, false) => (1e-6, 5.256e-3),
            (true, true) => (1e-6, 1.294e-3),
        };
        p.line_force(&end, dof, load);
        let s = p.solve(kind);
        let mid = end.len() / 2;
        let value = if mesh.n.is_multiple_of(2) {
            s.displacement[end[mid]][dof]
        } else {
            0.5 * (s.displacement[end[mid - 1]][dof] + s.displacement[end[mid]][dof])
        };
        CaseResult {
            value,
            reference,
            n_nodes: s.n_nodes,
        }
    }
}

/// A point of the Raasch hook's middle line at the share `u` of its cells, and the normal there.
pub fn hook_at(u: f64) -> (Point3<f64>, Vector3<f64>) {
    let (r1, r2, bend) = (14.0, 46.0, 60.0_f64.to_radians());
    let (s1, s2) = (r1 * bend, r2 * 150.0_f64.to_radians());
    // 3 of 10 cells on the small arc
    let s = if u <= 0.3 {
        s1 * u / 0.3
    } else {
        s1 + s2 * (u - 0.3) / 0.7
    };
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

/// The Raasch hook (Knight, AIAA J. 35, 1997): radii 14 (60°) and 46 (150°), width 20, thickness 2,
/// E = 3300, ν = 0.35, unit shear along the width at the free end.
pub fn raasch(kind: ShellKind, mesh: Mesh) -> CaseResult {
    let grid = Grid::new(cells(mesh, 10), mesh.n * 2, mesh.pattern, |u, v| {
        hook_at(u).0 + Vector3::z() * (20.0 * v)
    });
    let mut p = Problem::new(&grid, 2.0, 3300.0, 0.35);
    p.clamp(&grid.side_u(false));
    let end = grid.side_u(true);
    p.line_force(&end, 2, 1.0);
    let s = p.solve(kind);
    CaseResult {
        value: s.displacement[end[mesh.n]][2],
        reference: 4.9352,
        n_nodes: s.n_nodes,
    }
}

/// Trapezoids and parallelograms of MacNeal and Harder's straight cantilever.
pub fn rectangle(_: usize, _: usize) -> f64 {
    0.0
}
pub fn trapezoid(i: usize, j: usize) -> f64 {
    if (i + j).is_multiple_of(2) { 0.5 } else { -0.5 }
}
pub fn parallelogram(_: usize, j: usize) -> f64 {
    if j == 1 { 0.5 } else { -0.5 }
}

/// All three patterns of diagonals.
pub const PATTERNS: [Pattern; 3] = [Pattern::Up, Pattern::Down, Pattern::Distorted];
