//! The parts around solver, nets and superposition at their extremes: mesh, datasets,
//! compliance tables, k-Max, decoder, clock, recorder.

mod clock;
mod compliance;
mod data;
mod kmax;
mod mesh;
mod recorder;
mod wire;

use std::path::Path;

use super::table::Trials;
use crate::error::ReproError;

/// Every row of docs/stability-parts.md, in its order; `seed` draws their data.
pub fn trials(seed: u64) -> Trials<u64> {
    let mut rows = Trials::new(seed);
    mesh::add(rows.of("mesh"));
    data::add(rows.of("dataset"));
    compliance::add(rows.of("compliance"));
    kmax::add(rows.of("k-Max"));
    wire::add(rows.of("decoder"));
    clock::add(rows.of("clock"));
    recorder::add(rows.of("recorder"));
    rows
}

/// What `work` makes of a path of this name in a folder that is gone afterwards.
fn in_folder<T>(
    name: &str,
    work: impl Fn(&Path) -> Result<T, ReproError>,
) -> Result<T, ReproError> {
    let folder = tempfile::tempdir().map_err(ReproError::Folder)?;
    work(&folder.path().join(name))
}

/// Cuts a file to this share of its bytes.
fn keep_share(path: &Path, share: f64) -> Result<(), ReproError> {
    let bytes = std::fs::read(path).map_err(ReproError::Folder)?;
    let n_left = (share * bytes.len() as f64) as usize;
    std::fs::write(path, &bytes[..n_left]).map_err(ReproError::Folder)
}
