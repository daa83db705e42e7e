//! The Raasch hook.

use std::rc::Rc;

use hapdef_sim::ShellKind;
use nalgebra::{Point3, Vector3};

use super::benchmark::{Benchmark, ids};
use super::grid::{Grid, Mesh, Pattern};
use super::problem::Problem;
use crate::meshes::{Blocks, faces_where};
use crate::solid::problem::Problem as SolidProblem;
use crate::{Case, Measured, Reference, Target, VerifyError};

/// Rows of the table: the thick kind, since its torsion needs transverse shear.
pub(super) fn cases() -> Vec<Case> {
    let published = Benchmark {
        ids: ids!("raasch"),
        title: "Raasch hook",
        quantity: "tip displacement under a unit shear along the width, radii 14 (60°) and 46 (150°), width \
            20, thickness 2, E = 3300, ν = 0.35",
        unit: "in",
        reference: Reference::Published(4.9352),
        source: "Knight, The Raasch challenge for shell elements, AIAA J. 35, 1997 (value from memory); \
            sources differ between 4.9 and 5.02",
        target: Target::within(0.02),
        n: &[4, 8, 16],
        patterns: &Pattern::ALL,
        solve: Rc::new(hook),
    };
    let to_solid = Benchmark {
        ids: ids!("raasch_solid"),
        title: "Raasch hook against the same hook in TET10",
        quantity: "difference of the tip's displacement, relative to the solid's",
        unit: "1",
        reference: Reference::Zero,
        source: "TET10 on 80 × 20 × 1 cells, mean over the loaded face",
        target: Target::within(0.01),
        n: &[16],
        solve: Rc::new(|kind, mesh| {
            let shell = hook(kind, mesh)?;
            let value = shell.value / as_a_solid([80, 20, 1])? - 1.0;
            Ok(Measured { value, ..shell })
        }),
        patterns: &[Pattern::Up],
    };
    vec![published.case(ShellKind::Thick), to_solid.case(ShellKind::Thick)]
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

fn hook(kind: ShellKind, mesh: Mesh) -> Result<Measured, VerifyError> {
    let grid = Grid::new(10 * mesh.n, 2 * mesh.n, mesh.pattern, |u, v| {
        hook_at(u).0 + Vector3::z() * (20.0 * v)
    });
    let mut p = Problem::new(&grid, 2.0, 3300.0, 0.35)?;
    p.clamp(&grid.side_u(false));
    let end = grid.side_u(true);
    p.line_load(&end, 2, 1.0);
    let s = p.solve(kind)?;
    Ok(s.measured(s.u(end[mesh.n], 2), grid.cells(), 1.0 / mesh.n as f64))
}

/// The mean tip displacement of the hook in ten-node tetrahedra, `n` cells along, across, through.
fn as_a_solid(n: [usize; 3]) -> Result<f64, VerifyError> {
    let mesh = Blocks::new(1e-6).block(n, |p| {
        let (middle, normal) = hook_at(p.x);
        middle + normal * (1.0 - 2.0 * p.z) + Vector3::z() * (20.0 * p.y)
    });
    let problem = SolidProblem::new(mesh.finish()?, 3300.0, 0.35)?;
    let problem = problem.clamp(|p| p.y.abs() < 1e-9 && p.x < 2.0);
    let (end, normal) = hook_at(1.0);
    let along = normal.cross(&Vector3::z());
    let faces = faces_where(&problem.mesh, |p| (p - end).dot(&along).abs() < 1e-6);
    let load = problem.traction(&faces, |_, _| Vector3::z() / 40.0);
    Ok(load.work_j(&problem.solve(&load)?.u)?)
}
