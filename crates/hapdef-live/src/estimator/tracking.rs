//! Contacts followed from frame to frame.

use hapdef_contact::{Alternative, Contact, Quality, Touch};
use hapdef_inverse::{
    BackgroundSearch, ContactEstimator, ContactTracker, EstimatorScratch, SearchOutcome,
    TrackerParams,
};

use super::{EstimatorKind, Explained, TouchEstimator, TouchFrame, TouchWanted, explain, noisier};
use crate::error::LiveError;

/// Where a full search runs that the tracker asks for when its contacts don't explain the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SearchPlace {
    /// On a thread of its own: no frame waits for it, and when its outcome is adopted depends on
    /// the clock.
    #[default]
    Background,
    /// Within the frame that asks for it, which takes milliseconds then: the same frames always
    /// give the same contacts. For replays.
    Here,
    /// Nowhere.
    Never,
}

/// [`ContactTracker`] with full searches beside it. Contacts keep their names.
pub struct Tracking {
    estimator: ContactEstimator,
    made_with_ue: Vec<f64>,
    tracker: ContactTracker,
    params: TrackerParams,
    place: SearchPlace,
    search: Search,
    n_failed_searches: u64,
    /// Added to the tracker's names, so that none comes twice when the tracker is made anew.
    first_id: u64,
    /// One more than the largest name given.
    next_id: u64,
}

enum Search {
    Background(BackgroundSearch),
    Here(Box<(EstimatorScratch, SearchOutcome)>),
    Never,
}

impl Search {
    fn new(estimator: &ContactEstimator, place: SearchPlace) -> Result<Self, LiveError> {
        Ok(match place {
            SearchPlace::Background => {
                Self::Background(BackgroundSearch::start(estimator.clone())?)
            }
            SearchPlace::Here => {
                Self::Here(Box::new((estimator.scratch(), SearchOutcome::default())))
            }
            SearchPlace::Never => Self::Never,
        })
    }
}

impl Tracking {
    /// Follows contacts on the map, sites and noise of `estimator`.
    ///
    /// # Errors
    /// [`LiveError::Inverse`] for unusable parameters, or if no thread can be started.
    pub fn new(
        estimator: ContactEstimator,
        params: TrackerParams,
        place: SearchPlace,
    ) -> Result<Self, LiveError> {
        Ok(Self {
            search: Search::new(&estimator, place)?,
            tracker: ContactTracker::new(&estimator, params)?,
            made_with_ue: estimator.gauge_sd().to_vec(),
            estimator,
            params,
            place,
            n_failed_searches: 0,
            first_id: 0,
            next_id: 0,
        })
    }

    /// The tracker.
    #[must_use]
    pub fn tracker(&self) -> &ContactTracker {
        &self.tracker
    }

    /// Full searches that failed; following went on without them.
    #[must_use]
    pub fn n_failed_searches(&self) -> u64 {
        self.n_failed_searches
    }

    fn adopt_background(&mut self) {
        if let Search::Background(background) = &mut self.search {
            let tracker = &mut self.tracker;
            let polled = background.poll(|outcome| {
                tracker.adopt(outcome);
            });
            self.n_failed_searches += u64::from(polled.is_err());
        }
    }

    fn search_if_wanted(&mut self) {
        if matches!(self.search, Search::Never) {
            return;
        }
        let Some(request) = self.tracker.wanted_search() else {
            return;
        };
        match &mut self.search {
            Search::Background(background) => {
                // a busy thread is asked again when the tracker asks again
                background.submit(&request);
            }
            Search::Here(buffers) => {
                let (scratch, outcome) = &mut **buffers;
                if request.run(&self.estimator, scratch, outcome).is_ok() {
                    self.tracker.adopt(outcome);
                } else {
                    self.n_failed_searches += 1;
                }
            }
            Search::Never => {}
        }
    }

    fn report(&mut self, wanted: TouchWanted, touch: &mut Touch) {
        let (skin, frame) = (self.estimator.map().skin(), self.tracker.last());
        let first_id = self.first_id;
        touch.clear();
        let contacts = frame.contacts.iter().map(|tracked| Contact {
            id: Some(first_id + tracked.id.0),
            phase: Some(tracked.phase),
            ..tracked.contact.contact(skin, wanted.uncertainty)
        });
        touch.contacts.extend(contacts);
        let released = frame.released.iter().map(|id| first_id + id.0);
        touch.released.extend(released);
        let largest = touch.contacts.iter().filter_map(|contact| contact.id).max();
        self.next_id = self.next_id.max(largest.map_or(0, |id| id + 1));
        if wanted.alternatives {
            let others = self.tracker.runner_ups();
            let others = others.map(|(delta, contacts)| Alternative::new(delta, contacts));
            touch.alternatives.extend(others);
            let by_delta = |a: &Alternative, b: &Alternative| a.delta_cost.total_cmp(&b.delta_cost);
            touch.alternatives.sort_unstable_by(by_delta);
        }
        touch.quality = Some(Quality {
            verdict: frame.verdict,
            chi2: frame.chi2,
            n_dof: frame.n_dof,
            p_value: frame.p_value,
            n_alternatives: frame.n_runner_ups,
        });
    }
}

impl TouchEstimator for Tracking {
    fn name(&self) -> &'static str {
        EstimatorKind::Tracking.name()
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
        self.adopt_background();
        self.tracker.step(frame.readings_ue, frame.live)?;
        self.report(frame.wanted, touch);
        self.search_if_wanted();
        Ok(())
    }

    fn start_over(&mut self) {
        self.tracker.reset();
    }

    fn set_frame_period(&mut self, period_s: f64) -> Result<(), LiveError> {
        if self.params.frame_period_s.total_cmp(&period_s).is_eq() {
            return Ok(());
        }
        let params = TrackerParams { frame_period_s: period_s, ..self.params };
        self.tracker = ContactTracker::new(&self.estimator, params)?;
        self.params = params;
        self.first_id = self.next_id;
        Ok(())
    }

    fn explain(
        &mut self,
        readings_ue: &[f64],
        live: Option<&[bool]>,
    ) -> Result<Option<[Explained; 2]>, LiveError> {
        explain(&self.estimator, readings_ue, live).map(Some)
    }

    fn set_least_noise(&mut self, least_ue: &[f64]) -> Result<(), LiveError> {
        let Some(estimator) = noisier(&self.estimator, &self.made_with_ue, least_ue)? else {
            return Ok(());
        };
        self.search = Search::new(&estimator, self.place)?;
        self.tracker = ContactTracker::new(&estimator, self.params)?;
        self.estimator = estimator;
        self.first_id = self.next_id;
        Ok(())
    }
}
