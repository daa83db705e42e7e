//! Finds the contacts behind readings: what is asked from outside.

use std::sync::Arc;

use crate::chi_square::upper_tail;
use crate::error::InverseError;
use crate::estimator::effective_rank::effective_rank;
use crate::estimator::explanation::{Explanation, MAX_CONTACTS};
use crate::estimator::output::{ContactEstimate, EstimateInfo};
use crate::estimator::refine::Refiner;
use crate::estimator::report::report;
use crate::estimator::{EstimatorParams, EstimatorScratch, Model};
use crate::noise::NoiseParams;
use crate::response::ResponseMap;
use crate::sites::ScanSites;
use crate::skin_point::SkinPoint;

/// Finds the contacts behind readings.
#[derive(Clone, Debug)]
pub struct ContactEstimator {
    pub(crate) model: Model,
    pub(crate) noise: NoiseParams,
    pub(crate) params: EstimatorParams,
    /// Directions in which contacts move the readings beyond the noise.
    pub(crate) effective_rank: usize,
}

impl ContactEstimator {
    /// An estimator for the map `map`, scanned at `sites`, all gauges alive.
    ///
    /// # Errors
    /// [`InverseError`] for unusable parameters, a wrong length, fewer than three gauges.
    pub fn new(
        map: Arc<ResponseMap>,
        sites: Arc<ScanSites>,
        noise: NoiseParams,
        params: EstimatorParams,
    ) -> Result<Self, InverseError> {
        params.check()?;
        let live = vec![true; map.n_gauges()];
        Self::with_gauges(map, sites, noise, params, &live)
    }

    /// The same estimator with only the gauges of `live` `[n_gauges]`: readings of the others are
    /// not looked at, and every covariance grows accordingly.
    ///
    /// # Errors
    /// [`InverseError::TooFewGauges`] with fewer than three alive; [`InverseError::Length`].
    pub fn masked(&self, live: &[bool]) -> Result<Self, InverseError> {
        let (map, sites) = (self.model.map.clone(), self.model.sites.clone());
        Self::with_gauges(map, sites, self.noise.clone(), self.params, live)
    }

    /// Standard deviation of each gauge's noise `[n_gauges]`, in the unit of the map, without what its
    /// converter adds.
    #[must_use]
    pub fn gauge_sd(&self) -> &[f64] {
        &self.noise.gauge_sd
    }

    /// The same estimator with other noise `[n_gauges]`.
    ///
    /// # Errors
    /// [`InverseError`] for a wrong length or a value that is not above 0.
    pub fn with_gauge_sd(&self, gauge_sd: &[f64]) -> Result<Self, InverseError> {
        let (map, sites) = (self.model.map.clone(), self.model.sites.clone());
        let noise = NoiseParams { gauge_sd: gauge_sd.to_vec(), ..self.noise.clone() };
        let mut live = vec![false; map.n_gauges()];
        self.model.live.iter().for_each(|&gauge| live[gauge] = true);
        Self::with_gauges(map, sites, noise, self.params, &live)
    }

    fn with_gauges(
        map: Arc<ResponseMap>,
        sites: Arc<ScanSites>,
        noise: NoiseParams,
        params: EstimatorParams,
        live: &[bool],
    ) -> Result<Self, InverseError> {
        let mut model = Model::new(map, sites, &noise, live)?;
        model.max_force_n = params.max_force_n;
        let (map, sites) = (&model.map, &model.sites);
        let estimator = Self {
            effective_rank: effective_rank(map, sites, &noise, &model.live, params.force_scale_n),
            model,
            noise,
            params,
        };
        if estimator.most_contacts() > 1 {
            // now, not in the first frame that asks for pairs
            estimator.model.gram();
        }
        Ok(estimator)
    }

    /// The response map.
    #[must_use]
    pub fn map(&self) -> &ResponseMap {
        &self.model.map
    }

    /// The most contacts that are looked for: a contact takes three unknowns, so the live gauges
    /// carry one for every three of them. Gauges that contacts of the expected force don't move
    /// beyond their noise don't count, nor those that only repeat others; one contact is always
    /// looked for.
    #[must_use]
    pub fn most_contacts(&self) -> usize {
        let wanted = self.params.known_count.unwrap_or(self.params.max_contacts);
        wanted.min((self.effective_rank / 3).max(1))
    }

    /// Buffers for [`ContactEstimator::estimate_into`].
    #[must_use]
    pub fn scratch(&self) -> EstimatorScratch {
        EstimatorScratch::new(&self.model)
    }

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
    /// for such a frame. A scratch of another estimator is replaced.
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
            for n in 1..=self.most_contacts() {
                self.search(n, scratch, &mut info);
                info.most_contacts = n;
                let is_any_good = |p: f64, found: &[Explanation]| {
                    found.iter().any(|e| e.n == n && self.is_good(e, p))
                };
                if n == 1 && !is_any_good(self.params.accept_p, &scratch.found) {
                    self.search_wider(scratch, &mut info);
                }
                if !is_count_known && is_any_good(self.enough_p(n), &scratch.found) {
                    break;
                }
            }
        }
        report(self, readings, &untouched, scratch, &mut info, estimate);
        Ok(())
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

    pub(crate) fn p_value(&self, e: &Explanation) -> f64 {
        upper_tail(e.chi2, self.model.m.saturating_sub(3 * e.n))
    }

    /// Whether no force is beyond what is possible.
    pub(crate) fn is_believed(&self, e: &Explanation) -> bool {
        e.forces[..e.n].iter().all(|&a| a <= self.params.max_force_n)
    }

    fn untouched(&self, scratch: &mut EstimatorScratch) -> Explanation {
        let mut none = Explanation::new(&[]);
        scratch.linear.set_covariance(&self.model, &mut none);
        scratch.linear.evaluate(&self.model, &mut none);
        none
    }
}
