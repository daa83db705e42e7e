//! Finds the contacts behind one frame of readings: what is asked from outside.

use hapdef_contact::MAX_CONTACTS;

use crate::chi_square::upper_tail;
use crate::error::InverseError;
use crate::estimator::explanation::Explanation;
use crate::estimator::output::{ContactEstimate, EstimateInfo};
use crate::estimator::refine::Refiner;
use crate::estimator::report::report;
use crate::estimator::{ContactEstimator, EstimatorScratch};
use crate::skin_point::SkinPoint;

impl ContactEstimator {
    /// The contacts behind `readings` `[n_gauges]`, tared, in the unit of the map.
    ///
    /// # Errors
    /// [`InverseError::Length`]; [`InverseError::Reading`] naming a live gauge whose reading is not
    /// finite.
    pub fn estimate(&self, readings: &[f64]) -> Result<ContactEstimate, InverseError> {
        let mut estimate = ContactEstimate::default();
        self.estimate_into(readings, &mut self.scratch(), &mut estimate)?;
        Ok(estimate)
    }

    /// The same into `estimate`, without allocating once `scratch` and `estimate` have been used
    /// for such a frame, unless wide contacts are looked for. A scratch of another estimator is replaced.
    ///
    /// # Errors
    /// As [`ContactEstimator::estimate`].
    pub fn estimate_into(
        &self,
        readings: &[f64],
        scratch: &mut EstimatorScratch,
        estimate: &mut ContactEstimate,
    ) -> Result<(), InverseError> {
        self.begin(readings, scratch)?;
        let mut info = EstimateInfo::default();
        let untouched = self.untouched(scratch);
        let is_count_known = self.params.known_count.is_some();
        if is_count_known || upper_tail(untouched.chi2, self.model.m) < self.params.touch_p {
            self.find(scratch, &mut info);
        }
        report(self, readings, &untouched, scratch, &mut info, estimate);
        self.improve_by_wide(readings, estimate)
    }

    /// Contacts that start at `points` and only move downhill: no scan, no count. For following
    /// contacts from frame to frame, and for asking what readings say about a given place.
    ///
    /// # Errors
    /// As [`ContactEstimator::estimate`]; [`InverseError::TooManyContacts`] if the live gauges don't
    /// carry as many.
    pub fn refine_into(
        &self,
        readings: &[f64],
        points: &[SkinPoint],
        scratch: &mut EstimatorScratch,
        estimate: &mut ContactEstimate,
    ) -> Result<(), InverseError> {
        let (found, most) = (points.len(), (self.model.m / 3).min(MAX_CONTACTS));
        if found > most {
            return Err(InverseError::TooManyContacts { found, most });
        }
        self.begin(readings, scratch)?;
        let untouched = self.untouched(scratch);
        let mut start = Explanation::new(points);
        let mut refiner = Refiner {
            model: &self.model,
            params: &self.params,
            linear: &mut scratch.linear,
            n_steps: 0,
        };
        refiner.weigh(&mut start);
        refiner.settle(&mut start);
        let mut info = EstimateInfo {
            n_refined: 1,
            n_steps: refiner.n_steps,
            most_contacts: found,
            ..EstimateInfo::default()
        };
        scratch.found.push(start);
        report(self, readings, &untouched, scratch, &mut info, estimate);
        Ok(())
    }

    fn begin(&self, readings: &[f64], scratch: &mut EstimatorScratch) -> Result<(), InverseError> {
        if !scratch.fits(&self.model) {
            *scratch = self.scratch();
        }
        scratch.found.clear();
        self.model.whiten(readings, &mut scratch.linear.z)
    }

    fn untouched(&self, scratch: &mut EstimatorScratch) -> Explanation {
        let mut none = Explanation::new(&[]);
        scratch.linear.set_covariance(&self.model, &mut none);
        scratch.linear.evaluate(&self.model, &mut none);
        none
    }
}
