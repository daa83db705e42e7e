//! The parts around solver, nets and superposition at their extremes: mesh, datasets,
//! compliance tables, k-Max, decoder, clock, recorder.

mod clock;
mod compliance;
mod data;
mod kmax;
mod mesh;
mod recorder;
mod wire;

use super::row::Case;

/// Every row of docs/stability-parts.md.
pub(super) fn cases(seed: u64) -> Vec<Case> {
    let mut all = mesh::cases();
    all.extend(data::cases());
    all.extend(compliance::cases());
    all.extend(kmax::cases());
    all.extend(wire::cases(seed));
    all.extend(clock::cases(seed));
    all.extend(recorder::cases());
    all
}
