//! The paper's chain from gauge readings to contacts (Sun & Martius 2019, figure 2).

mod files;
mod paper_chain;

use hapdef_kmax::{Candidate, KMaxGraph, Peak, select_top, select_top_with_spread};
use hapdef_nets::{Net, Scratch};
use serde::{Deserialize, Serialize};

pub use paper_chain::PaperChain;

use crate::error::LiveError;

/// Candidate T + 1 is taken instead of T when its force lies within this share (section 4.4).
const SPREAD_TOLERANCE: f32 = 0.10;

/// A contact the estimator found.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct FoundContact {
    /// Surface node.
    pub node: usize,
    /// Its position, m.
    pub position_m: [f64; 3],
    /// Force, N.
    pub force_n: f64,
    /// Displacement of the map there, µm.
    pub displacement_um: f64,
}

/// The trained nets of the chain.
#[derive(Clone, Debug, PartialEq)]
pub struct ChainNets {
    /// F_T: readings, µε → displacements at the virtual gauges, µm.
    pub transfer: Net,
    /// F_R: those → the map, µm.
    pub reconstruction: Net,
    /// F_S: a peak's displacement, µm, and position, m → its force, N.
    pub sensitivity: Net,
}

/// Readings → F_T → virtual gauges → F_R → map → k-Max → candidates → F_S → forces.
pub struct Hapdefx {
    nets: ChainNets,
    graph: KMaxGraph,
    points_m: Vec<[f64; 3]>,
    floor_um: f32,
}

/// Buffers of an estimation; keep one per thread and use it again.
#[derive(Clone, Debug, Default)]
pub struct HapdefxScratch {
    nets: Scratch,
    virtual_um: Vec<f32>,
    peaks: Vec<Peak>,
}

impl Hapdefx {
    /// Puts the trained nets and the limb's surface points `[n_surface]` with their neighbourhoods
    /// together; a displacement up to `floor_um` is no candidate.
    ///
    /// # Errors
    /// [`LiveError::Chain`] when they don't fit each other.
    pub fn new(
        nets: ChainNets,
        graph: KMaxGraph,
        points_m: Vec<[f64; 3]>,
        floor_um: f32,
    ) -> Result<Self, LiveError> {
        let spec = |net: &Net| (net.mlp().spec().inputs, net.mlp().spec().outputs);
        let (transfer, reconstruction) = (spec(&nets.transfer), spec(&nets.reconstruction));
        let n_surface = points_m.len();
        check("F_R's inputs", transfer.1, reconstruction.0)?;
        check("F_R's outputs", n_surface, reconstruction.1)?;
        check("nodes of k-Max", n_surface, graph.n_nodes())?;
        check("F_S's inputs", 4, spec(&nets.sensitivity).0)?;
        check("F_S's outputs", 1, spec(&nets.sensitivity).1)?;
        Ok(Self { nets, graph, points_m, floor_um })
    }

    /// Numbers in: the gauges.
    #[must_use]
    pub fn n_gauges(&self) -> usize {
        self.nets.transfer.mlp().spec().inputs
    }

    /// Points of the map.
    #[must_use]
    pub fn n_surface(&self) -> usize {
        self.points_m.len()
    }

    /// Deformation maps of frames of readings `[n, n_gauges]`, µε, into `map_um`
    /// `[n, n_surface]`, µm.
    ///
    /// # Errors
    /// [`LiveError::Net`] when a reading is not finite or a slice has another length.
    pub fn maps(
        &self,
        readings_ue: &[f32],
        scratch: &mut HapdefxScratch,
        map_um: &mut [f32],
    ) -> Result<(), LiveError> {
        let transfer = self.nets.transfer.mlp().spec();
        let n_frames = readings_ue.len() / transfer.inputs;
        scratch.virtual_um.resize(n_frames * transfer.outputs, 0.0);
        self.nets.transfer.forward_batch(
            readings_ue,
            &mut scratch.nets,
            &mut scratch.virtual_um,
        )?;
        self.nets.reconstruction.forward_batch(&scratch.virtual_um, &mut scratch.nets, map_um)?;
        Ok(())
    }

    /// Deformation maps of frames whose virtual gauges `virtual_um` `[n, n_virtual]`, µm, are known:
    /// what the chain would do if its transfer were perfect.
    ///
    /// # Errors
    /// As [`Hapdefx::maps`].
    pub fn maps_of_virtual_gauges(
        &self,
        virtual_um: &[f32],
        scratch: &mut HapdefxScratch,
        map_um: &mut [f32],
    ) -> Result<(), LiveError> {
        self.nets.reconstruction.forward_batch(virtual_um, &mut scratch.nets, map_um)?;
        Ok(())
    }

    /// All candidate contacts of a map `[n_surface]`, µm, greatest force first.
    ///
    /// # Errors
    /// [`LiveError::KMax`] when the map has another length.
    pub fn candidates(
        &self,
        map_um: &[f32],
        scratch: &mut HapdefxScratch,
    ) -> Result<Vec<FoundContact>, LiveError> {
        self.graph.peaks(map_um, self.floor_um, &mut scratch.peaks)?;
        let mut found = Vec::with_capacity(scratch.peaks.len());
        for peak in &scratch.peaks {
            let position_m = self.points_m[peak.node];
            let [x, y, z] = position_m.map(|v| v as f32);
            let mut force_n = [0.0];
            let features = [peak.value, x, y, z];
            self.nets.sensitivity.forward(&features, &mut scratch.nets, &mut force_n)?;
            found.push(FoundContact {
                node: peak.node,
                position_m,
                force_n: f64::from(force_n[0]),
                displacement_um: f64::from(peak.value),
            });
        }
        found.sort_by(|a, b| b.force_n.total_cmp(&a.force_n).then(a.node.cmp(&b.node)));
        Ok(found)
    }

    /// The `n_contacts` candidates of greatest force.
    #[must_use]
    pub fn top(&self, found: &[FoundContact], n_contacts: usize) -> Vec<FoundContact> {
        pick(found, &select_top(&scored(found), n_contacts))
    }

    /// The same with the paper's T + 1 rule.
    ///
    /// # Errors
    /// [`LiveError::KMax`] when a candidate is not of this limb.
    pub fn top_with_spread(
        &self,
        found: &[FoundContact],
        n_contacts: usize,
    ) -> Result<Vec<FoundContact>, LiveError> {
        let candidates = scored(found);
        let chosen =
            select_top_with_spread(&self.points_m, &candidates, n_contacts, SPREAD_TOLERANCE)?;
        Ok(pick(found, &chosen))
    }
}

fn scored(found: &[FoundContact]) -> Vec<Candidate> {
    found.iter().map(|c| Candidate { node: c.node, score: c.force_n as f32 }).collect()
}

fn pick(found: &[FoundContact], chosen: &[Candidate]) -> Vec<FoundContact> {
    let by_node = |candidate: &Candidate| found.iter().find(|c| c.node == candidate.node).copied();
    chosen.iter().filter_map(by_node).collect()
}

fn check(what: &'static str, expected: usize, found: usize) -> Result<(), LiveError> {
    if expected == found {
        return Ok(());
    }
    Err(LiveError::Chain { what, expected, found })
}
