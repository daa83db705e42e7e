//! The paper's trained pipeline on the comparison's frames.

use std::time::Instant;

use anyhow::Result;
use hapdef::stages::{compliance_table, trained_chain};
use hapdef::touch::{ChainStages, chain_stages, touchable_skin};
use hapdef::{ComplianceTable, DrawnContact, Hapdefx, HapdefxScratch, Limb, Run, scored};
use hapdef_inverse::{Skin, SkinPoint};
use hapdef_mesh::tri6;

use super::score::Score;
use super::world::Frame;
use crate::run::chain::Choice;

/// The trained chain and its buffers.
pub(crate) struct PaperPipeline {
    chain: Hapdefx,
    scratch: HapdefxScratch,
    map_um: Vec<f32>,
    /// The nominal limb's, for exact virtual gauges.
    truth: TrueMaps,
}

/// Displacements of the nominal limb under any contacts, friction left out.
pub(crate) struct TrueMaps {
    compliance: ComplianceTable,
    skin: Skin,
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

impl PaperPipeline {
    /// Trains the chain's three nets, or takes them from the cache.
    pub(crate) fn train(run: &Run, limb: &Limb) -> Result<Self> {
        let ChainStages { data, nets, .. } = chain_stages(run, limb)?;
        Ok(Self {
            chain: trained_chain(run, limb, &data, &nets)?,
            scratch: HapdefxScratch::default(),
            map_um: vec![0.0; limb.n_surface_nodes()],
            truth: TrueMaps::read(run, limb)?,
        })
    }

    /// The row of `frames`, whose first channels are the scene's gauges.
    pub(crate) fn score(
        &mut self,
        skin: &Skin,
        frames: &[Frame],
        n_gauges: usize,
        virtual_gauges: VirtualGauges,
        choice: Choice,
    ) -> Result<Score> {
        let mut score = Score::default();
        for frame in frames {
            let (scratch, map_um) = (&mut self.scratch, &mut self.map_um);
            let start = match virtual_gauges {
                VirtualGauges::Transferred => {
                    let readings = frame.readings_ue[..n_gauges].iter();
                    let readings: Vec<f32> = readings.map(|r| *r as f32).collect();
                    let start = Instant::now();
                    self.chain.maps(&readings, scratch, map_um)?;
                    start
                }
                VirtualGauges::Exact => {
                    let [_, virtual_um] = self.truth.of_frame(frame);
                    let start = Instant::now();
                    self.chain.maps_of_virtual_gauges(&virtual_um, scratch, map_um)?;
                    start
                }
            };
            let found = self.chain.candidates(&self.map_um, &mut self.scratch)?;
            let taken = choice.of(&self.chain, &found, frame.contacts.len())?;
            let time_us = start.elapsed().as_secs_f64() * 1e6;
            score.add(skin, frame, &scored(&taken), time_us)?;
        }
        Ok(score)
    }
}

impl TrueMaps {
    /// The compliance comes from the cache, or is solved.
    pub(crate) fn read(run: &Run, limb: &Limb) -> Result<Self> {
        Ok(Self { compliance: compliance_table(run, limb)?, skin: touchable_skin(limb)? })
    }

    pub(crate) fn skin(&self) -> &Skin {
        &self.skin
    }

    pub(crate) fn n_surface(&self) -> usize {
        self.compliance.n_surface()
    }

    /// [`Self::under`] the frame's contacts.
    pub(crate) fn of_frame(&self, frame: &Frame) -> [Vec<f32>; 2] {
        self.under(frame.contacts.iter().map(|c| (c.point, c.force_n)))
    }

    /// Displacement magnitudes of the surface `[n_surface]` and at the virtual gauges `[n_virtual]`, µm;
    /// a contact inside a face loads its nodes with their shape functions.
    pub(crate) fn under(&self, contacts: impl Iterator<Item = (SkinPoint, f64)>) -> [Vec<f32>; 2] {
        let mut surface_um = vec![0.0; self.compliance.n_surface()];
        let mut virtual_um = vec![0.0; self.compliance.n_virtual()];
        let of_contact = |(point, force_n): (SkinPoint, f64)| {
            let [_, xi, eta] = point.bary();
            let nodes = self.skin.face_nodes(point.face()).iter();
            nodes.zip(tri6::shape(xi, eta)).map(move |(node, share)| DrawnContact {
                node: *node as usize,
                force_n: force_n * share,
            })
        };
        let loads: Vec<DrawnContact> = contacts.flat_map(of_contact).collect();
        let scratch = &mut self.compliance.scratch();
        self.compliance.superpose(&loads, scratch, &mut surface_um, &mut virtual_um);
        [surface_um, virtual_um]
    }
}
