//! The rows: the chain with one thing changed.

use anyhow::Result;
use hapdef::{FoundContact, Hapdefx};
use hapdef_nets::Net;

use super::super::chain::{Choice, candidates};
use super::super::presses::Presses;
use super::modes::Modes;
use super::refine::Refiner;
use super::target::{Target, TrueMaps};
use crate::search::forward;

/// From a frame to contacts.
pub(super) struct Configuration<'a> {
    pub(super) name: String,
    /// Name of the row that it is to be compared with; empty for a reference.
    pub(super) against: &'static str,
    pub(super) maps: MapsFrom<'a>,
    /// Its k-Max and its F_S.
    pub(super) chain: &'a Hapdefx,
    pub(super) choice: Choice,
    /// Where peaks lie between nodes, if they may.
    pub(super) refiner: Option<&'a Refiner<'a>>,
}

/// Where a configuration's maps come from.
#[derive(Clone, Copy)]
pub(super) enum MapsFrom<'a> {
    /// They are the true ones.
    Truth,
    /// Virtual gauges by F_T, the true ones without it, then F_R.
    Gauges(Option<&'a Net>, &'a Net, Option<(Target, &'a Modes)>),
    /// The virtual gauges' vectors by F_T, then coefficients of modes of the map of vectors by F_R.
    Vectors(&'a [Net; 2], &'a Modes),
    /// Straight from readings.
    Readings(&'a Net),
}

impl Configuration<'_> {
    /// What of the displacement its maps show.
    pub(super) fn target(&self) -> Target {
        match self.maps {
            MapsFrom::Gauges(_, _, Some((target, _))) => target,
            MapsFrom::Vectors(..) => Target::Vector,
            _ => Target::Magnitude,
        }
    }

    /// Weights of its nets and modes up to the map.
    pub(super) fn n_weights(&self) -> usize {
        let of = |net: &Net| net.mlp().spec().n_parameters();
        match self.maps {
            MapsFrom::Truth => 0,
            MapsFrom::Readings(net) => of(net),
            MapsFrom::Vectors(nets, modes) => nets.iter().map(of).sum::<usize>() + weights(modes),
            MapsFrom::Gauges(transfer, net, by) => {
                let modes = by.map_or(0, |(_, modes)| weights(modes));
                transfer.map_or(0, of) + of(net) + modes
            }
        }
    }

    /// Maps of frames `[n, width]`, µm.
    pub(super) fn maps(&self, frames: &Presses, truth: &TrueMaps<'_>) -> Result<Vec<f32>> {
        match self.maps {
            MapsFrom::Truth => Ok(truth.of(Target::Magnitude, &frames.drawn)),
            MapsFrom::Readings(net) => Ok(forward(net, &frames.readings)?),
            MapsFrom::Vectors([transfer, net], modes) => {
                let vectors = forward(transfer, &frames.readings)?;
                modes.decode(&forward(net, &vectors)?)
            }
            MapsFrom::Gauges(None, net, by) => from_gauges(&frames.virtual_um, net, by),
            MapsFrom::Gauges(Some(transfer), net, by) => {
                from_gauges(&forward(transfer, &frames.readings)?, net, by)
            }
        }
    }

    /// Maps of simulated frames from their true virtual gauges; none for configurations without those.
    pub(super) fn simulated_maps(
        &self,
        frames: &Presses,
        truth: &TrueMaps<'_>,
    ) -> Result<Option<Vec<f32>>> {
        match self.maps {
            MapsFrom::Vectors([_, net], modes) => {
                let vectors = truth.virtual_vectors(&frames.drawn);
                modes.decode(&forward(net, &vectors)?).map(Some)
            }
            MapsFrom::Gauges(_, net, by) => from_gauges(&frames.virtual_um, net, by).map(Some),
            _ => Ok(None),
        }
    }

    /// The contacts in each of `fields` `[n, n_surface]`, µm, `n_contacts` of them at most.
    pub(super) fn contacts(
        &self,
        fields: &[f32],
        n_surface: usize,
        n_contacts: usize,
    ) -> Result<Vec<Vec<FoundContact>>> {
        let found = candidates(self.chain, fields, n_surface)?;
        let each = found.into_iter().zip(fields.chunks_exact(n_surface));
        each.map(|(found, field)| {
            let mut chosen = self.choice.of(self.chain, &found, n_contacts)?;
            if let Some(refiner) = self.refiner {
                for contact in &mut chosen {
                    contact.position_m = refiner.peak(field, contact.node);
                }
            }
            Ok(chosen)
        })
        .collect()
    }
}

/// Numbers that modes and their mean hold.
fn weights(modes: &Modes) -> usize {
    (modes.n() + 1) * modes.width()
}

fn from_gauges(virtual_um: &[f32], net: &Net, by: Option<(Target, &Modes)>) -> Result<Vec<f32>> {
    let out = forward(net, virtual_um)?;
    match by {
        None => Ok(out),
        Some((_, modes)) => modes.decode(&out),
    }
}
