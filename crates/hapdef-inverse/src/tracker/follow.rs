//! The tracker: what happens in every frame.

use nalgebra::Point3;

use crate::chi_square::tail_point;
use crate::error::{InverseError, check_length};
use crate::estimator::{ContactEstimator, EstimatorParams, MAX_CONTACTS, Model, Verdict};
use crate::noise::NoiseParams;
use crate::tracker::filter::Filter;
use crate::tracker::frame::{TrackInfo, TrackedFrame};
use crate::tracker::gathered::Gathered;
use crate::tracker::hypotheses::Hypotheses;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::locate::{Fit, Locator, Refiner, Target};
use crate::tracker::metric::Metric;
use crate::tracker::pair_birth::PairBirth;
use crate::tracker::params::TrackerParams;
use crate::tracker::recent::Recent;
use crate::tracker::scan::SiteScan;

/// A whitened reading beyond this is none.
const LARGEST: f64 = 1e100;

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
    pub(super) model: Model,
    pub(super) settings: EstimatorParams,
    pub(super) params: TrackerParams,
    pub(super) mode: Mode,
    pub(super) hypotheses: Hypotheses,
    /// The best hypothesis before the contacts that move came or began to.
    pub(super) before: Hypothesis,
    pub(super) gathered: Gathered,
    /// Of the best hypothesis, for every frame.
    pub(super) metric: Metric,
    pub(super) work: Work,
    pub(super) pair_birth: PairBirth,
    pub(super) z: Vec<f64>,
    /// χ² beyond which a frame alarms, by degrees of freedom.
    alarms: Vec<f64>,
    pub(super) n_live: usize,
    pub(super) next_id: u64,
    pub(super) steps_left: usize,
    /// Whether the best hypothesis changed in this frame, so that its forces have to be solved again.
    is_changed: bool,
    /// Whether a full search was adopted since the last frame.
    pub(super) is_adopted: bool,
    /// Forces of the contacts that have come, averaged over a few frames and over more.
    pub(super) trace: [f64; 2],
    /// Whether the contacts that move have explained what was gathered of late.
    pub(super) was_good: bool,
    /// Frames, of late, that alarmed although the contacts that move were refined.
    pub(super) n_stuck: usize,
    /// Where a contact that slides was a while ago, m.
    pub(super) anchor_m: Point3<f64>,
    pub(super) recent: Recent,
    pub(super) frame: TrackedFrame,
}

/// What the tracker is busy with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mode {
    /// All contacts are held; alarms are held off for `holdoff` frames.
    Quiet { holdoff: usize },
    /// The residual was too large `age` frames ago: what is new is being decided.
    DetectionWindow { age: usize },
    /// A contact has come `age` frames ago.
    Growing { age: usize },
    /// A contact slides, `still` blocks in a row not far.
    Sliding { age: usize, still: usize },
}

/// The hypothesis whose contacts are refined.
#[derive(Clone, Copy, Debug)]
pub(super) enum HypothesisRef {
    Best,
    Candidate(usize),
}

/// Buffers that everything uses in turn.
#[derive(Clone, Debug)]
pub(super) struct Work {
    pub(super) filter: Filter,
    pub(super) locator: Locator,
    pub(super) metric: Metric,
    pub(super) scan: SiteScan,
    /// A gathered frame.
    pub(super) z: Vec<f64>,
}

impl ContactTracker {
    /// A tracker on the map, sites, noise and live gauges of `estimator`.
    ///
    /// # Errors
    /// [`InverseError`] for unusable parameters.
    pub fn new(estimator: &ContactEstimator, params: TrackerParams) -> Result<Self, InverseError> {
        params.check()?;
        let from = &estimator.model;
        let n_gauges = from.map.n_gauges();
        let mut live = vec![false; n_gauges];
        from.live.iter().for_each(|&gauge| live[gauge] = true);
        // whitened by the gauges' noise alone: what the map misses is a state of each contact
        let noise = NoiseParams { typical_force_n: 1e-9, ..estimator.noise.clone() };
        let model = Model::new(from.map.clone(), from.sites.clone(), &noise, &live)?;
        let (m, width) = (model.m, model.width);
        let empty = Hypothesis::new(&model);
        let frame = TrackedFrame {
            index: 0,
            contacts: Vec::with_capacity(MAX_CONTACTS),
            released: Vec::with_capacity(MAX_CONTACTS),
            chi2: 0.0,
            n_dof: m,
            p_value: 1.0,
            residual: vec![0.0; n_gauges],
            verdict: Verdict::Untouched,
            n_runner_ups: 0,
            info: TrackInfo::default(),
        };
        let work = Work {
            filter: Filter::new(&model, empty.stride),
            locator: Locator::new(&model),
            metric: Metric::new(m, width),
            scan: SiteScan::new(&model),
            z: vec![0.0; width],
        };
        Ok(Self {
            settings: estimator.params,
            mode: Mode::Quiet { holdoff: 0 },
            hypotheses: Hypotheses::new(&empty, params.n_hypotheses),
            gathered: Gathered::new(width),
            metric: Metric::new(m, width),
            pair_birth: PairBirth::new(&model, &empty),
            before: empty,
            work,
            z: vec![0.0; width],
            alarms: (0..=m).map(|n| tail_point(params.alarm_p, n)).collect(),
            n_live: m,
            next_id: 0,
            steps_left: 0,
            is_changed: false,
            is_adopted: false,
            trace: [0.0; 2],
            n_stuck: 0,
            was_good: false,
            anchor_m: Point3::origin(),
            recent: Recent::new(n_gauges, width),
            frame,
            params,
            model,
        })
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
        self.read(readings, live)?;
        self.steps_left = self.params.steps_per_frame;
        self.frame.info =
            TrackInfo { is_adopted: std::mem::take(&mut self.is_adopted), ..TrackInfo::default() };
        self.frame.released.clear();
        let is_alarm = self.solve();
        self.is_changed = false;
        self.recent.add(&self.model, readings, &self.z, &self.work.filter.live);
        self.recent.judge(is_alarm);
        match self.mode {
            Mode::Quiet { holdoff } => self.hold(is_alarm, holdoff),
            Mode::DetectionWindow { age } => self.detect(age + 1),
            Mode::Growing { age } => self.grow(age + 1, is_alarm),
            Mode::Sliding { age, still } => self.slide(age + 1, still, is_alarm),
        }
        self.release();
        if self.is_changed {
            self.solve();
        }
        self.report(readings);
        self.frame.index += 1;
        Ok(&self.frame)
    }

