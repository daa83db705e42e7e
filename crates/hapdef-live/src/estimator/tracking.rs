//! Contacts followed from frame to frame.

use hapdef_contact::{Alternative, Contact, Quality, Touch};
use hapdef_inverse::{
    BackgroundSearch, ContactEstimator, ContactTracker, SearchOutcome, SearchRequest, Searcher,
    SeenForces, TrackerParams,
};

use super::{
    EstimatorKind, Explained, Sight, TouchEstimator, TouchFrame, TouchWanted, bound, explain,
    noisier, range_n,
};
use crate::error::LiveError;

/// Time from a search's request to its outcome, s: what is found is taken over so many frames later,
/// wherever it ran, so that the same frames give the same contacts live and replayed. Longer than a search takes
/// where nothing else runs; one on a machine that is too busy comes late, which is counted.
const SEARCH_S: f64 = 0.04;

/// Time from when readings are begun to be explained to the answer, s: four times as long as the two searches for it
/// take, one after the other.
const EXPLAIN_S: f64 = 0.08;

/// Where a full search runs that the tracker asks for when its contacts don't explain the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SearchPlace {
    /// On a thread of its own: no frame waits for it.
    #[default]
    Background,
    /// Within the frame that asks for it, which takes milliseconds then. For replays, which have
    /// the same contacts as [`SearchPlace::Background`] unless a search there was late.
    Here,
    /// Nowhere.
    Never,
}

/// [`ContactTracker`] with full searches beside it. Contacts keep their names.
pub struct Tracking {
    estimator: ContactEstimator,
    made_with_ue: Vec<f64>,
    seen: SeenForces,
    tracker: ContactTracker,
    params: TrackerParams,
    place: SearchPlace,
    search: Search,
    /// Explains readings beside the frames, where searches run there.
    explainer: Option<BackgroundSearch>,
    explaining: Option<Explaining>,
    n_failed_searches: u64,
    n_late_searches: u64,
    /// Frames so far.
    n_frames: u64,
    pending: Option<Pending>,
    /// Added to the tracker's names, so that none comes twice when the tracker is made anew.
    first_id: u64,
    /// One more than the largest name given.
    next_id: u64,
}

/// A search whose outcome is still to be taken over.
#[derive(Clone, Copy)]
struct Pending {
    /// Before which frame.
    due: u64,
    /// The stream has begun anew since.
    is_void: bool,
}

/// Readings that are being explained.
struct Explaining {
    /// Before which frame the answer is due.
    due: u64,
    live: Vec<bool>,
    /// As they are, and mirrored `[2][n_gauges]`.
    signed: [Vec<f64>; 2],
    found: Vec<Explained>,
}

enum Search {
    Background(BackgroundSearch),
    Here(Box<(Searcher, Option<SearchOutcome>)>),
    Never,
}

impl Search {
    fn new(
        estimator: &ContactEstimator,
        params: TrackerParams,
        place: SearchPlace,
    ) -> Result<Self, LiveError> {
        Ok(match place {
            SearchPlace::Background => Self::Background(BackgroundSearch::start(
                Searcher::for_tracker(estimator.clone(), params)?,
            )?),
            SearchPlace::Here => {
                Self::Here(Box::new((Searcher::for_tracker(estimator.clone(), params)?, None)))
            }
            SearchPlace::Never => Self::Never,
        })
    }
}

