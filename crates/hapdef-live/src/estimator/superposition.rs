//! Contacts of every frame on its own, by superposition.

use hapdef_contact::{Alternative, Quality, Touch};
use hapdef_inverse::{ContactEstimate, ContactEstimator, EstimatorScratch, SeenForces};

use super::{
    EstimatorKind, Explained, Sight, TouchEstimator, TouchFrame, TouchWanted, bound, explain,
    noisier, range_n,
};
use crate::error::LiveError;

/// [`ContactEstimator`] with its buffers. When gauges fail it is whitened anew without them, which
/// takes milliseconds once.
pub struct Superposition {
    estimator: ContactEstimator,
    made_with_ue: Vec<f64>,
    seen: SeenForces,
    scratch: EstimatorScratch,
    masked: Option<Masked>,
    estimate: ContactEstimate,
}

/// The estimator without the gauges that don't count.
struct Masked {
    live: Vec<bool>,
    estimator: ContactEstimator,
    scratch: EstimatorScratch,
}

impl Superposition {
    /// Wraps an estimator.
    #[must_use]
    pub fn new(estimator: ContactEstimator) -> Self {
        Self {
            scratch: estimator.scratch(),
            masked: None,
            estimate: ContactEstimate::default(),
            made_with_ue: estimator.gauge_sd().to_vec(),
            seen: SeenForces::new(&estimator),
            estimator,
        }
    }

    /// The estimator, its buffers dropped.
    #[must_use]
    pub fn into_estimator(self) -> ContactEstimator {
        self.estimator
    }

    fn search(&mut self, frame: &TouchFrame<'_>) -> Result<(), LiveError> {
        let readings = frame.readings_ue;
        let estimate = &mut self.estimate;
        let Some(live) = frame.live.filter(|live| !live.iter().all(|l| *l)) else {
            let estimator = &self.estimator;
            return Ok(estimator.estimate_into(readings, &mut self.scratch, estimate)?);
        };
        let masked = match self.masked.take().filter(|masked| masked.live == live) {
            Some(masked) => masked,
            None => Masked::new(&self.estimator, live)?,
        };
        let masked = self.masked.insert(masked);
        let estimator = &masked.estimator;
        Ok(estimator.estimate_into(readings, &mut masked.scratch, estimate)?)
    }

    fn report(&self, wanted: TouchWanted, touch: &mut Touch) {
        let (skin, estimate) = (self.estimator.map().skin(), &self.estimate);
        touch.clear();
        let with_uncertainty = wanted.uncertainty;
        let contacts = estimate.contacts.iter().map(|found| found.contact(skin, with_uncertainty));
        touch.contacts.extend(contacts);
        if wanted.alternatives {
            let others = estimate.runner_ups.iter().map(|other| {
                let places = other.points().iter().map(|point| skin.position(point));
                Alternative::new(other.delta_cost, places.zip(other.forces_n().iter().copied()))
            });
            touch.alternatives.extend(others);
        }
        let mut quality = Quality {
            verdict: estimate.verdict,
            chi2: estimate.chi2,
            n_dof: estimate.n_dof,
            p_value: estimate.p_value,
            n_alternatives: estimate.runner_ups.len(),
        };
        let (range_n, misfit_p) = (range_n(&self.estimator), self.estimator.params().misfit_p);
        bound(&mut touch.contacts, estimate.contacts.iter(), &mut quality, range_n, misfit_p);
        touch.quality = Some(quality);
    }
}

impl TouchEstimator for Superposition {
    fn name(&self) -> &'static str {
        EstimatorKind::Superposition.name()
    }

    fn n_gauges(&self) -> usize {
        self.estimator.map().n_gauges()
    }

    fn estimate_frame(
        &mut self,
        frame: &TouchFrame<'_>,
        touch: &mut Touch,
    ) -> Result<(), LiveError> {
        frame.check(self.n_gauges())?;
        self.search(frame)?;
        self.report(frame.wanted, touch);
        Ok(())
    }

    fn explain(
        &mut self,
        readings_ue: &[f64],
        live: Option<&[bool]>,
    ) -> Result<Option<[Explained; 2]>, LiveError> {
        explain(&self.estimator, readings_ue, live).map(Some)
    }

    fn sight(&self) -> Option<Sight<'_>> {
        Some(Sight::new(&self.seen, &self.estimator))
    }

    fn set_least_noise(&mut self, least_ue: &[f64]) -> Result<(), LiveError> {
        if let Some(estimator) = noisier(&self.estimator, &self.made_with_ue, least_ue)? {
            self.scratch = estimator.scratch();
            self.masked = None;
            self.seen = SeenForces::new(&estimator);
            self.estimator = estimator;
        }
        Ok(())
    }
}

impl Masked {
    fn new(whole: &ContactEstimator, live: &[bool]) -> Result<Self, LiveError> {
        let estimator = whole.masked(live)?;
        Ok(Self { live: live.to_vec(), scratch: estimator.scratch(), estimator })
    }
}
