//! The partly clamped hyperbolic paraboloid from thick to very thin.

use std::rc::Rc;

use hapdef_sim::ShellKind;
use nalgebra::{Point3, Vector3};

use super::benchmark::{Benchmark, ids};
use super::grid::{Grid, Mesh, Pattern};
use super::problem::Problem;
use crate::{Case, Measured, Reference, Target, VerifyError};

/// t/L and the energy of the whole shell, J.
const ENERGIES: [(f64, f64); 4] = [
    (1e-2, 1.6790e-3),
    (1e-3, 1.1013e-2),
    (1e-4, 8.9867e-2),
    (1e-5, 8.15641e-1),
];

const PUBLISHED: &str = "Bathe, Iosilevich and Chapelle, Comput. Struct. 75, 2000: MITC16 on 48 × 24 cells \
    (value from memory)";

const LOCKS: &str = "a very thin shell that bends without stretching locks on coarse meshes: flat facets stretch \
    when they bend, by a share that falls with the fourth power of the cell's size";

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let rows = [
        (ids!("hypar.1e_2"), "Hyperbolic paraboloid, t/L 1e-2"),
        (ids!("hypar.1e_3"), "Hyperbolic paraboloid, t/L 1e-3"),
        (ids!("hypar.1e_4"), "Hyperbolic paraboloid, t/L 1e-4"),
        (ids!("hypar.1e_5"), "Hyperbolic paraboloid, t/L 1e-5"),
    ];
    let mut cases = Vec::new();
    for ((ids, title), (thickness, energy)) in rows.into_iter().zip(ENERGIES) {
        let benchmark = Benchmark {
            ids,
            title,
            quantity: "strain energy of z = x² − y² over a unit square, clamped at x = −½, under 8000 t per \
                area, E = 2e11, ν = 0.3; half of it, with a strip of 6 √t at the clamped side",
            unit: "J",
            reference: Reference::Published(energy),
            source: if thickness < 5e-5 {
                "no published value known: the mean of both kinds of this shell on 256 × 128 cells, which \
                    differ by 0.04 %"
            } else {
                PUBLISHED
            },
            target: Target::within(0.01),
            n: &[16, 32, 64],
            patterns: &[Pattern::Up],
            solve: Rc::new(move |kind, mesh| hypar(kind, mesh, thickness)),
        };
        let missed = if thickness < 5e-5 {
            [Some(0.0492), Some(0.0440)]
        } else {
            [None; 2]
        };
        cases.extend(benchmark.missed(missed, LOCKS));
    }
    cases.extend(uniformity().missed([Some(162.4), Some(215.7)], LOCKS));
    cases
}

fn uniformity() -> Benchmark {
    Benchmark {
        ids: ids!("hypar.uniformity"),
        title: "Hyperbolic paraboloid, uniformity in t/L",
        quantity: "largest error of energy over the smallest, t/L from 1e-2 to 1e-5",
        unit: "1",
        reference: Reference::Exact(1.0),
        source: "an element without locking has errors that don't depend on the thickness (Chapelle and \
            Bathe, Comput. Struct. 66, 1998); up to a factor of two counts as uniform",
        target: Target::within(1.0),
        n: &[64],
        patterns: &[Pattern::Up],
        solve: Rc::new(|kind, mesh| {
            let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
            let mut last = None;
            for (thickness, energy) in ENERGIES {
                let found = hypar(kind, mesh, thickness)?;
                let error = (found.value / energy - 1.0).abs();
                (least, most) = (least.min(error), most.max(error));
                last = Some(found);
            }
            let last = last.ok_or_else(|| VerifyError::not_run("no thickness"))?;
            let value = most / least;
            Ok(Measured { value, ..last })
        }),
    }
}

/// The energy of the whole. The strip at the clamped side has half the cells.
fn hypar(kind: ShellKind, mesh: Mesh, thickness: f64) -> Result<Measured, VerifyError> {
    let layer = (6.0 * thickness.sqrt()).min(0.5);
    let grid = Grid::new(2 * mesh.n, mesh.n, mesh.pattern, |u, v| {
        let s = if u < 0.5 {
            2.0 * u * layer
        } else {
            layer + (2.0 * u - 1.0) * (1.0 - layer)
        };
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
