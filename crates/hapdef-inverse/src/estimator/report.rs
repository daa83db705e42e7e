//! From explanations to an answer: the count, covariances, runners-up, the verdict.

use hapdef_contact::{Verdict, WhyNot};
use nalgebra::Matrix3;

use crate::estimator::doubt::cost_with_more_noise;
use crate::estimator::explanation::Explanation;
use crate::estimator::output::{ContactEstimate, EstimateInfo, LocatedContact, RunnerUp};
use crate::estimator::refine::Refiner;
use crate::estimator::shared::if_two;
use crate::estimator::{ContactEstimator, EstimatorScratch};

/// A place is open if its standard deviation exceeds this share of the prior's, which is that of a place
/// anywhere on the skin: the readings then leave more than half of what was unknown.
const OPEN_SHARE: f64 = 0.5;

/// Numbers beyond the contacts' unknowns that check them. With none or one many a pair reads, to the
/// noise, as contacts elsewhere, and nothing in the frame says so (docs/contacts.md, When an answer is sure).
const LEAST_SPARE: usize = 2;

/// Puts the answer together from `scratch.found`.
pub(crate) fn report(
    estimator: &ContactEstimator,
    readings: &[f64],
    untouched: &Explanation,
    scratch: &mut EstimatorScratch,
    info: &mut EstimateInfo,
    out: &mut ContactEstimate,
) {
    let model = &estimator.model;
    let mut best = choose(estimator, untouched, &scratch.found);
    sort_by_force(&mut best);
    let mut refiner =
        Refiner { model, params: &estimator.params, linear: &mut scratch.linear, n_steps: 0 };
    refiner.linear.set_covariance(model, &mut best);
    refiner.linear.evaluate(model, &mut best);
    refiner.linear.linearise(model, &best);
    refiner.covariance(&best, &mut out.joint_covariance);
    let prior_sd_m = refiner.prior_sd(0);
    out.contacts.clear();
    for i in 0..best.n {
        out.contacts.push(contact(estimator, &best, i, &out.joint_covariance));
    }
    out.if_two.clear();
    if best.n < estimator.most_contacts() {
        let (apart_m, joint) = (estimator.params.distinct_m, &mut scratch.joint);
        let of_contact = |i| if_two(&mut refiner, &best, i, apart_m, joint);
        out.if_two.extend((0..best.n).map(of_contact));
    }
    out.chi2 = best.chi2;
    out.cost = best.cost();
    out.n_dof = model.m.saturating_sub(3 * best.n);
    out.p_value = estimator.p_value(&best);
    out.chi2_untouched = untouched.chi2;
    out.info = *info;
    set_residual(estimator, readings, &best, out);
    set_runner_ups(estimator, &best, &scratch.found, out);
    out.verdict = match verdict(estimator, &best, out, prior_sd_m) {
        Verdict::Identified if is_noise(estimator, &best, untouched, &scratch.found) => {
            Verdict::NotIdentifiable(WhyNot::Noise)
        }
        verdict => verdict,
    };
    scale_places(estimator, out);
}

/// Covariances as they are reported, once everything has been judged by what they are.
fn scale_places(estimator: &ContactEstimator, out: &mut ContactEstimate) {
    let model = &estimator.model;
    for contact in &mut out.contacts {
        model.scale_places(contact.covariance.as_mut_slice(), 3);
    }
    model.scale_places(&mut out.joint_covariance, 3 * out.contacts.len());
}

/// The best explanation of each count, and of these the one with the best evidence, each further
/// contact charged the margin; one with impossible forces only where there is no other.
fn choose(
    estimator: &ContactEstimator,
    untouched: &Explanation,
    found: &[Explanation],
) -> Explanation {
    let params = &estimator.params;
    let good = found.iter().filter(|e| estimator.is_good(e, params.accept_p));
    let enough = good.map(|e| e.n).min().unwrap_or(usize::MAX);
    let cost = |e: &Explanation| {
        let beyond = e.n.saturating_sub(enough) as f64;
        e.cost() + params.count_margin * e.n as f64 + params.settle_margin * beyond
    };
    let most = estimator.most_contacts();
    // where a contact's force vanishes fewer are left than asked for
    let is_any_whole = found.iter().any(|e| e.n == most);
    let is_allowed =
        |e: &&Explanation| estimator.params.known_count.is_none() || e.n == most || !is_any_whole;
    let is_any_believed = found.iter().any(|e| estimator.is_believed(e));
    found
        .iter()
        .filter(|e| estimator.is_believed(e) || !is_any_believed)
        .filter(is_allowed)
        .min_by(|a, b| cost(a).total_cmp(&cost(b)))
        .filter(|best| best.n > 0)
        .unwrap_or(untouched)
        .to_owned()
}

fn sort_by_force(e: &mut Explanation) {
    for i in 1..e.n {
        for j in (1..=i).rev() {
            if e.forces[j] > e.forces[j - 1] {
                e.forces.swap(j, j - 1);
                e.points.swap(j, j - 1);
            }
        }
    }
}

