//! The paper's trained pipeline on the comparison's frames.

use std::time::Instant;

use anyhow::Result;
use hapdef::stages::{compliance_table, trained_chain};
use hapdef::touch::{ChainStages, chain_stages};
use hapdef::{ComplianceTable, DrawnContact, Hapdefx, HapdefxScratch, Limb, Run};
use hapdef_inverse::{Skin, SkinPoint};
use hapdef_mesh::tri6;

use super::score::Score;
use super::world::Frame;
use crate::run::scores::scored;

/// The trained chain and its buffers.
pub(crate) struct PaperPipeline {
    chain: Hapdefx,
    scratch: HapdefxScratch,
    map_um: Vec<f32>,
    /// The nominal limb's, for exact virtual gauges.
    compliance: ComplianceTable,
}

/// Where the virtual gauges come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum VirtualGauges {
    /// From the readings, by F_T.
    Transferred,
    /// Those of the nominal limb under the true contacts: no rig, no noise, no F_T.
    Exact,
}

impl VirtualGauges {
    /// What a row's name begins with.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Transferred => "paper",
            Self::Exact => "exact virtual gauges",
        }
    }
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
        let ChainStages { data, nets, .. } = chain_stages(run, limb)?;
        Ok(Self {
            chain: trained_chain(run, limb, &data, &nets)?,
            scratch: HapdefxScratch::default(),
            map_um: vec![0.0; limb.n_surface_nodes()],
            compliance: compliance_table(run, limb)?,
        })
    }

    /// The row of `frames`, whose first channels are the scene's gauges.
    pub(crate) fn score(
        &mut self,
        skin: &Skin,
        frames: &[Frame],
        n_gauges: usize,
        virtual_gauges: VirtualGauges,
        ranking: Ranking,
    ) -> Result<Score> {
        let mut score = Score::default();
        for frame in frames {
            let inputs = match virtual_gauges {
                VirtualGauges::Transferred => {
                    let readings = frame.readings_ue[..n_gauges].iter();
                    readings.map(|r| *r as f32).collect()
                }
                VirtualGauges::Exact => self.exact_virtual_um(skin, frame),
            };
            let start = Instant::now();
            let (scratch, map_um) = (&mut self.scratch, &mut self.map_um);
            match virtual_gauges {
                VirtualGauges::Transferred => self.chain.maps(&inputs, scratch, map_um)?,
                VirtualGauges::Exact => {
                    self.chain.maps_of_virtual_gauges(&inputs, scratch, map_um)?;
                }
            }
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
            score.add(skin, frame, &scored(&taken), time_us)?;
        }
        Ok(score)
    }

    /// Displacement magnitudes at the virtual gauges under the frame's contacts, friction left out,
    /// `[n_virtual]`, µm.
    fn exact_virtual_um(&self, skin: &Skin, frame: &Frame) -> Vec<f32> {
        let contacts = frame.contacts.iter().map(|c| (c.point, c.force_n));
        let mut surface_um = vec![0.0; self.compliance.n_surface()];
        let mut virtual_um = vec![0.0; self.compliance.n_virtual()];
        let loads = node_loads(skin, contacts);
        let scratch = &mut self.compliance.scratch();
        self.compliance.superpose(&loads, scratch, &mut surface_um, &mut virtual_um);
        virtual_um
    }
}

/// Contacts as loads on nodes: one inside a face loads its nodes with their shape functions.
pub(crate) fn node_loads(
    skin: &Skin,
    contacts: impl Iterator<Item = (SkinPoint, f64)>,
) -> Vec<DrawnContact> {
    let of_contact = |(point, force_n): (SkinPoint, f64)| {
        let [_, xi, eta] = point.bary();
        let nodes = skin.face_nodes(point.face()).iter();
        nodes.zip(tri6::shape(xi, eta)).map(move |(node, share)| DrawnContact {
            node: *node as usize,
            force_n: force_n * share,
        })
    };
    contacts.flat_map(of_contact).collect()
}
