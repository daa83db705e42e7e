//! The trained chain and what it finds in readings and maps, in parallel.

use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::stages::{NetKind, trained_chain};
use hapdef::{FoundContact, Hapdefx, HapdefxScratch, Limb, Pipeline, Run};
use hapdef_nets::Net;
use rayon::prelude::*;

use super::dataset::Dataset;
use crate::search::forward;

/// Rows that one thread takes at a time.
const ROWS: usize = 32;

/// Which of a press's candidates are its contacts, whose number is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// Those of greatest force, the paper's.
    Force,
    /// The same with the paper's exchange of point T for T + 1, where there are two at least.
    ForceWithSpread,
    /// Those of greatest displacement.
    Displacement,
}

impl Choice {
    /// `n` contacts of those that `chain` found, as many as there are.
    pub(crate) fn of(
        self,
        chain: &Hapdefx,
        found: &[FoundContact],
        n: usize,
    ) -> Result<Vec<FoundContact>> {
        Ok(match self {
            Self::ForceWithSpread if n > 1 => chain.top_with_spread(found, n)?,
            Self::Force | Self::ForceWithSpread => chain.top(found, n),
            Self::Displacement => {
                let mut found = found.to_vec();
                found.sort_by(|a, b| {
                    let largest_first = b.displacement_um.total_cmp(&a.displacement_um);
                    largest_first.then(a.node.cmp(&b.node))
                });
                found.truncate(n);
                found
            }
        })
    }
}

/// What maps of presses are made from.
#[derive(Clone, Copy)]
pub(crate) enum MapFrom<'a> {
    /// Readings, by the chain.
    Readings(&'a Hapdefx),
    /// True virtual gauges, by F_R.
    Gauges(&'a Net),
}

impl MapFrom<'_> {
    /// Maps `[n, n_surface]`, µm, of the presses `rows`.
    pub(crate) fn maps(self, presses: &mut Dataset, rows: Range<usize>) -> Result<Vec<f32>> {
        match self {
            Self::Readings(chain) => {
                let readings = presses.readings(rows.clone())?;
                maps(chain, &readings, rows.len(), presses.n_surface)
            }
            Self::Gauges(net) => Ok(forward(net, &presses.inputs(rows)?)?),
        }
    }
}

/// The chain of a finished pipeline.
pub(crate) fn chain(run: &Run, limb: &Limb, done: &Pipeline) -> Result<Hapdefx> {
    let nets = done.nets.as_ref().context("no nets")?;
    let data = done.data.as_ref().context("no datasets")?;
    Ok(trained_chain(run, limb, data, nets)?)
}

/// F_R, trained on all sets.
pub(crate) fn reconstruction(done: &Pipeline) -> Result<Net> {
    let nets = done.nets.as_ref().context("no nets")?;
    let n_sets = done.data.as_ref().context("no datasets")?.simulated.len();
    Ok(nets.load(NetKind::Reconstruction { n_sets })?)
}

/// Maps `[n, n_surface]`, µm, of readings `[n, n_gauges]`, µε.
fn maps(chain: &Hapdefx, readings: &[f32], n: usize, n_surface: usize) -> Result<Vec<f32>> {
    let mut maps = vec![0.0; n * n_surface];
    maps.par_chunks_mut(ROWS * n_surface)
        .zip(readings.par_chunks(ROWS * (readings.len() / n.max(1)).max(1)))
        .try_for_each_init(HapdefxScratch::default, |scratch, (maps, readings)| {
            chain.maps(readings, scratch, maps)
        })?;
    Ok(maps)
}

/// Candidates of each of `maps` `[n, n_surface]`, µm, greatest force first.
pub(crate) fn candidates(
    chain: &Hapdefx,
    maps: &[f32],
    n_surface: usize,
) -> Result<Vec<Vec<FoundContact>>> {
    let found: Result<Vec<_>, _> = maps
        .par_chunks(n_surface)
        .map_init(HapdefxScratch::default, |scratch, map| chain.candidates(map, scratch))
        .collect();
    Ok(found?)
}
