//! Full searches beside the tracker, in the caller's thread or one in the background.

use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::JoinHandle;

use crate::error::InverseError;
use crate::estimator::{ContactEstimate, ContactEstimator, EstimatorScratch};
use crate::tracker::exchange::{Belief, exchange};
use crate::tracker::params::TrackerParams;
use crate::tracker::workspace::Workspace;

/// A frame that the tracker wants searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchRequest<'a> {
    /// The frame after which it was made.
    pub frame: u64,
    /// Mean of the last readings `[n_gauges]`.
    pub readings: &'a [f64],
    /// Gauges that were read in all of them `[n_gauges]`.
    pub live: &'a [bool],
    /// What is believed and does not explain them; none for a search from scratch alone.
    pub belief: Option<&'a Belief>,
}

/// What a full search found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SearchOutcome {
    /// The frame of the request.
    pub frame: u64,
    /// Its contacts.
    pub estimate: ContactEstimate,
    /// What was believed, with contacts exchanged, where that explains more.
    pub(super) exchanged: Option<Belief>,
}

/// What searches: an estimator, and a tracker's model with the evidence by which its hypotheses compete.
#[derive(Clone, Debug)]
pub struct Searcher {
    estimator: ContactEstimator,
    scratch: EstimatorScratch,
    work: Option<Workspace>,
}

impl Searcher {
    /// Searches from scratch with `estimator`, for narrow contacts alone: a tracker could not follow a wide one.
    #[must_use]
    pub fn new(estimator: ContactEstimator) -> Self {
        let estimator = estimator.without_wide();
        Self { scratch: estimator.scratch(), estimator, work: None }
    }

    /// Searches for a tracker of these parameters, too.
    ///
    /// # Errors
    /// [`InverseError`] for unusable parameters.
    pub fn for_tracker(
        estimator: ContactEstimator,
        params: TrackerParams,
    ) -> Result<Self, InverseError> {
        let work = Workspace::new(&estimator, params)?;
        Ok(Self { work: Some(work), ..Self::new(estimator) })
    }

    /// Searches into `outcome`: what is believed with contacts exchanged, and from scratch where that doesn't explain the
    /// frames.
    ///
    /// # Errors
    /// As [`ContactEstimator::estimate`].
    pub fn search(
        &mut self,
        request: &SearchRequest<'_>,
        outcome: &mut SearchOutcome,
    ) -> Result<(), InverseError> {
        outcome.frame = request.frame;
        outcome.exchanged = None;
        if let (Some(work), Some(belief)) = (&mut self.work, request.belief) {
            let mut belief = belief.clone();
            let is_better = exchange(work, &mut belief);
            let is_explained = belief.is_explained(work);
            outcome.exchanged = is_better.then_some(belief);
            if is_explained {
                outcome.estimate = ContactEstimate::default();
                return Ok(());
            }
        }
        search(
            &self.estimator,
            request.readings,
            request.live,
            &mut self.scratch,
            &mut outcome.estimate,
        )
    }
}

/// The estimator drops gauges that were not read, which costs a new whitening.
fn search(
    estimator: &ContactEstimator,
    readings: &[f64],
    live: &[bool],
    scratch: &mut EstimatorScratch,
    estimate: &mut ContactEstimate,
) -> Result<(), InverseError> {
    let is_whole = estimator.model.live.iter().all(|&gauge| live[gauge]);
    if is_whole {
        return estimator.estimate_into(readings, scratch, estimate);
    }
    let both: Vec<bool> =
        (0..live.len()).map(|gauge| live[gauge] && estimator.model.live.contains(&gauge)).collect();
    estimator.masked(&both)?.estimate_into(readings, scratch, estimate)
}

#[derive(Debug)]
struct Job {
    readings: Vec<f64>,
    live: Vec<bool>,
    /// Room for what is believed; none if the searcher is for no tracker.
    belief: Option<Belief>,
    has_belief: bool,
    outcome: SearchOutcome,
    failure: Option<InverseError>,
}

/// One thread that searches, one request at a time. Nothing is allocated in the calling thread.
#[derive(Debug)]
pub struct BackgroundSearch {
    to_thread: Option<SyncSender<Box<Job>>>,
    from_thread: Receiver<Box<Job>>,
    thread: Option<JoinHandle<()>>,
    idle: Option<Box<Job>>,
}

impl BackgroundSearch {
    /// Starts the thread, which searches with `searcher`.
    ///
    /// # Errors
    /// [`InverseError::NoThread`] if the system starts none.
    pub fn start(mut searcher: Searcher) -> Result<Self, InverseError> {
        let n_gauges = searcher.estimator.map().n_gauges();
        let belief = searcher.work.as_ref().map(Belief::none);
        let (to_thread, jobs) = sync_channel::<Box<Job>>(1);
        let (results, from_thread) = sync_channel::<Box<Job>>(1);
        let work = move || {
            while let Ok(mut job) = jobs.recv() {
                let Job { readings, live, belief, has_belief, outcome, .. } = &mut *job;
                let belief = belief.as_ref().filter(|_| *has_belief);
                let request = SearchRequest { frame: outcome.frame, readings, live, belief };
                job.failure = searcher.search(&request, outcome).err();
                if results.send(job).is_err() {
                    break;
                }
            }
        };
        let thread = std::thread::Builder::new()
            .name("contact search".to_owned())
            .spawn(work)
            .map_err(|error| InverseError::NoThread { reason: error.to_string() })?;
        let idle = Job {
            readings: vec![0.0; n_gauges],
            live: vec![true; n_gauges],
            belief,
            has_belief: false,
            outcome: SearchOutcome::default(),
            failure: None,
        };
        Ok(Self {
            to_thread: Some(to_thread),
            from_thread,
            thread: Some(thread),
            idle: Some(Box::new(idle)),
        })
    }

    /// Hands `request` to the thread; `false` if it is busy or the request has other gauges.
    pub fn submit(&mut self, request: &SearchRequest<'_>) -> bool {
        let fits = |job: &Job| job.readings.len() == request.readings.len();
        let (Some(to_thread), Some(mut job)) = (&self.to_thread, self.idle.take_if(|j| fits(j)))
        else {
            return false;
        };
        job.readings.copy_from_slice(request.readings);
        job.live.copy_from_slice(request.live);
        job.outcome.frame = request.frame;
        job.has_belief = request.belief.is_some();
        if let (Some(room), Some(belief)) = (&mut job.belief, request.belief) {
            room.copy_from(belief);
        }
        to_thread.try_send(job).is_ok()
    }

    /// Calls `adopt` with what was found if a search is done since the last call; whether one was.
    ///
    /// # Errors
    /// What the search failed with; [`InverseError::NoThread`] if the thread is gone.
    pub fn poll(&mut self, adopt: impl FnOnce(&SearchOutcome)) -> Result<bool, InverseError> {
        match self.from_thread.try_recv() {
            Ok(mut job) => {
                let failure = job.failure.take();
                if failure.is_none() {
                    adopt(&job.outcome);
                }
                self.idle = Some(job);
                failure.map_or(Ok(true), Err)
            }
            Err(TryRecvError::Empty) => Ok(false),
            Err(TryRecvError::Disconnected) => {
                Err(InverseError::NoThread { reason: "it ended".to_owned() })
            }
        }
    }
}

impl Drop for BackgroundSearch {
    fn drop(&mut self) {
        self.to_thread = None;
        if let Some(thread) = self.thread.take() {
            // a thread that panicked has nothing left to say
            drop(thread.join());
        }
    }
}