fn contact(
    estimator: &ContactEstimator,
    e: &Explanation,
    i: usize,
    joint: &[f64],
) -> LocatedContact {
    let n = 3 * e.n;
    let covariance = Matrix3::from_fn(|p, q| joint[(3 * i + p) * n + 3 * i + q]);
    LocatedContact::new(estimator.model.skin(), e.points[i], e.forces[i], covariance)
}

fn set_residual(
    estimator: &ContactEstimator,
    readings: &[f64],
    best: &Explanation,
    out: &mut ContactEstimate,
) {
    let model = &estimator.model;
    out.residual.clear();
    out.residual.resize(readings.len(), 0.0);
    for &gauge in &model.live {
        let explained: f64 =
            (0..best.n).map(|i| best.forces[i] * model.map.normal_of(&best.points[i], gauge)).sum();
        out.residual[gauge] = readings[gauge] - explained;
    }
}

fn set_runner_ups(
    estimator: &ContactEstimator,
    best: &Explanation,
    found: &[Explanation],
    out: &mut ContactEstimate,
) {
    let (params, skin) = (&estimator.params, estimator.model.skin());
    out.runner_ups.clear();
    for e in found {
        let delta_cost = e.cost() - best.cost();
        let is_far = |other: &Explanation| !e.is_same(other, skin, params.distinct_m);
        if delta_cost > params.runner_up_delta || best.n == 0 || !is_far(best) {
            continue;
        }
        let new = RunnerUp {
            n: e.n,
            points: e.points,
            forces: e.forces,
            delta_chi2: e.chi2 - best.chi2,
            delta_cost,
        };
        let twin = out.runner_ups.iter_mut().find(|other| {
            let mut explained = Explanation::new(other.points());
            explained.forces = other.forces;
            !is_far(&explained)
        });
        match twin {
            Some(twin) if new.delta_cost < twin.delta_cost => *twin = new,
            Some(_) => {}
            None => out.runner_ups.push(new),
        }
    }
    out.runner_ups.sort_unstable_by(|a, b| a.delta_cost.total_cmp(&b.delta_cost));
}

fn verdict(
    estimator: &ContactEstimator,
    best: &Explanation,
    out: &ContactEstimate,
    prior_sd_m: f64,
) -> Verdict {
    let open = |c: &LocatedContact| {
        let (a, b, d) = (c.covariance[(0, 0)], c.covariance[(0, 1)], c.covariance[(1, 1)]);
        let largest = 0.5 * (a + d) + (0.25 * (a - d).powi(2) + b * b).sqrt();
        largest.sqrt() > OPEN_SHARE * prior_sd_m
    };
    let params = &estimator.params;
    let ties = |other: &RunnerUp| other.delta_cost.abs() <= params.tie_delta;
    if out.p_value < params.misfit_p {
        Verdict::NotIdentifiable(WhyNot::Misfit)
    } else if best.n == 0 {
        Verdict::Untouched
    } else if out.contacts.iter().any(open) {
        Verdict::NotIdentifiable(WhyNot::SingularInformation)
    } else if !estimator.is_checked(best.n) {
        Verdict::NotIdentifiable(WhyNot::Unchecked)
    } else if out.runner_ups.iter().any(ties) {
        Verdict::NotIdentifiable(WhyNot::TiedExplanations)
    } else {
        Verdict::Identified
    }
}

impl ContactEstimator {
    /// Whether an explanation's residual has at least the probability `p`, and its forces are possible.
    pub(super) fn is_good(&self, e: &Explanation, p: f64) -> bool {
        self.p_value(e) >= p && self.is_believed(e)
    }

    /// Probability that the residual of `n` contacts has to have for no more to be looked for. A frame of
    /// one contact stays cheap.
    pub(super) fn enough_p(&self, n: usize) -> f64 {
        if n < 2 || self.model.is_exact() || !self.is_checked(n + 1) {
            self.params.accept_p
        } else {
            self.params.settle_p
        }
    }

    /// Whether the gauges measure enough to check `n` contacts by.
    fn is_checked(&self, n: usize) -> bool {
        let params = &self.params;
        let is_last = n >= params.known_count.unwrap_or(params.max_contacts);
        self.effective_rank >= 3 * n + spare_numbers(is_last)
    }
}

/// Numbers that the gauges have to measure beyond the contacts' unknowns, to check them by: two, and where
/// they are not the last that may touch, a further contact's unknowns, without which many a set with
/// one more reads as some set of them.
pub(crate) fn spare_numbers(is_last: bool) -> usize {
    if is_last { LEAST_SPARE } else { 3 }
}

/// Whether fewer contacts and more noise explain the frame nearly as well as `best`.
fn is_noise(
    estimator: &ContactEstimator,
    best: &Explanation,
    untouched: &Explanation,
    found: &[Explanation],
) -> bool {
    let m = estimator.model.m;
    let fewer = found.iter().chain([untouched]).filter(|e| e.n < best.n);
    let mut doubted = fewer.map(|e| cost_with_more_noise(e, m));
    doubted.any(|cost| cost - best.cost() < estimator.params.noise_delta)
}
