//! What every state works with: the model, the hypotheses, the frames gathered, and the frame's answer.

use hapdef_contact::Verdict;

use crate::chi_square::{tail_point, upper_tail};
use crate::error::{InverseError, check_length};
use crate::estimator::{ContactEstimator, EstimatorParams, MAX_CONTACTS, Model};
use crate::noise::NoiseParams;
use crate::tracker::filter::Filter;
use crate::tracker::frame::{TrackInfo, TrackedFrame};
use crate::tracker::gathered::Gathered;
use crate::tracker::hypotheses::{Hypotheses, HypothesisRef};
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::locate::{Fit, Locator, Refiner, Target};
use crate::tracker::metric::Metric;
use crate::tracker::pair_birth::PairBirth;
use crate::tracker::params::TrackerParams;
use crate::tracker::scan::SiteScan;

/// A whitened reading beyond this is none.
const LARGEST: f64 = 1e100;

/// Contacts with more than so many times the strongest force that touches have don't explain a frame, whatever its
/// residual: half a second of misfits else went by without a search. The map's error makes up the rest.
const BEYOND: f64 = 1.05;

/// What every state works with.
#[derive(Clone, Debug)]
pub(super) struct Workspace {
    pub(super) model: Model,
    pub(super) settings: EstimatorParams,
    pub(super) params: TrackerParams,
    pub(super) hypotheses: Hypotheses,
    /// The best hypothesis before the contacts that move came or began to.
    pub(super) before: Hypothesis,
    /// The best hypothesis when last all contacts were held and explained the frames: what comes at once beside them may drag
    /// them away before it is found.
    pub(super) trusted: Hypothesis,
    pub(super) gathered: Gathered,
    /// Of the best hypothesis, for every frame.
    pub(super) metric: Metric,
    pub(super) buffers: Buffers,
    pub(super) pair_birth: PairBirth,
    /// The frame, whitened by the noise `[width]`.
    pub(super) z: Vec<f64>,
    /// χ² beyond which a frame alarms, by degrees of freedom.
    alarms: Vec<f64>,
    pub(super) n_live: usize,
    /// Numbers of a frame that loads which are no contacts take.
    n_taken: usize,
    pub(super) next_id: u64,
    pub(super) steps_left: usize,
    /// Whether the best hypothesis changed in this frame, so that its forces have to be solved again.
    pub(super) is_changed: bool,
    pub(super) frame: TrackedFrame,
}

/// Buffers that everything uses in turn.
#[derive(Clone, Debug)]
pub(super) struct Buffers {
    pub(super) filter: Filter,
    pub(super) locator: Locator,
    pub(super) metric: Metric,
    pub(super) scan: SiteScan,
    /// A gathered frame.
    pub(super) z: Vec<f64>,
}

impl Workspace {
    /// On the map, sites, noise and live gauges of `estimator`.
    pub(super) fn new(
        estimator: &ContactEstimator,
        params: TrackerParams,
    ) -> Result<Self, InverseError> {
        let from = &estimator.model;
        let n_gauges = from.map.n_gauges();
        let mut live = vec![false; n_gauges];
        from.live.iter().for_each(|&gauge| live[gauge] = true);
        // whitened by the gauges' noise alone: what the map misses is a state of each contact
        // and what is no contact stays while frames add up: the filter has it
        let n_taken = estimator.noise.n_taken(&from.live);
        let mut noise = NoiseParams { typical_force_n: 1e-9, ..estimator.noise.clone() };
        let loads = std::mem::take(&mut noise.loads);
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
        let buffers = Buffers {
            filter: Filter::new(&model, empty.stride, &loads),
            locator: Locator::new(&model),
            metric: Metric::new(m, width),
            scan: SiteScan::new(&model),
            z: vec![0.0; width],
        };
        let mut work = Self {
            settings: estimator.params,
            hypotheses: Hypotheses::new(&empty, params.n_hypotheses),
            gathered: Gathered::new(width),
            metric: Metric::new(m, width),
            n_taken,
            pair_birth: PairBirth::new(&model, &empty),
            trusted: empty.clone(),
            before: empty,
            buffers,
            z: vec![0.0; width],
            alarms: (0..=m).map(|n| tail_point(params.alarm_p, n)).collect(),
            n_live: m,
            next_id: 0,
            steps_left: 0,
            is_changed: false,
            frame,
            params,
            model,
        };
        work.refresh();
        Ok(work)
    }

