//! The tracker: what happens in every frame.

use nalgebra::Point3;

use crate::chi_square::upper_tail;
use crate::error::{InverseError, check_length};
use crate::estimator::{
    Contact, ContactEstimator, EstimatorParams, MAX_CONTACTS, Model, Verdict, WhyNot,
};
use crate::noise::NoiseParams;
use crate::tracker::belief::Belief;
use crate::tracker::filter::Filter;
use crate::tracker::frame::{TrackInfo, TrackedContact, TrackedFrame};
use crate::tracker::gathered::Gathered;
use crate::tracker::hypotheses::Hypotheses;
use crate::tracker::locate::{Fit, Locator, Target, Workshop};
use crate::tracker::metric::Metric;
use crate::tracker::pair_birth::PairBirth;
use crate::tracker::params::TrackerParams;
use crate::tracker::scan::SiteScan;

/// A whitened reading beyond this is none.
const LARGEST: f64 = 1e100;

/// A place is open if its standard deviation exceeds this share of the skin's.
const OPEN_SHARE: f64 = 0.5;

/// Frames averaged for a full search.
const N_RECENT: usize = 16;

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
    pub(super) before: Belief,
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
    /// All contacts are held; alarms are not heard for `deaf` frames.
    Quiet { deaf: usize },
    /// The residual was too large `age` frames ago.
    Inquiry { age: usize },
    /// A contact has come `age` frames ago.
    Growing { age: usize },
    /// A contact slides, `still` blocks in a row not far.
    Sliding { age: usize, still: usize },
}

