//! The parts around solver, nets and superposition at their extremes: mesh, datasets,
//! compliance tables, k-Max, decoder, clock, recorder.

mod clock;
mod compliance;
mod data;
mod kmax;
mod mesh;
mod recorder;
mod wire;

use super::table::Trial;

/// Every row of docs/stability-parts.md.
pub(super) fn trials(seed: u64) -> Vec<Trial> {
    let mut all = mesh::trials();
    all.extend(data::trials());
    all.extend(compliance::trials());
    all.extend(kmax::trials());
    all.extend(wire::trials(seed));
    all.extend(clock::trials(seed));
    all.extend(recorder::trials());
    all
}
