//! The tracker: what happens in every frame.

use nalgebra::Point3;

use crate::error::InverseError;
use crate::estimator::ContactEstimator;
use crate::tracker::adopt::adopt;
use crate::tracker::exchange::Belief;
use crate::tracker::frame::{TrackInfo, TrackedFrame};
use crate::tracker::params::TrackerParams;
use crate::tracker::recent::Recent;
use crate::tracker::release::release;
use crate::tracker::report::report;
use crate::tracker::search::{SearchOutcome, SearchRequest};
use crate::tracker::state::State;
use crate::tracker::workspace::Workspace;
use crate::tracker::{detection, growing, holding, sliding};

/// A search that found nothing better is asked for again after so many times the frames that
/// made it wanted: the next would find the same, and a search takes milliseconds of a core. With 8 a press that
/// came while the first ran was not searched for during half a second.
const PATIENCE: usize = 2;

/// Follows contacts from frame to frame: births, holds, slides, releases.
///
/// In every frame the forces of the contacts there are solved again, 0 or more, and the residual is
/// tested. Held contacts' places and the map's errors there sharpen as frames add up (an extended
/// Kalman filter, the map's error at each contact a constant state of its own); where the residual
/// says that something is new, a contact more, a slide and an alternative hypothesis compete by
/// evidence. Whatever happens, the work in one frame is bounded by
/// [`TrackerParams::steps_per_frame`], and nothing is allocated.
#[derive(Clone, Debug)]
pub struct ContactTracker {
    state: State,
    work: Workspace,
    recent: Recent,
    /// Whether a full search was adopted since the last frame.
    is_adopted: bool,
    /// For a full search.
    belief: Belief,
}

impl ContactTracker {
    /// A tracker on the map, sites, noise and live gauges of `estimator`.
    ///
    /// # Errors
    /// [`InverseError`] for unusable parameters.
    pub fn new(estimator: &ContactEstimator, params: TrackerParams) -> Result<Self, InverseError> {
        params.check()?;
        let work = Workspace::new(estimator, params)?;
        let recent = Recent::new(work.model.map.n_gauges(), work.model.width);
        let belief = Belief::none(&work);
        Ok(Self { state: State::HOLDING, work, recent, is_adopted: false, belief })
    }

    /// Takes the next frame: `readings` `[n_gauges]`, tared, in the unit of the map. Gauges that are
    /// not `live` `[n_gauges]` and readings that are not finite are left out of this frame.
    ///
    /// # Errors
    /// [`InverseError::Length`]; [`InverseError::TooFewGauges`] with fewer than three read. The
    /// tracker is as it was before.
    pub fn step(
        &mut self,
        readings: &[f64],
        live: Option<&[bool]>,
    ) -> Result<&TrackedFrame, InverseError> {
        let Self { state, work, recent, .. } = self;
        if work.read(readings, live)? {
            recent.start_over();
        }
        work.steps_left = work.params.steps_per_frame;
        work.frame.info =
            TrackInfo { is_adopted: std::mem::take(&mut self.is_adopted), ..TrackInfo::default() };
        work.frame.released.clear();
        let is_alarm = work.solve();
        work.is_changed = false;
        recent.add(&work.model, readings, &work.z, &work.buffers.filter.live);
        recent.judge(is_alarm || work.is_beyond(work.hypotheses.best()));
        let next = match *state {
            State::Holding(now) => holding::step(now, work, is_alarm),
            State::Detecting(now) => detection::step(now, work),
            State::Growing(now) => growing::step(now, work, is_alarm),
            State::Sliding(now) => sliding::step(now, work),
        };
        *state = release(next, work);
        let is_explained = matches!(state, State::Holding(_)) && recent.n_bad == 0;
        if is_explained {
            work.trust();
        }
        if work.is_changed {
            work.solve();
        }
        report(work, readings, matches!(state, State::Detecting(_)));
        work.frame.index += 1;
        Ok(&work.frame)
    }

    /// What the last frame gave.
    #[must_use]
    pub fn last(&self) -> &TrackedFrame {
        &self.work.frame
    }

    /// Lets all contacts go and forgets what was learnt; names go on.
    pub fn reset(&mut self) {
        self.work.hypotheses.clear();
        self.work.trusted.n = 0;
        self.work.gathered.clear();
        self.work.pair_birth.stop();
        self.state = State::HOLDING;
        self.recent.forgive();
        self.work.refresh();
    }

    /// What else may explain the frames so far, in no order: how much worse it is than the best
    /// explanation in −2 ln evidence, and its contacts' places, m, and normal forces, N. There are
    /// [`crate::TrackedFrame::n_runner_ups`].
    pub fn runner_ups(
        &self,
    ) -> impl Iterator<Item = (f64, impl Iterator<Item = (Point3<f64>, f64)>)> {
        let hypotheses = &self.work.hypotheses;
        let best = hypotheses.best().cost();
        let skin = self.work.model.skin();
        hypotheses.others().iter().map(move |other| {
            let tracks = other.tracks().iter();
            let contacts = tracks.map(move |track| (skin.position(&track.point), track.force_n));
            (other.cost() - best, contacts)
        })
    }

    /// The frames that a full search should look at, once for each time that one is wanted: when no
    /// hypothesis has explained [`crate::TrackerParams::search_frames`] frames.
    pub fn wanted_search(&mut self) -> Option<SearchRequest<'_>> {
        let recent = &mut self.recent;
        let params = &self.work.params;
        let patience = params.search_frames;
        let is_new = recent.asked.is_none_or(|n| n > PATIENCE * patience);
        if recent.n_bad < patience || !is_new || recent.gathered.n_frames == 0 {
            return None;
        }
        recent.asked = Some(0);
        self.belief.take(&self.work, &recent.gathered);
        Some(SearchRequest {
            frame: self.work.frame.index,
            readings: &recent.mean,
            live: &recent.live,
            belief: Some(&self.belief),
        })
    }

    /// Takes the contacts that a full search found, if they explain the latest frames better than
    /// the best hypothesis; whether it did. Contacts near those that were there keep their names.
    pub fn adopt(&mut self, outcome: &SearchOutcome) -> bool {
        let Self { state, work, recent, .. } = self;
        if recent.gathered.n_frames == 0 {
            return false;
        }
        let adopted = adopt(work, recent, outcome);
        if let Some(next) = adopted {
            *state = next;
            recent.forgive();
            self.is_adopted = true;
        } else if work.hypotheses.best().n_mobile() == 0 {
            *state = State::HOLDING;
        }
        adopted.is_some()
    }
}
