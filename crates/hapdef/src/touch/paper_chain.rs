//! The paper's chain as an estimator of contacts.

use nalgebra::Point3;

use super::{Touch, TouchContact, TouchEstimator};
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

impl TouchEstimator for PaperChain {
    fn name(&self) -> &'static str {
        "hapdefx"
    }

    fn n_gauges(&self) -> usize {
        self.readings.len()
    }

    fn estimate(&mut self, readings_ue: &[f64], touch: &mut Touch) -> Result<(), HapdefError> {
        let (expected, found) = (self.readings.len(), readings_ue.len());
        if expected != found {
            return Err(HapdefError::FrameLength { expected, found });
        }
        for (narrow, wide) in self.readings.iter_mut().zip(readings_ue) {
            *narrow = *wide as f32;
        }
        self.chain
            .maps(&self.readings, &mut self.scratch, &mut self.map_um)?;
        let candidates = self.chain.candidates(&self.map_um, &mut self.scratch)?;
        let found = self.chain.top(&candidates, self.max_contacts);
        touch.contacts.clear();
        touch
            .contacts
            .extend(found.iter().map(|contact| TouchContact {
                position_m: Point3::from(contact.position_m),
                force_n: contact.force_n,
                uncertainty: None,
            }));
        touch.quality = None;
        Ok(())
    }
}