fn explainer(
    estimator: &ContactEstimator,
    place: SearchPlace,
) -> Result<Option<BackgroundSearch>, LiveError> {
    let is_beside = place == SearchPlace::Background;
    Ok(is_beside.then(|| BackgroundSearch::start(Searcher::new(estimator.clone()))).transpose()?)
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
            search: Search::new(&estimator, params, place)?,
            explainer: explainer(&estimator, place)?,
            explaining: None,
            tracker: ContactTracker::new(&estimator, params)?,
            made_with_ue: estimator.gauge_sd().to_vec(),
            seen: SeenForces::new(&estimator),
            estimator,
            params,
            place,
            n_failed_searches: 0,
            n_late_searches: 0,
            n_frames: 0,
            pending: None,
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

    /// Takes over the outcome of a search that is due.
    fn adopt_if_due(&mut self) {
        let Some(pending) = self.pending.filter(|pending| pending.due <= self.n_frames) else {
            return;
        };
        let tracker = &mut self.tracker;
        let mut adopt = |outcome: &SearchOutcome| {
            if !pending.is_void {
                tracker.adopt(outcome);
            }
        };
        match &mut self.search {
            Search::Background(background) => match background.poll(adopt) {
                Ok(false) => {
                    self.n_late_searches += u64::from(pending.due == self.n_frames);
                    return;
                }
                polled => self.n_failed_searches += u64::from(polled.is_err()),
            },
            Search::Here(buffers) => match &buffers.1 {
                Some(outcome) => adopt(outcome),
                None => self.n_failed_searches += 1,
            },
            Search::Never => {}
        }
        self.pending = None;
    }

    fn frames_of(&self, time_s: f64) -> u64 {
        (time_s / self.params.frame_period_s).round().max(1.0) as u64
    }

    /// What a search finds now is of a stream that has ended.
    fn void(&mut self) {
        self.explaining = None;
        if let Some(pending) = &mut self.pending {
            pending.is_void = true;
        }
    }

    fn search_if_wanted(&mut self) {
        if self.pending.is_some() || matches!(self.search, Search::Never) {
            return;
        }
        let Some(request) = self.tracker.wanted_search() else {
            return;
        };
        let is_begun = match &mut self.search {
            Search::Background(background) => background.submit(&request),
            Search::Here(buffers) => {
                let (scratch, outcome) = &mut **buffers;
                let mut found = outcome.take().unwrap_or_default();
                *outcome = scratch.search(&request, &mut found).is_ok().then_some(found);
                true
            }
            Search::Never => false,
        };
        let due = self.n_frames + self.frames_of(SEARCH_S);
        self.pending = is_begun.then_some(Pending { due, is_void: false });
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
        let mut quality = Quality {
            verdict: frame.verdict,
            chi2: frame.chi2,
            n_dof: frame.n_dof,
            p_value: frame.p_value,
            n_alternatives: frame.n_runner_ups,
        };
        let located = frame.contacts.iter().map(|tracked| &tracked.contact);
        let (range_n, misfit_p) = (range_n(&self.estimator), self.params.misfit_p);
        bound(&mut touch.contacts, located, &mut quality, range_n, misfit_p);
        touch.quality = Some(quality);
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
        self.adopt_if_due();
        self.tracker.step(frame.readings_ue, frame.live)?;
        self.report(frame.wanted, touch);
        self.search_if_wanted();
        self.n_frames += 1;
        Ok(())
    }

    fn begin_to_explain(
        &mut self,
        readings_ue: &[f64],
        live: Option<&[bool]>,
    ) -> Result<Option<[Explained; 2]>, LiveError> {
        let found = match &self.explainer {
            Some(_) => Vec::new(),
            None => explain(&self.estimator, readings_ue, live)?.into(),
        };
        self.explaining = Some(Explaining {
            due: self.n_frames + self.frames_of(EXPLAIN_S),
            live: live.map_or_else(|| vec![true; readings_ue.len()], <[bool]>::to_vec),
            signed: [1.0, -1.0].map(|sign| readings_ue.iter().map(|r| sign * r).collect()),
            found,
        });
        Ok(None)
    }

    fn explained(&mut self) -> Option<[Explained; 2]> {
        let explaining = self.explaining.as_mut()?;
        if let Some(explainer) = &mut self.explainer {
            let estimator = &self.estimator;
            // Of the two searches for one answer, which are due in the same frame.
            let number =
                |explaining: &Explaining| 2 * explaining.due + explaining.found.len() as u64;
            let polled = explainer.poll(|outcome| {
                if outcome.frame == number(explaining) {
                    explaining.found.push(Explained::of(estimator, &outcome.estimate));
                }
            });
            if polled.is_err() {
                self.n_failed_searches += 1;
                self.explaining = None;
                return None;
            }
            if let Some(readings) = explaining.signed.get(explaining.found.len()) {
                let (frame, live) = (number(explaining), &explaining.live[..]);
                // False while it is still busy: it is asked again after the next frame.
                explainer.submit(&SearchRequest { frame, readings, live, belief: None });
            }
        }
        let is_whole = explaining.found.len() == explaining.signed.len();
        self.n_late_searches += u64::from(!is_whole && self.n_frames == explaining.due);
        if !is_whole || self.n_frames < explaining.due {
            return None;
        }
        self.explaining.take().and_then(|explaining| explaining.found.try_into().ok())
    }

    fn sight(&self) -> Option<Sight<'_>> {
        Some(Sight::new(&self.seen, &self.estimator))
    }

    fn n_late_searches(&self) -> u64 {
        self.n_late_searches
    }

    fn start_over(&mut self) {
        self.tracker.reset();
        self.void();
    }

    fn set_frame_period(&mut self, period_s: f64) -> Result<(), LiveError> {
        if self.params.frame_period_s.total_cmp(&period_s).is_eq() {
            return Ok(());
        }
        let params = TrackerParams { frame_period_s: period_s, ..self.params };
        self.tracker = ContactTracker::new(&self.estimator, params)?;
        self.params = params;
        self.first_id = self.next_id;
        self.void();
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
        self.search = Search::new(&estimator, self.params, self.place)?;
        self.explainer = explainer(&estimator, self.place)?;
        (self.pending, self.explaining) = (None, None);
        self.tracker = ContactTracker::new(&estimator, self.params)?;
        self.seen = SeenForces::new(&estimator);
        self.estimator = estimator;
        self.first_id = self.next_id;
        Ok(())
    }
}
