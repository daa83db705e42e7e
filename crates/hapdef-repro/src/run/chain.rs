//! The trained chain, and which of what it finds are contacts.

use std::ops::Range;

use anyhow::{Context, Result};
pub(crate) use hapdef::candidates;
use hapdef::stages::{NetKind, trained_chain};
use hapdef::{FoundContact, Hapdefx, Limb, Pipeline, Run, maps_of_readings};
use hapdef_nets::Net;

use super::dataset::Dataset;
use crate::search::forward;

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
                Ok(maps_of_readings(chain, &readings, rows.len(), presses.n_surface)?)
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
