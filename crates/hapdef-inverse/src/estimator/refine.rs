//! Levenberg–Marquardt steps over the skin, forces solved again at each point.

use hapdef_contact::MAX_CONTACTS;
use nalgebra::Vector3;

use crate::dense::{cholesky, inverse, log_det, solve_lower, solve_upper};
use crate::estimator::explanation::Explanation;
use crate::estimator::normal_equations::{Linear, MAX_UNKNOWNS};
use crate::estimator::{EstimatorParams, Model};
use crate::walk::AtWall;

/// Trials of one step, each with more damping: each takes up to ten times more, so that the last is a
/// short step straight downhill, and where that fails the descent has ended.
const MAX_TRIALS: usize = 6;

/// Rounds in which the map's error is set anew from the forces: it grows with them, and they change
/// with it.
const N_ROUNDS: usize = 3;

const SIZE: usize = MAX_UNKNOWNS * MAX_UNKNOWNS;

/// What a refinement works with.
pub(crate) struct Refiner<'a> {
    pub(crate) model: &'a Model,
    pub(crate) params: &'a EstimatorParams,
    pub(crate) linear: &'a mut Linear,
    pub(crate) n_steps: usize,
}

impl Refiner<'_> {
    /// Forces of `e` where it is, for the covariance that a descent starts with.
    pub(crate) fn weigh(&mut self, e: &mut Explanation) {
        e.forces = [0.0; MAX_CONTACTS];
        // with an exact map the covariance does not depend on the forces
        for _ in 0..if self.model.base.is_some() { 2 } else { 0 } {
            self.linear.set_covariance(self.model, e);
            self.linear.evaluate(self.model, e);
        }
    }

    /// At most `max_steps` damped Gauss–Newton steps (Levenberg–Marquardt with Marquardt's
    /// scaling; the step of the positions is Kaufman's variable projection, since the forces are
    /// solved again), the covariance held.
    pub(crate) fn descend(&mut self, e: &mut Explanation, max_steps: usize) {
        self.linear.set_covariance(self.model, e);
        self.linear.evaluate(self.model, e);
        self.linear.linearise(self.model, e);
        let mut damping = 1e-3;
        for _ in 0..max_steps {
            let before = e.chi2;
            if !self.improve(e, &mut damping) {
                break;
            }
            self.linear.linearise(self.model, e);
            if before - e.chi2 <= self.params.chi2_tolerance {
                break;
            }
        }
    }

    /// Refines `e` to the end, and sets its misfit and Occam factor.
    pub(crate) fn settle(&mut self, e: &mut Explanation) {
        let n_rounds = if self.model.base.is_some() { N_ROUNDS } else { 1 };
        for _ in 0..n_rounds {
            let before = e.chi2 + e.log_det_s;
            self.descend(e, self.params.max_steps);
            let change = before - (e.chi2 + e.log_det_s);
            if change.abs() <= 1e-3 {
                break;
            }
        }
        e.drop_idle(0.0);
        self.linear.set_covariance(self.model, e);
        self.linear.evaluate(self.model, e);
        self.linear.linearise(self.model, e);
        e.occam = self.occam(e);
    }

    fn improve(&mut self, e: &mut Explanation, damping: &mut f64) -> bool {
        let tangents = self.linear.tangents;
        for _ in 0..MAX_TRIALS {
            let step = self.step(e, &tangents, *damping);
            self.n_steps += 1;
            let mut trial = *e;
            for i in 0..e.n {
                let [u, v] = [step[3 * i], step[3 * i + 1]];
                let along = tangents[i][0] * u + tangents[i][1] * v;
                let skin = self.model.skin();
                trial.points[i] = skin.walk(&e.points[i], &along, AtWall::Slide).point;
            }
            self.linear.evaluate(self.model, &mut trial);
            if trial.chi2 < e.chi2 {
                *e = trial;
                *damping = (*damping * 0.1).max(1e-9);
                return true;
            }
            *damping = (*damping * 10.0).max(1e-2);
        }
        false
    }

    /// The step for a damping, no contact's longer than allowed, none into a wall.
    fn step(
        &self,
        e: &Explanation,
        tangents: &[[Vector3<f64>; 2]; MAX_CONTACTS],
        damping: f64,
    ) -> [f64; MAX_UNKNOWNS] {
        let n = 3 * e.n;
        let mut a = self.linear.a;
        let stiffest = |a: &[f64; SIZE]| (0..e.n).map(|i| a[3 * i * (n + 1)]).fold(0.0, f64::max);
        let floor = 1e-12 * stiffest(&a) + f64::MIN_POSITIVE;
        for p in 0..n {
            let least = if p % 3 == 2 { 1e-300 } else { floor };
            a[p * (n + 1)] += damping * a[p * (n + 1)] + least;
        }
        let mut step = solved(&a, &self.linear.b, n);
        let mut is_held = false;
        for i in 0..e.n {
            let along = tangents[i][0] * step[3 * i] + tangents[i][1] * step[3 * i + 1];
            if let Some([_, inward]) = self.model.skin().wall_at(&e.points[i], &along) {
                let m = tangents[i].map(|t| t.dot(&inward));
                let stiff = 1e6 * (stiffest(&a) + floor);
                for (p, mp) in m.iter().enumerate() {
                    for (q, mq) in m.iter().enumerate() {
                        a[(3 * i + p) * n + 3 * i + q] += stiff * mp * mq;
                    }
                }
                is_held = true;
            }
        }
        if is_held {
            step = solved(&a, &self.linear.b, n);
        }
        let longest = (0..e.n).map(|i| step[3 * i].hypot(step[3 * i + 1])).fold(0.0, f64::max);
        if longest > self.params.max_step_m {
            let scale = self.params.max_step_m / longest;
            step.iter_mut().for_each(|s| *s *= scale);
        }
        step
    }

    /// Standard deviations of the prior: a skin's whole area, a force of the expected size.
    pub(crate) fn prior_sd(&self, q: usize) -> f64 {
        if q % 3 == 2 {
            return self.params.force_scale_n;
        }
        (self.model.skin().area_m2() / std::f64::consts::TAU).sqrt()
    }

    /// 1 + D I D where D holds the prior's standard deviations `[n]`, factored; `false` if it can't be.
    fn scaled_information(&self, sds: &[f64], l: &mut [f64; SIZE]) -> bool {
        let n = sds.len();
        for p in 0..n {
            for q in 0..n {
                let unit = if p == q { 1.0 } else { 0.0 };
                l[p * n + q] = unit + sds[p] * sds[q] * self.linear.a[p * n + q];
            }
        }
        cholesky(&mut l[..n * n], n, 0.0)
    }

    fn occam(&self, e: &Explanation) -> f64 {
        let (n, mut l) = (3 * e.n, [0.0; SIZE]);
        let sds: [f64; MAX_UNKNOWNS] = std::array::from_fn(|q| self.prior_sd(q));
        if self.scaled_information(&sds[..n], &mut l) { log_det(&l, n) } else { f64::MAX }
    }

    /// (Λ₀ + I)⁻¹ `[3 n, 3 n]` where the normal equations were formed last, m and N; the prior
    /// alone where rounding spoils it. The prior of a force is no narrower here than the force found,
    /// whose error grows with it.
    pub(crate) fn covariance(&self, e: &Explanation, out: &mut Vec<f64>) {
        let (n, mut l) = (3 * e.n, [0.0; SIZE]);
        let sds: [f64; MAX_UNKNOWNS] = std::array::from_fn(|q| match q % 3 {
            2 => self.prior_sd(q).max(e.forces[q / 3]),
            _ => self.prior_sd(q),
        });
        out.clear();
        out.resize(n * n, 0.0);
        if self.scaled_information(&sds[..n], &mut l) {
            inverse(&l, n, out);
        } else {
            (0..n).for_each(|p| out[p * (n + 1)] = 1.0);
        }
        for p in 0..n {
            for q in 0..n {
                out[p * n + q] *= sds[p] * sds[q];
            }
        }
    }
}

/// a⁻¹ b scaled by the diagonal first; zero if `a` is singular.
pub(crate) fn solved(a: &[f64; SIZE], b: &[f64; MAX_UNKNOWNS], n: usize) -> [f64; MAX_UNKNOWNS] {
    let mut scale = [0.0; MAX_UNKNOWNS];
    for p in 0..n {
        scale[p] = 1.0 / a[p * (n + 1)].max(f64::MIN_POSITIVE).sqrt();
    }
    let mut l = [0.0; SIZE];
    let mut x = [0.0; MAX_UNKNOWNS];
    for p in 0..n {
        x[p] = b[p] * scale[p];
        for q in 0..n {
            l[p * n + q] = a[p * n + q] * scale[p] * scale[q];
        }
    }
    if !cholesky(&mut l[..n * n], n, 0.0) {
        return [0.0; MAX_UNKNOWNS];
    }
    solve_lower(&l, n, &mut x[..n]);
    solve_upper(&l, n, &mut x[..n]);
    for p in 0..n {
        x[p] *= scale[p];
    }
    if x[..n].iter().all(|v| v.is_finite()) { x } else { [0.0; MAX_UNKNOWNS] }
}
