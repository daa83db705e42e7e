//! How far the displacement of the whole skin is from the truth.

use anyhow::Result;
use hapdef::stages::compliance_table;
use hapdef::touch::touchable_skin;
use hapdef::{ComplianceTable, Limb, Run};
use hapdef_inverse::{Contact, Skin, SkinPoint};

use crate::compare::paper::node_loads;
use crate::compare::world::Frame;

/// Displacements of the nominal limb under any contacts.
pub(super) struct TrueMaps {
    compliance: ComplianceTable,
    skin: Skin,
}

/// Mean of the absolute errors of maps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeanError {
    sum_um: f64,
    n: usize,
}

impl TrueMaps {
    /// The compliance comes from the cache, or is solved.
    pub(super) fn read(run: &Run, limb: &Limb) -> Result<Self> {
        Ok(Self { compliance: compliance_table(run, limb)?, skin: touchable_skin(limb)? })
    }

    pub(super) fn skin(&self) -> &Skin {
        &self.skin
    }

    pub(super) fn n_surface(&self) -> usize {
        self.compliance.n_surface()
    }

    /// Displacement magnitudes under the frame's contacts `[n_surface]`, µm.
    pub(super) fn truth_um(&self, frame: &Frame) -> Vec<f32> {
        self.under(frame.contacts.iter().map(|c| (c.point, c.force_n)))
    }

    /// Those under the contacts that were found.
    pub(super) fn found_um(&self, contacts: &[Contact]) -> Vec<f32> {
        self.under(contacts.iter().map(|c| (c.point, c.force_n)))
    }

    fn under(&self, contacts: impl Iterator<Item = (SkinPoint, f64)>) -> Vec<f32> {
        let mut surface_um = vec![0.0; self.compliance.n_surface()];
        let mut virtual_um = vec![0.0; self.compliance.n_virtual()];
        let loads = node_loads(&self.skin, contacts);
        let scratch = &mut self.compliance.scratch();
        self.compliance.superpose(&loads, scratch, &mut surface_um, &mut virtual_um);
        surface_um
    }
}

impl MeanError {
    pub(super) fn add(&mut self, map_um: &[f32], truth_um: &[f32]) {
        let off = map_um.iter().zip(truth_um).map(|(a, b)| f64::from(a - b));
        self.sum_um += off.map(f64::abs).sum::<f64>();
        self.n += truth_um.len();
    }

    /// Over all nodes of all maps, µm.
    pub(super) fn mean_um(&self) -> f64 {
        self.sum_um / self.n.max(1) as f64
    }
}
