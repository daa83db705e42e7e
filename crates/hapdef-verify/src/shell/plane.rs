//! Cook's membrane with the shell's membrane.

use nalgebra::Point3;

use super::benchmark::{Benchmark, ids};
use super::grid::{Grid, Pattern};
use super::model::{Load, Model, Probe, clamped_start};
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
        solve: MODEL.solve(),
    };
    cook.both()
}

const MODEL: Model = Model {
    grid: |mesh| {
        Grid::new(mesh.n, mesh.n, mesh.pattern, |u, v| {
            let low = 44.0 * u;
            Point3::new(48.0 * u, low + (44.0 - 28.0 * u) * v, 0.0)
        })
    },
    thickness: 1.0,
    material: [1.0, 1.0 / 3.0],
    supports: clamped_start,
    load: Load::End(1, 1.0),
    probe: Probe::EndMiddle(1),
};
