//! The paper's chain as an estimator of contacts.

use hapdef_live::LiveError;
use hapdef_live::touch::{Touch, TouchContact, TouchEstimator, TouchFrame};
use nalgebra::Point3;

use crate::error::HapdefError;
use crate::estimator::{Hapdefx, HapdefxScratch};

/// [`Hapdefx`] with its buffers.
///
/// The paper is given the number of contacts T. Here every candidate above the floor counts, the
/// `max_contacts` of greatest force at most.
pub struct PaperChain {
    chain: Hapdefx,
    scratch: HapdefxScratch,
    readings: Vec<f32>,
    map_um: Vec<f32>,
    max_contacts: usize,
}

impl PaperChain {
    /// Wraps the trained chain of a limb with `n_gauges` gauges and `n_surface` surface nodes.
    #[must_use]
    pub fn new(chain: Hapdefx, n_gauges: usize, n_surface: usize, max_contacts: usize) -> Self {
        Self {
            chain,
            scratch: HapdefxScratch::default(),
            readings: vec![0.0; n_gauges],
            map_um: vec![0.0; n_surface],
            max_contacts,
        }
    }
}

impl PaperChain {
    fn find(&mut self, touch: &mut Touch) -> Result<(), HapdefError> {
        self.chain
            .maps(&self.readings, &mut self.scratch, &mut self.map_um)?;
        let candidates = self.chain.candidates(&self.map_um, &mut self.scratch)?;
        let found = self.chain.top(&candidates, self.max_contacts);
        let contacts = found.iter().map(|contact| TouchContact {
            position_m: Point3::from(contact.position_m),
            force_n: contact.force_n,
            direction: None,
            id: None,
            phase: None,
            uncertainty: None,
        });
        touch.contacts.extend(contacts);
        Ok(())
    }
}

impl TouchEstimator for PaperChain {
    fn name(&self) -> &'static str {
        "hapdefx"
    }

    fn n_gauges(&self) -> usize {
        self.readings.len()
    }

    /// The nets know no gauges that don't count: their readings are taken as they are.
    fn estimate_frame(
        &mut self,
        frame: &TouchFrame<'_>,
        touch: &mut Touch,
    ) -> Result<(), LiveError> {
        frame.check(self.readings.len())?;
        for (narrow, wide) in self.readings.iter_mut().zip(frame.readings_ue) {
            *narrow = *wide as f32;
        }
        touch.clear();
        let name = self.name();
        self.find(touch).map_err(|error| LiveError::Estimator {
            name,
            source: error.into(),
        })
    }
}
