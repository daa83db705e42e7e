//! The partly clamped hyperbolic paraboloid from thick to very thin.

use std::cell::RefCell;
use std::rc::Rc;

use hapdef_sim::ShellKind;
use nalgebra::{Point3, Vector3};

use super::benchmark::{Benchmark, ids};
use super::grid::{Grid, Mesh, Pattern};
use super::problem::Problem;
use crate::{Case, Measured, Reference, Target, VerifyError};

/// t/L and the energy of the whole shell, J.
const ENERGIES: [(f64, f64); 4] =
    [(1e-2, 1.6823e-3), (1e-3, 1.1021e-2), (1e-4, 9.0027e-2), (1e-5, 8.165e-1)];

const SOURCE: &str = "an hp method with up to 71,064 unknowns, crates/hapdef-verify/reference/hypar_hp.py, settled to \
    0.02 % (0.06 % at t/L 1e-5); within 0.2 % of Bathe, Iosilevich and Chapelle, Comput. Struct. 75, 2000, MITC16 \
    on 48 × 24 cells (1.6790e-3, 1.1013e-2, 8.9867e-2 from memory; they stop at 1e-4)";

/// [`Mesh::n`] of the levels.
const LEVELS: &[usize] = &[16, 32, 64, 128];

/// Energies that are known by now, since the uniformity row asks for them again.
type Known = Rc<RefCell<Vec<(ShellKind, usize, f64, Measured)>>>;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let rows = [
        (ids!("hypar.1e_2"), "Hyperbolic paraboloid, t/L 1e-2"),
        (ids!("hypar.1e_3"), "Hyperbolic paraboloid, t/L 1e-3"),
        (ids!("hypar.1e_4"), "Hyperbolic paraboloid, t/L 1e-4"),
        (ids!("hypar.1e_5"), "Hyperbolic paraboloid, t/L 1e-5"),
    ];
    let known = Known::default();
    let mut cases = Vec::new();
    for ((ids, title), (thickness, energy)) in rows.into_iter().zip(ENERGIES) {
        let known = known.clone();
        let benchmark = Benchmark {
            ids,
            title,
            quantity: "strain energy of z = x² − y² over a unit square, clamped at x = −½, under 8000 t per \
                area, E = 2e11, ν = 0.3; half of it, with a strip of 6 √t at the clamped side",
            unit: "J",
            reference: Reference::Published(energy),
            source: SOURCE,
            target: Target::within(0.01),
            n: LEVELS,
            patterns: &[Pattern::Up],
            solve: Rc::new(move |kind, mesh| hypar_once(&known, kind, mesh, thickness)),
        };
        cases.extend(benchmark.both());
    }
    cases.extend(uniformity(known).both());
    cases
}

fn uniformity(known: Known) -> Benchmark {
    Benchmark {
        ids: ids!("hypar.uniformity"),
        title: "Hyperbolic paraboloid, uniformity in t/L",
        quantity: "largest error of energy at t/L from 1e-2 to 1e-5 over the error at 1e-2; thinner shells \
            than the mesh can bend without stretching fail it, see the coarse meshes",
        unit: "1",
        reference: Reference::Exact(1.0),
        source: "an element without locking has errors that don't grow as the shell gets thinner (Chapelle \
            and Bathe, Comput. Struct. 66, 1998); up to a factor of two counts as uniform",
        target: Target::within(1.0),
        n: LEVELS,
        patterns: &[Pattern::Up],
        solve: Rc::new(move |kind, mesh| {
            let mut errors = Vec::new();
            let mut last = None;
            for (thickness, energy) in ENERGIES {
                let found = hypar_once(&known, kind, mesh, thickness)?;
                errors.push((found.value / energy - 1.0).abs());
                last = Some(found);
            }
            let last = last.ok_or_else(|| VerifyError::not_run("no thickness"))?;
            let value = errors.iter().copied().fold(0.0, f64::max) / errors[0];
            Ok(Measured { value, ..last })
        }),
    }
}

fn hypar_once(
    known: &Known,
    kind: ShellKind,
    mesh: Mesh,
    thickness: f64,
) -> Result<Measured, VerifyError> {
    let is_it = |(k, n, t, _): &&(ShellKind, usize, f64, Measured)| {
        *k == kind && *n == mesh.n && t.total_cmp(&thickness).is_eq()
    };
    if let Some((.., found)) = known.borrow().iter().find(is_it) {
        return Ok(found.clone());
    }
    let found = hypar(kind, mesh, thickness)?;
    let entry = (kind, mesh.n, thickness, found.clone());
    known.borrow_mut().push(entry);
    Ok(found)
}

/// The energy of the whole. The strip at the clamped side has half the cells.
fn hypar(kind: ShellKind, mesh: Mesh, thickness: f64) -> Result<Measured, VerifyError> {
    let layer = (6.0 * thickness.sqrt()).min(0.5);
    let grid = Grid::new(2 * mesh.n, mesh.n, mesh.pattern, |u, v| {
        let s = if u < 0.5 { 2.0 * u * layer } else { layer + (2.0 * u - 1.0) * (1.0 - layer) };
        let (x, y) = (s - 0.5, 0.5 * v);
        Point3::new(x, y, x * x - y * y)
    });
    let mut p = Problem::new(&grid, thickness, 2e11, 0.3)?;
    p.clamp(&grid.side_u(false));
    p.mirror(&grid.side_v(false), 1);
    p.area_force(Vector3::new(0.0, 0.0, -8000.0 * thickness));
    let s = p.solve(kind)?;
    Ok(s.measured(2.0 * s.energy, grid.cells(), 1.0 / mesh.n as f64))
}