/// Whose contacts are refined.
#[derive(Clone, Copy, Debug)]
pub(super) enum Whose {
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

/// The last frames, for a full search.
#[derive(Clone, Debug)]
pub(super) struct Recent {
    sum: Vec<f64>,
    pub(super) mean: Vec<f64>,
    pub(super) live: Vec<bool>,
    n: usize,
    gathering: Gathered,
    /// Those of `mean`.
    pub(super) gathered: Gathered,
    /// Frames, of late, that nothing explains.
    pub(super) n_bad: usize,
    /// Frames since a search was handed out.
    pub(super) asked: Option<usize>,
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
        let noise = NoiseParams {
            typical_force_n: 1e-9,
            ..estimator.noise.clone()
        };
        let model = Model::new(from.map.clone(), from.sites.clone(), &noise, &live)?;
        let (m, width) = (model.m, model.width);
        let empty = Belief::new(&model);
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
            mode: Mode::Quiet { deaf: 0 },
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
        self.frame.info = TrackInfo::default();
        self.frame.released.clear();
        let is_alarm = self.solve();
        self.recent
            .add(&self.model, readings, &self.z, &self.work.filter.live);
        self.recent.judge(is_alarm);
        match self.mode {
            Mode::Quiet { deaf } => self.hold(is_alarm, deaf),
            Mode::Inquiry { age } => self.inquire(age + 1),
            Mode::Growing { age } => self.grow(age + 1, is_alarm),
            Mode::Sliding { age, still } => self.slide(age + 1, still, is_alarm),
        }
        self.release();
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
        self.mode = Mode::Quiet { deaf: 0 };
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
            self.recent.clear();
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
            self.work
                .filter
                .weigh(best, &solved.forces, &mut self.metric);
            solved = self.metric.solve(&self.z);
        }
        best.set_forces(&solved.forces, 1.0);
        self.frame.chi2 = solved.chi2;
        self.frame.n_dof = n_dof;
        solved.chi2 > self.alarms[n_dof]
    }

    /// The metric of every frame for the best hypothesis as it is now.
    pub(super) fn refresh(&mut self) {
        let best = self.hypotheses.best_mut();
        self.work.filter.refresh(best, &mut self.metric);
    }

    /// Refines `whose` mobile contacts on the frame gathered, at most `n` trial steps of the budget.
    pub(super) fn settle(&mut self, whose: Whose, n: usize) -> Fit {
        let end = self.spend(n);
        let scale = self.gathered.frame(&mut self.work.z);
        let target = Target {
            z: &self.work.z,
            scale,
        };
        let mut workshop = Workshop {
            model: &self.model,
            params: &self.settings,
            filter: &mut self.work.filter,
            metric: &mut self.work.metric,
            locator: &mut self.work.locator,
            n_trials: 0,
        };
        let belief = match whose {
            Whose::Best => self.hypotheses.best_mut(),
            Whose::Candidate(c) => &mut self.hypotheses.candidates[c],
        };
        let fit = workshop.settle(belief, &target, end);
        let n_trials = workshop.n_trials;
        self.steps_left += end.saturating_sub(n_trials);
        self.frame.info.n_trials += n_trials;
        if let Whose::Candidate(c) = whose {
            self.hypotheses.fits[c] = fit;
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

    fn release(&mut self) {
        let (least_n, patience) = (self.params.release_force_n, self.params.release_frames);
        let best = self.hypotheses.best_mut();
        let mut n_released = 0;
        for i in (0..best.n).rev() {
            let slot = &mut best.slots[i];
            let sd = slot.covariance[(2, 2)].sqrt();
            let is_weak = slot.force_n < least_n || (slot.force_n < 3.0 * sd && sd < 1.0);
            slot.n_weak = if is_weak { slot.n_weak + 1 } else { 0 };
            if slot.n_weak >= patience {
                self.frame.released.push(slot.id);
                best.remove(i);
                n_released += 1;
            }
        }
        if n_released == 0 {
            return;
        }
        self.frame.info.n_released = n_released;
        for id in &self.frame.released {
            self.hypotheses.drop_contact(*id);
        }
        if self.hypotheses.best().n_mobile() == 0
            && matches!(self.mode, Mode::Growing { .. } | Mode::Sliding { .. })
        {
            self.mode = Mode::Quiet { deaf: 0 };
        }
        self.pair_birth.stop();
        self.gathered.clear();
        self.refresh();
    }

    fn report(&mut self, readings: &[f64]) {
        let best = self.hypotheses.best();
        let (frame, model) = (&mut self.frame, &self.model);
        let skin = model.skin();
        frame.contacts.clear();
        for slot in best.slots() {
            let contact = Contact {
                point: slot.point,
                position_m: skin.position(&slot.point),
                force_n: slot.force_n,
                force_vector_n: -skin.normal(&slot.point) * slot.force_n,
                covariance: slot.covariance,
            };
            frame.contacts.push(TrackedContact {
                id: slot.id,
                phase: slot.phase,
                age_frames: frame.index.saturating_sub(slot.born),
                contact,
            });
        }
        for (g, &gauge) in model.live.iter().enumerate() {
            let explained: f64 = (0..best.n)
                .map(|i| best.slots[i].force_n * best.atoms[i * best.width + g])
                .sum();
            let is_read = self.work.filter.live[g];
            let left = readings[gauge] - explained * model.l[g * model.m + g];
            frame.residual[gauge] = if is_read { left } else { 0.0 };
        }
        frame.p_value = upper_tail(frame.chi2, frame.n_dof);
        frame.n_runner_ups = self.hypotheses.n_alive() - 1;
        frame.info.is_inquiry = matches!(self.mode, Mode::Inquiry { .. });
        self.frame.verdict = self.verdict();
    }

    /// Standard deviation of a place anywhere on the skin, m.
    pub(super) fn skin_sd_m(&self) -> f64 {
        (self.model.skin().area_m2() / std::f64::consts::TAU).sqrt()
    }

    fn verdict(&self) -> Verdict {
        let contacts = &self.frame.contacts;
        let skin_sd_m = self.skin_sd_m();
        let open = |c: &TrackedContact| {
            let p = &c.contact.covariance;
            let (a, b, d) = (p[(0, 0)], p[(0, 1)], p[(1, 1)]);
            let largest = 0.5 * (a + d) + (0.25 * (a - d).powi(2) + b * b).sqrt();
            largest.sqrt() > OPEN_SHARE * skin_sd_m
        };
        if self.frame.p_value < self.params.misfit_p {
            Verdict::NotIdentifiable(WhyNot::Misfit)
        } else if contacts.is_empty() {
            Verdict::Untouched
        } else if contacts.iter().any(open) {
            Verdict::NotIdentifiable(WhyNot::SingularInformation)
        } else if self.hypotheses.lead() <= self.settings.tie_delta {
            Verdict::NotIdentifiable(WhyNot::TiedExplanations)
        } else {
            Verdict::Identified
        }
    }
}

impl Recent {
    fn new(n_gauges: usize, width: usize) -> Self {
        Self {
            sum: vec![0.0; n_gauges],
            mean: vec![0.0; n_gauges],
            live: vec![false; n_gauges],
            n: 0,
            gathering: Gathered::new(width),
            gathered: Gathered::new(width),
            n_bad: 0,
            asked: None,
        }
    }

    fn add(&mut self, model: &Model, readings: &[f64], z: &[f64], live: &[bool]) {
        for (g, &gauge) in model.live.iter().enumerate() {
            self.live[gauge] = live[g];
            self.sum[gauge] += if live[g] { readings[gauge] } else { 0.0 };
        }
        self.gathering.add(z, 1.0);
        self.n += 1;
        if self.n == N_RECENT {
            for (mean, sum) in self.mean.iter_mut().zip(&self.sum) {
                *mean = sum / N_RECENT as f64;
            }
            self.gathered.copy_from(&self.gathering);
            self.clear();
        }
        self.asked = self.asked.map(|n| n + 1);
    }

    fn clear(&mut self) {
        self.sum.fill(0.0);
        self.gathering.clear();
        self.n = 0;
    }

    fn judge(&mut self, is_alarm: bool) {
        self.n_bad = if is_alarm {
            self.n_bad + 1
        } else {
            self.n_bad.saturating_sub(1)
        };
    }

    pub(super) fn forgive(&mut self) {
        self.n_bad = 0;
        self.asked = None;
    }
}

/// The χ² with upper tail `p`; infinite without degrees of freedom.
fn tail_point(p: f64, n_dof: usize) -> f64 {
    if n_dof == 0 {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (0.0, 1e4);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if upper_tail(middle, n_dof) > p {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
