//! The paper's trained pipeline on the comparison's frames.

use std::time::Instant;

use anyhow::Result;
use hapdef::stages::{
    Datasets, NetKind, TrainedNets, compliance, datasets, rig, train_kinds, trained_chain,
};
use hapdef::{FoundContact, Hapdefx, HapdefxScratch, Limb, Run, ScoredContact};
use hapdef_inverse::Skin;

use super::score::Score;
use super::world::Frame;

/// The trained chain and its buffers.
pub(crate) struct PaperPipeline {
    chain: Hapdefx,
    scratch: HapdefxScratch,
    map_um: Vec<f32>,
}

/// How the T contacts are chosen among the candidates; T is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ranking {
    /// The paper's: the greatest force by F_S.
    Force,
    /// The greatest displacement.
    Displacement,
}

impl Ranking {
    pub(crate) const ALL: [Self; 2] = [Self::Force, Self::Displacement];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Force => "by force",
            Self::Displacement => "by displacement",
        }
    }
}

impl PaperPipeline {
    /// Trains the chain's three nets, or takes them from the cache.
    pub(crate) fn train(run: &Run, limb: &Limb) -> Result<Self> {
        let (data, nets) = trained(run, limb)?;
        Ok(Self {
            chain: trained_chain(run, limb, &data, &nets)?,
            scratch: HapdefxScratch::default(),
            map_um: vec![0.0; limb.n_surface_nodes()],
        })
    }

    /// The row of `frames`, whose first channels are the scene's gauges.
    pub(crate) fn score(
        &mut self,
        skin: &Skin,
        frames: &[Frame],
        n_gauges: usize,
        ranking: Ranking,
    ) -> Result<Score> {
        let mut score = Score::default();
        for frame in frames {
            let readings: Vec<f32> = frame.readings_ue[..n_gauges]
                .iter()
                .map(|r| *r as f32)
                .collect();
            let start = Instant::now();
            self.chain
                .maps(&readings, &mut self.scratch, &mut self.map_um)?;
            let mut found = self.chain.candidates(&self.map_um, &mut self.scratch)?;
            let n_contacts = frame.contacts.len();
            let taken = match ranking {
                Ranking::Force => self.chain.top(&found, n_contacts),
                Ranking::Displacement => {
                    found.sort_by(|a, b| b.displacement_um.total_cmp(&a.displacement_um));
                    found.truncate(n_contacts);
                    found
                }
            };
            let time_us = start.elapsed().as_secs_f64() * 1e6;
            let taken: Vec<ScoredContact> = taken.iter().map(scored).collect();
            score.add(skin, frame, &taken, time_us)?;
        }
        Ok(score)
    }
}

fn trained(run: &Run, limb: &Limb) -> Result<(Datasets, TrainedNets)> {
    let compliance = compliance(run, limb)?;
    let rig = rig(run, limb, &compliance)?;
    let data = datasets(run, limb, &compliance, &rig)?;
    let n_sets = data.simulated.len();
    let kinds = [
        NetKind::Transfer,
        NetKind::Reconstruction { n_sets },
        NetKind::Sensitivity,
    ];
    let nets = train_kinds(run, limb, &compliance, &data, &kinds)?;
    Ok((data, nets))
}

fn scored(contact: &FoundContact) -> ScoredContact {
    (contact.position_m, contact.force_n)
}
