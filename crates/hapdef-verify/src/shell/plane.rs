//! Cook's membrane with the shell's membrane.

use std::rc::Rc;

use nalgebra::Point3;

use super::benchmark::{Benchmark, ids};
use super::grid::{Grid, Mesh, Pattern};
use super::problem::Problem;
use crate::{Case, Reference, Target};

/// Rows of the table; both kinds have one membrane.
pub(super) fn cases() -> Vec<Case> {
    let cook = Benchmark {
        ids: ids!("cook"),
        title: "Cook's membrane",
        quantity: "v at (48, 52) under unit shear, E = 1, ν = 1/3, thickness 1",
        unit: "1",
        reference: Reference::Published(23.96),
        source: "Cook, J. Struct. Div. ASCE 100, 1974; the converged 23.96 at (48, 52) is quoted by many \
            later papers, here from memory",
        target: Target::within(0.01),
        n: &[8, 16, 32],
        patterns: &Pattern::ALL,
        solve: Rc::new(|kind, mesh: Mesh| {
            let n = mesh.n;
            let grid = Grid::new(n, n, mesh.pattern, |u, v| {
                let low = 44.0 * u;
                Point3::new(48.0 * u, low + (44.0 - 28.0 * u) * v, 0.0)
            });
            let mut p = Problem::new(&grid, 1.0, 1.0, 1.0 / 3.0)?;
            p.clamp(&grid.side_u(false));
            let end = grid.side_u(true);
            p.line_load(&end, 1, 1.0);
            let s = p.solve(kind)?;
            Ok(s.measured(s.u(end[n / 2], 1), grid.cells(), 1.0 / n as f64))
        }),
    };
    cook.both()
}