    /// What the last frame gave.
    #[must_use]
    pub fn last(&self) -> &TrackedFrame {
        &self.frame
    }

    /// Lets all contacts go and forgets what was learnt; names go on.
    pub fn reset(&mut self) {
        self.hypotheses.clear();
        self.gathered.clear();
        self.pair_birth.stop();
        self.mode = Mode::Quiet { holdoff: 0 };
        self.recent.forgive();
        self.refresh();
    }

    fn read(&mut self, readings: &[f64], live: Option<&[bool]>) -> Result<(), InverseError> {
        check_length("the readings", self.model.map.n_gauges(), readings.len())?;
        if let Some(live) = live {
            check_length("the mask of live gauges", readings.len(), live.len())?;
        }
        let m = self.model.m;
        let value = |g: usize, gauge: usize| readings[gauge] / self.model.l[g * m + g];
        let is_read = |g: usize, gauge: usize| {
            live.is_none_or(|live| live[gauge]) && value(g, gauge).abs() < LARGEST
        };
        let gauges = || self.model.live.iter().copied().enumerate();
        let n_live = gauges().filter(|&(g, gauge)| is_read(g, gauge)).count();
        if n_live < 3 {
            return Err(InverseError::TooFewGauges { n_live, needed: 3 });
        }
        let mut is_changed = false;
        for (g, gauge) in gauges() {
            let is_read = is_read(g, gauge);
            is_changed |= self.work.filter.live[g] != is_read;
            self.work.filter.live[g] = is_read;
            self.z[g] = if is_read { value(g, gauge) } else { 0.0 };
        }
        self.n_live = n_live;
        if is_changed {
            self.gathered.clear();
            self.pair_birth.stop();
            self.recent.start_over();
            self.refresh();
        }
        Ok(())
    }

    /// Forces, χ² and p of the frame for the best hypothesis; whether the residual alarms.
    pub(super) fn solve(&mut self) -> bool {
        let best = self.hypotheses.best_mut();
        let mut solved = self.metric.solve(&self.z);
        let n_dof = self.n_live.saturating_sub(best.n);
        if solved.chi2 > self.alarms[n_dof] && best.n > 0 {
            // places and map errors weigh more where forces have grown
            self.work.filter.weigh(best, &solved.forces, &mut self.metric);
            solved = self.metric.solve(&self.z);
        }
        best.set_forces(&solved.forces, 1.0);
        self.frame.chi2 = solved.chi2;
        self.frame.n_dof = n_dof;
        solved.chi2 > self.alarms[n_dof]
    }

    /// The metric of every frame for the best hypothesis as it is now.
    pub(super) fn refresh(&mut self) {
        self.is_changed = true;
        let best = self.hypotheses.best_mut();
        self.work.filter.refresh(best, &mut self.metric);
    }

    /// Refines `which`'s mobile contacts on the frame gathered by about `n` trial steps.
    pub(super) fn settle(&mut self, which: HypothesisRef, n: usize) -> Fit {
        let n_mobile = match which {
            HypothesisRef::Best => self.hypotheses.best().n_mobile(),
            HypothesisRef::Candidate(c) => self.hypotheses.candidates[c].n_mobile(),
        };
        let end = self.spend(n * n_mobile);
        let scale = self.gathered.frame(&mut self.work.z);
        let target = Target { z: &self.work.z, scale };
        let mut refiner = Refiner {
            model: &self.model,
            params: &self.settings,
            filter: &mut self.work.filter,
            metric: &mut self.work.metric,
            locator: &mut self.work.locator,
            n_trials: 0,
        };
        let hypothesis = match which {
            HypothesisRef::Best => self.hypotheses.best_mut(),
            HypothesisRef::Candidate(c) => &mut self.hypotheses.candidates[c],
        };
        let fit = refiner.settle(hypothesis, &target, end);
        let n_trials = refiner.n_trials;
        self.steps_left += end.saturating_sub(n_trials);
        self.frame.info.n_trials += n_trials;
        if let HypothesisRef::Candidate(c) = which {
            let handicap = self.hypotheses.candidates[c].handicap;
            self.hypotheses.fits[c] = Fit { cost: fit.cost + handicap, ..fit };
        }
        fit
    }

    /// Takes at most `n` steps from the frame's budget.
    pub(super) fn spend(&mut self, n: usize) -> usize {
        let spent = n.min(self.steps_left);
        self.steps_left -= spent;
        spent
    }

    /// Contacts that may be held beside the gauges read: two channels more than forces for one that
    /// comes.
    pub(super) fn most_contacts(&self) -> usize {
        self.params.max_contacts.min(self.n_live.saturating_sub(2))
    }
}