    /// Takes the readings of a frame; whether other gauges are read than in the frame before.
    pub(super) fn read(
        &mut self,
        readings: &[f64],
        live: Option<&[bool]>,
    ) -> Result<bool, InverseError> {
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
            is_changed |= self.buffers.filter.live[g] != is_read;
            self.buffers.filter.live[g] = is_read;
            self.z[g] = if is_read { value(g, gauge) } else { 0.0 };
        }
        self.n_live = n_live;
        if is_changed {
            self.gathered.clear();
            self.pair_birth.stop();
            self.refresh();
        }
        Ok(is_changed)
    }

    /// Forces, χ² and p of the frame for the best hypothesis; whether the residual alarms.
    pub(super) fn solve(&mut self) -> bool {
        let best = self.hypotheses.best_mut();
        let mut solved = self.metric.solve(&self.z);
        let n_dof = self.n_live.saturating_sub(best.n);
        if solved.chi2 > self.alarms[n_dof] && best.n > 0 {
            // places and map errors weigh more where forces have grown
            self.buffers.filter.weigh(best, &solved.forces, 1.0, &mut self.metric);
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
        self.buffers.filter.refresh(best, &mut self.metric);
    }

    /// Refines `which`'s mobile contacts on the frame gathered by about `n` trial steps.
    pub(super) fn settle(&mut self, which: HypothesisRef, n: usize) -> Fit {
        let n_mobile = self.hypotheses.get(which).n_mobile();
        let end = self.spend(n * n_mobile);
        let scale = self.gathered.frame(&mut self.buffers.z);
        let target = Target { z: &self.buffers.z, scale };
        let mut refiner = Refiner {
            model: &self.model,
            params: &self.settings,
            filter: &mut self.buffers.filter,
            metric: &mut self.buffers.metric,
            locator: &mut self.buffers.locator,
            n_trials: 0,
        };
        let hypothesis = self.hypotheses.get_mut(which);
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

    /// Updates every hypothesis with the frames gathered; contacts that moved are held from now on.
    pub(super) fn learn(&mut self) {
        let scale = self.gathered.frame(&mut self.buffers.z);
        let time_s = self.gathered.n_frames as f64 * self.params.frame_period_s;
        let drift = self.params.drift_m_per_sqrt_s.powi(2) * time_s;
        let prior_sd_m = self.skin_sd_m();
        let buffers = &mut self.buffers;
        for hypothesis in self.hypotheses.alive_mut() {
            if hypothesis.n == 0 {
                continue;
            }
            for i in 0..hypothesis.n {
                for a in i * hypothesis.d..i * hypothesis.d + 2 {
                    hypothesis.p[a * hypothesis.stride + a] += drift;
                }
            }
            let metric = &mut buffers.metric;
            let model = &self.model;
            buffers.filter.update(model, hypothesis, &buffers.z, scale, prior_sd_m, metric);
            let size_2: f64 = hypothesis.forces().iter().map(|a| a * a).sum();
            let prior_penalty = size_2 / self.settings.force_scale_n.powi(2);
            hypothesis.prior_penalty = hypothesis.prior_penalty.max(prior_penalty);
            self.frame.info.n_updates += 1;
        }
        let delta = self.params.hypothesis_delta;
        self.frame.info.is_switched |= self.hypotheses.prune(&self.model, delta);
        self.refresh();
    }

    /// Holds all contacts that move, and learns from the frames gathered.
    pub(super) fn hold_mobile(&mut self) {
        for hypothesis in self.hypotheses.alive_mut() {
            hypothesis.set_cost(hypothesis.handicap);
            hypothesis.handicap = 0.0;
        }
        self.learn();
        self.gathered.clear();
    }

    /// The hypothesis before the contacts that move came is the best one without them.
    pub(super) fn set_before(&mut self) {
        self.before.copy_from(self.hypotheses.best());
        for i in (0..self.before.n).rev() {
            if self.before.tracks[i].is_mobile() {
                self.before.remove(i);
            }
        }
    }

    /// The best hypothesis explains the frames. It is kept once for each block that it learnt from.
    pub(super) fn trust(&mut self) {
        let best = self.hypotheses.best();
        if self.frame.info.n_updates > 0 || best.n == 0 {
            self.trusted.copy_from(best);
        }
    }

    /// Takes at most `n` steps from the frame's budget.
    pub(super) fn spend(&mut self, n: usize) -> usize {
        let spent = n.min(self.steps_left);
        self.steps_left -= spent;
        spent
    }

    /// Numbers of a frame that are left for contacts.
    pub(super) fn n_free(&self) -> usize {
        self.n_live.saturating_sub(self.n_taken)
    }

    /// Contacts that may be held beside the gauges read: two channels more than forces for one that
    /// comes.
    pub(super) fn most_contacts(&self) -> usize {
        self.params.max_contacts.min(self.n_free().saturating_sub(2))
    }

    /// Whether χ² is too large for a frame in which `n` unknowns were fitted.
    pub(super) fn is_odd(&self, chi2: f64, n: usize) -> bool {
        upper_tail(chi2, self.n_live.saturating_sub(n)) < self.params.alarm_p
    }

    /// Whether a force is beyond what touches have.
    pub(super) fn is_beyond(&self, hypothesis: &Hypothesis) -> bool {
        let most_n = BEYOND * self.settings.range_n();
        hypothesis.tracks().iter().any(|track| track.force_n > most_n)
    }

    /// Standard deviation of a place anywhere on the skin, m.
    pub(super) fn skin_sd_m(&self) -> f64 {
        (self.model.skin().area_m2() / std::f64::consts::TAU).sqrt()
    }
}
