//! The paper's chain on a limb's surface, and what it finds in many frames.

use hapdef_kmax::{KMaxGraph, KMaxParams};
use hapdef_live::estimator::{ChainNets, FoundContact, Hapdefx, HapdefxScratch};
use rayon::prelude::*;

use crate::error::HapdefError;
use crate::scene::HapdefxSpec;
use crate::scoring::ScoredContact;

/// Rows that one thread takes at a time.
const ROWS: usize = 32;

/// Puts the trained nets around k-Max on the limb's surface points `[n_surface]`.
///
/// # Errors
/// [`HapdefError::KMax`] when the neighbourhoods can't be built; [`HapdefError::Live`] when the nets
/// don't fit the points.
pub fn hapdefx(
    nets: ChainNets,
    points_m: Vec<[f64; 3]>,
    spec: &HapdefxSpec,
) -> Result<Hapdefx, HapdefError> {
    let params = KMaxParams::spanning_radius(&points_m, spec.kmax_radius_m)?;
    let graph = KMaxGraph::new(&points_m, params)?;
    Ok(Hapdefx::new(nets, graph, points_m, spec.floor_um as f32)?)
}

/// Maps `[n, n_surface]`, µm, of readings `[n, n_gauges]`, µε, in parallel.
///
/// # Errors
/// [`HapdefError::Live`] for readings that the chain refuses.
pub fn maps_of_readings(
    chain: &Hapdefx,
    readings: &[f32],
    n: usize,
    n_surface: usize,
) -> Result<Vec<f32>, HapdefError> {
    let mut maps = vec![0.0; n * n_surface];
    maps.par_chunks_mut(ROWS * n_surface)
        .zip(readings.par_chunks(ROWS * (readings.len() / n.max(1)).max(1)))
        .try_for_each_init(HapdefxScratch::default, |scratch, (maps, readings)| {
            chain.maps(readings, scratch, maps)
        })?;
    Ok(maps)
}

/// Candidates of each of `maps` `[n, n_surface]`, µm, greatest force first, in parallel.
///
/// # Errors
/// [`HapdefError::Live`] for maps that k-Max refuses.
pub fn candidates(
    chain: &Hapdefx,
    maps: &[f32],
    n_surface: usize,
) -> Result<Vec<Vec<FoundContact>>, HapdefError> {
    let found: Result<Vec<_>, _> = maps
        .par_chunks(n_surface)
        .map_init(HapdefxScratch::default, |scratch, map| chain.candidates(map, scratch))
        .collect();
    Ok(found?)
}

/// Positions and forces alone.
#[must_use]
pub fn scored(found: &[FoundContact]) -> Vec<ScoredContact> {
    found.iter().map(|c| (c.position_m, c.force_n)).collect()
}
