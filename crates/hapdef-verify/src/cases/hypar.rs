//! The partly clamped hyperbolic paraboloid from thick to very thin.

use std::rc::Rc;

use nalgebra::Point3;

use super::prelude::*;
use crate::memo::Memo;

/// Name, title, t/L, the map of its mesh, and the energy of the whole shell, J.
type Thickness = (&'static str, &'static str, f64, Map, f64);

const THICKNESSES: [Thickness; 4] = [
    ("hypar.1e_2", "Hyperbolic paraboloid, t/L 1e-2", 1e-2, |p| hypar(1e-2, p), 1.6823e-3),
    ("hypar.1e_3", "Hyperbolic paraboloid, t/L 1e-3", 1e-3, |p| hypar(1e-3, p), 1.1021e-2),
    ("hypar.1e_4", "Hyperbolic paraboloid, t/L 1e-4", 1e-4, |p| hypar(1e-4, p), 9.0027e-2),
    ("hypar.1e_5", "Hyperbolic paraboloid, t/L 1e-5", 1e-5, |p| hypar(1e-5, p), 8.165e-1),
];

const MESHES: &[[usize; 3]] = &[[32, 16, 1], [64, 32, 1], [128, 64, 1], [256, 128, 1]];

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    // the uniformity row asks for all energies again
    let known: Rc<Memo<(Element, usize, &str), Measured>> = Rc::default();
    let energy = move |row: Thickness, element, n: [usize; 3]| {
        let found = || model(row).measure(element, n, Pattern::Up);
        known.get((element, n[0], row.0), found).map(|found| Measured::clone(&found))
    };
    let mut cases = Vec::new();
    for row in THICKNESSES {
        let energy = energy.clone();
        let case = Case {
            name: row.0,
            title: row.1,
            quantity: "strain energy of z = x² − y² over a unit square, clamped at x = −½, under 8000 t per \
                area, E = 2e11, ν = 0.3; half of it, with a strip of 6 √t at the clamped side",
            unit: "J",
            reference: Reference::Published(row.4),
            source: "an hp method with up to 71,064 unknowns, crates/hapdef-verify/reference/hypar_hp.py, settled \
                to 0.02 % (0.06 % at t/L 1e-5); within 0.2 % of Bathe, Iosilevich and Chapelle, Comput. Struct. 75, \
                2000, MITC16 on 48 × 24 cells (1.6790e-3, 1.1013e-2, 8.9867e-2 from memory; they stop at 1e-4)",
            meshes: MESHES,
            solve: Solve::by(move |element, n| energy(row, element, n)),
            ..Case::default()
        };
        cases.extend(case.both());
    }
    let uniformity = Case {
        name: "hypar.uniformity",
        title: "Hyperbolic paraboloid, uniformity in t/L",
        quantity: "largest error of energy at t/L from 1e-2 to 1e-5 over the error at 1e-2; thinner shells \
            than the mesh can bend without stretching fail it, see the coarse meshes",
        reference: Reference::Exact(1.0),
        source: "an element without locking has errors that don't grow as the shell gets thinner (Chapelle \
            and Bathe, Comput. Struct. 66, 1998); up to a factor of two counts as uniform",
        target: Target::within(1.0),
        meshes: MESHES,
        solve: Solve::by(move |element, n| {
            let mut errors = Vec::new();
            for row in THICKNESSES {
                errors.push((energy(row, element, n)?.value / row.4 - 1.0).abs());
            }
            let value = errors.iter().copied().fold(0.0, f64::max) / errors[0];
            Ok(Measured { value, ..energy(THICKNESSES[0], element, n)? })
        }),
        ..Case::default()
    };
    cases.extend(uniformity.both());
    cases
}

/// Half of the shell, whose load works twice its strain energy.
fn model((_, _, thickness, map, _): Thickness) -> Model {
    Model {
        mesh: Mesh::Grid(thickness, &[Pattern::Up], map),
        material: [2e11, 0.3],
        supports: &[(All, X(-0.5)), (Mirror(1), Y(0.0))],
        load: Load::Area([0.0, 0.0, -8000.0 * thickness]),
        probe: Probe::Work(1.0),
    }
}

/// The strip at the clamped side has half the cells.
fn hypar(thickness: f64, p: Point3<f64>) -> Point3<f64> {
    let layer = (6.0 * thickness.sqrt()).min(0.5);
    let s = match p.x {
        u if u < 0.5 => 2.0 * u * layer,
        u => layer + (2.0 * u - 1.0) * (1.0 - layer),
    };
    let (x, y) = (s - 0.5, 0.5 * p.y);
    Point3::new(x, y, x * x - y * y)
}
