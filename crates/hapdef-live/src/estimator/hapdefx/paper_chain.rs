//! The paper's chain as an estimator of contacts.

use hapdef_contact::{Contact, Touch};
use nalgebra::Point3;

use super::super::{EstimatorKind, Sight, TouchEstimator, TouchFrame};
use super::{FoundContact, Hapdefx, HapdefxScratch};
use crate::error::LiveError;

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
    range_n: f64,
}

impl PaperChain {
    /// Wraps the trained chain of a limb whose touches are expected to have up to `range_n` N.
    #[must_use]
    pub fn new(chain: Hapdefx, max_contacts: usize, range_n: f64) -> Self {
        Self {
            scratch: HapdefxScratch::default(),
            readings: vec![0.0; chain.n_gauges()],
            map_um: vec![0.0; chain.n_surface()],
            chain,
            max_contacts,
            range_n,
        }
    }

    fn find(&mut self, touch: &mut Touch) -> Result<(), LiveError> {
        self.chain.maps(&self.readings, &mut self.scratch, &mut self.map_um)?;
        let candidates = self.chain.candidates(&self.map_um, &mut self.scratch)?;
        let found = self.chain.top(&candidates, self.max_contacts);
        let contact =
            |found: &FoundContact| Contact::new(Point3::from(found.position_m), found.force_n);
        touch.contacts.extend(found.iter().map(contact));
        Ok(())
    }
}

impl TouchEstimator for PaperChain {
    fn name(&self) -> &'static str {
        EstimatorKind::Hapdefx.name()
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
        self.find(touch)
    }

    /// The nets were trained with all gauges and say nothing of how sure they are: without one of them nothing is
    /// seen, and no force beyond the range is the range's end by noise.
    fn sight(&self) -> Option<Sight<'_>> {
        Some(Sight { seen: None, range_n: self.range_n, loads: None })
    }
}
