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

use super::table::Trial;
use crate::error::ReproError;

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
