//! Places of contacts that move, refined on one gathered frame while the others stay.

use nalgebra::{Matrix3, Vector3};

use crate::dense::{add_scaled, cholesky, dot, inverse, log_det};
use crate::estimator::{EstimatorParams, MAX_CONTACTS, MAX_UNKNOWNS, Model, non_negative, solved};
use crate::skin_point::SkinPoint;
use crate::tracker::filter::{Filter, MAX_CROSSINGS};
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::metric::Metric;
use crate::walk::AtWall;

const SIZE: usize = MAX_UNKNOWNS * MAX_UNKNOWNS;

/// Rounds in which the covariance is set anew from the forces.
const N_ROUNDS: usize = 2;

/// Change of a force that makes a new round worth it, relative: the map's error, which the covariance
/// takes from the force, is itself not known better.
const FORCE_CHANGE: f64 = 0.1;

/// Forces beyond the strongest that touches have are off by this standard deviation, a share of it, about the map's
/// error: contacts of great force on stiff places else explain what wrong places leave. Of the frames of 32 random
/// scripts 1.66 % were misfits with it, 2.07 % with a tenth; of 32 others 1.30 and 1.26 % (hapdef's example scripts,
/// `--scripts 32 --seconds 12`, seeds 0 and 2). A hard limit would leave a press beyond it without any contact
/// (`a_force_beyond_the_largest_is_followed_where_nothing_else_explains_it`).
const BEYOND_SD: f64 = 0.03;

/// A frame that contacts are looked for in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target<'a> {
    /// Whitened by the noise `[width]`.
    pub(super) z: &'a [f64],
    /// How many times larger its forces are than those of one frame.
    pub(super) scale: f64,
}

/// How a hypothesis explains a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub(super) chi2: f64,
    /// −2 ln evidence by Laplace's method: smaller is better.
    pub(super) cost: f64,
}

impl Fit {
    pub(super) const NONE: Self = Self { chi2: f64::INFINITY, cost: f64::INFINITY };
}

/// Buffers of a refinement.
#[derive(Clone, Debug)]
pub(super) struct Locator {
    /// L⁻¹ (∂₁g, ∂₂g, g) `[MAX_CONTACTS, 3, width]`; of contacts that stay only the last.
    rows: Vec<f64>,
    z: Vec<f64>,
    r: Vec<f64>,
    tangents: [[Vector3<f64>; 2]; MAX_CONTACTS],
    a: [f64; SIZE],
    b: [f64; MAX_UNKNOWNS],
}

/// Contacts' places and what they explain.
#[derive(Clone, Copy, Debug)]
struct Guess {
    points: [SkinPoint; MAX_CONTACTS],
    forces: [f64; MAX_CONTACTS],
    chi2: f64,
    /// χ² and what the priors of the forces and of the slides' lengths add.
    cost: f64,
}

/// What a refinement works with.
pub(super) struct Refiner<'a> {
    pub(super) model: &'a Model,
    pub(super) params: &'a EstimatorParams,
    pub(super) filter: &'a mut Filter,
    pub(super) metric: &'a mut Metric,
    pub(super) locator: &'a mut Locator,
    /// Trial steps made, times the contacts that moved.
    pub(super) n_trials: usize,
}

impl Locator {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            rows: vec![0.0; 3 * MAX_CONTACTS * model.width],
            z: vec![0.0; model.width],
            r: vec![0.0; model.width],
            tangents: [[Vector3::zeros(); 2]; MAX_CONTACTS],
            a: [0.0; SIZE],
            b: [0.0; MAX_UNKNOWNS],
        }
    }
}

impl Refiner<'_> {
    /// Moves the mobile contacts of `hypothesis` downhill on `target` until trial steps times contacts come to `max_trials`
    /// (Levenberg–Marquardt, forces of all contacts solved again at each point) and sets all
    /// forces.
    pub(super) fn settle(
        &mut self,
        hypothesis: &mut Hypothesis,
        target: &Target<'_>,
        max_trials: usize,
    ) -> Fit {
        let end = self.n_trials + max_trials;
        let mut fit = Fit::NONE;
        for _ in 0..N_ROUNDS {
            let before = hypothesis.forces();
            let guess = self.descend(hypothesis, target, end);
            let is_same = (0..hypothesis.n).all(|i| {
                let (old, new) = (before[i], guess.forces[i] / target.scale);
                (old - new).abs() <= FORCE_CHANGE * new.max(old)
            });
            self.keep(hypothesis, &guess, target.scale);
            fit = self.judge(hypothesis, &guess, target);
            if is_same || hypothesis.d == 2 {
                break;
            }
        }
        fit
    }

    fn descend(&mut self, hypothesis: &mut Hypothesis, target: &Target<'_>, end: usize) -> Guess {
        for i in 0..hypothesis.n {
            if hypothesis.tracks[i].is_mobile() {
                hypothesis.set_map_error(self.model, i);
            }
        }
        let forces = hypothesis.forces().map(|a| a * target.scale);
        self.filter.weigh(hypothesis, &forces, target.scale, self.metric);
        let width = hypothesis.width;
        for i in 0..hypothesis.n {
            let at = (3 * i + 2) * width;
            self.locator.rows[at..at + width].copy_from_slice(self.metric.atom(i));
        }
        self.locator.z.copy_from_slice(target.z);
        self.metric.whiten(&mut self.locator.z);
        let points = std::array::from_fn(|i| hypothesis.tracks[i].point);
        let mut best = self.evaluate(hypothesis, &points, target.scale);
        self.linearise(hypothesis, &best, target.scale);
        if hypothesis.n_mobile() == 0 {
            return best;
        }
        let mut damping = 1e-3;
        while self.n_trials + hypothesis.n_mobile() <= end {
            let before = best.cost;
            let trial = self.trial(hypothesis, &best, target.scale, damping);
            self.n_trials += hypothesis.n_mobile();
            if trial.cost < best.cost {
                best = trial;
                self.linearise(hypothesis, &best, target.scale);
                damping = f64::max(damping * 0.1, 1e-9);
                if before - best.cost <= 1e-4 * (1.0 + best.cost) {
                    break;
                }
            } else if damping > 1e3 {
                break;
            } else {
                damping = f64::max(damping * 10.0, 1e-2);
            }
        }
        best
    }

    fn trial(&mut self, hypothesis: &Hypothesis, from: &Guess, scale: f64, damping: f64) -> Guess {
        let n = 3 * hypothesis.n;
        let (mut a, mut b) = (self.locator.a, self.locator.b);
        let stiffest = (0..n).map(|p| a[p * (n + 1)]).fold(0.0, f64::max);
        for p in 0..n {
            let floor = if p % 3 == 2 { 1e-300 } else { 1e-14 * stiffest };
            a[p * (n + 1)] += damping * a[p * (n + 1)] + floor;
        }
        for (i, track) in hypothesis.tracks().iter().enumerate() {
            let Some((start, sd_m)) = track.slide else { continue };
            let gone = self.model.skin().position(&from.points[i]) - start;
            for (p, tangent) in (3 * i..).zip(&self.locator.tangents[i]) {
                a[p * (n + 1)] += (sd_m * sd_m).recip();
                b[p] -= tangent.dot(&gone) / (sd_m * sd_m);
            }
        }
        let step = solved(&a, &b, n);
        let mut points = from.points;
        for i in (0..hypothesis.n).filter(|&i| hypothesis.tracks[i].is_mobile()) {
            let [t1, t2] = self.locator.tangents[i];
            let along = t1 * step[3 * i] + t2 * step[3 * i + 1];
            let shrink = (self.params.max_step_m / along.norm().max(f64::MIN_POSITIVE)).min(1.0);
            let skin = self.model.skin();
            points[i] = skin
                .walk_at_most(&points[i], &(along * shrink), AtWall::Slide, MAX_CROSSINGS)
                .point;
        }
        self.evaluate(hypothesis, &points, scale)
    }

    fn evaluate(
        &mut self,
        hypothesis: &Hypothesis,
        points: &[SkinPoint; MAX_CONTACTS],
        scale: f64,
    ) -> Guess {
        let (n, width) = (hypothesis.n, hypothesis.width);
        for i in (0..n).filter(|&i| hypothesis.tracks[i].is_mobile()) {
            self.fill_rows(&points[i], i);
        }
        let rows = &self.locator.rows;
        let atom = |i: usize| &rows[(3 * i + 2) * width..(3 * i + 3) * width];
        let mut h = [0.0; MAX_CONTACTS * MAX_CONTACTS];
        let mut c = [0.0; MAX_CONTACTS];
        for i in 0..n {
            c[i] = dot(atom(i), &self.locator.z);
            for j in 0..=i {
                let product = dot(atom(i), atom(j));
                h[i * n + j] = product;
                h[j * n + i] = product;
            }
            h[i * n + i] += self.prior_information(scale);
        }
        let forces = non_negative(&h, &c, n);
        self.locator.r.copy_from_slice(&self.locator.z);
        for i in 0..n {
            let at = (3 * i + 2) * width;
            let row = &self.locator.rows[at..at + width];
            add_scaled(&mut self.locator.r, -forces[i], row);
        }
        let chi2 = dot(&self.locator.r, &self.locator.r);
        let size_2: f64 = forces.iter().map(|a| a * a).sum();
        let mut cost = chi2 + self.prior_information(scale) * size_2;
        for (track, point) in hypothesis.tracks().iter().zip(points) {
            let Some((start, sd_m)) = track.slide else { continue };
            let gone = self.model.skin().position(point) - start;
            cost += gone.norm_squared() / (sd_m * sd_m);
        }
        Guess { points: *points, forces, chi2, cost }
    }

    fn prior_information(&self, scale: f64) -> f64 {
        (self.params.force_scale_n * scale).powi(2).recip().min(f64::MAX)
    }

    fn fill_rows(&mut self, point: &SkinPoint, i: usize) {
        let (model, width) = (self.model, self.model.width);
        let frame = model.skin().frame(point);
        let weights = model.interpolant().weights(&point.bary(), &frame);
        let rows = &mut self.locator.rows[3 * i * width..3 * (i + 1) * width];
        let all = [&weights.slope[0], &weights.slope[1], &weights.value];
        for (row, weights) in rows.chunks_exact_mut(width).zip(all) {
            model.interpolant().combine(model.rows(), point, weights, row);
            self.metric.whiten(row);
        }
        self.locator.tangents[i] = frame.tangents;
    }

    /// JᵀJ and Jᵀr; contacts that stay have no say in their places.
    fn linearise(&mut self, hypothesis: &Hypothesis, at: &Guess, scale: f64) {
        let prior = self.prior_information(scale);
        let (n, width) = (3 * hypothesis.n, hypothesis.width);
        let Locator { rows, r, a, b, .. } = &mut *self.locator;
        let is_free = |q: usize| q % 3 == 2 || hypothesis.tracks[q / 3].is_mobile();
        let weight = |q: usize| if q % 3 == 2 { 1.0 } else { at.forces[q / 3] };
        let row = |q: usize| &rows[q * width..(q + 1) * width];
        for p in 0..n {
            b[p] = if p % 3 == 2 {
                dot(row(p), r) - prior * at.forces[p / 3]
            } else if is_free(p) {
                weight(p) * dot(row(p), r)
            } else {
                0.0
            };
            for q in 0..=p {
                let product = if is_free(p) && is_free(q) {
                    weight(p) * weight(q) * dot(row(p), row(q))
                } else {
                    0.0
                };
                a[p * n + q] = product;
                a[q * n + p] = product;
            }
            if !is_free(p) {
                a[p * n + p] = 1.0;
            }
        }
    }

    fn keep(&self, hypothesis: &mut Hypothesis, guess: &Guess, scale: f64) {
        for i in 0..hypothesis.n {
            if hypothesis.tracks[i].is_mobile() {
                hypothesis.tracks[i].point = guess.points[i];
                hypothesis.linearise(self.model, i);
            }
        }
        hypothesis.set_forces(&guess.forces, scale);
    }

    /// Cost at `guess`, and covariances of the mobile contacts.
    fn judge(&mut self, hypothesis: &mut Hypothesis, guess: &Guess, target: &Target<'_>) -> Fit {
        let n = 3 * hypothesis.n;
        let skin_sd_m = (self.model.skin().area_m2() / std::f64::consts::TAU).sqrt();
        let force_sd = self.params.force_scale_n * target.scale;
        let slides = hypothesis.tracks.map(|track| track.slide);
        let prior = |q: usize| match (q % 3, slides[q / 3]) {
            (2, _) => force_sd,
            (_, Some((_, sd_m))) => sd_m,
            _ => skin_sd_m,
        };
        let mut l = [0.0; SIZE];
        for p in 0..n {
            for q in 0..n {
                let is_fixed = p == q && p % 3 != 2 && !hypothesis.tracks[p / 3].is_mobile();
                let unit = if p == q { 1.0 } else { 0.0 };
                let information = if is_fixed { 0.0 } else { self.locator.a[p * n + q] };
                l[p * n + q] = unit + prior(p) * prior(q) * information;
            }
        }
        let mut cost = guess.cost + self.metric.log_det;
        for force in &guess.forces[..hypothesis.n] {
            let beyond = force / target.scale / self.params.range_n() - 1.0;
            cost += (beyond.max(0.0) / BEYOND_SD).powi(2);
        }
        if cholesky(&mut l[..n * n], n, 0.0) {
            cost += log_det(&l, n);
            let mut inverted = [0.0; SIZE];
            inverse(&l, n, &mut inverted[..n * n]);
            for i in 0..hypothesis.n {
                if !hypothesis.tracks[i].is_mobile() {
                    continue;
                }
                let unit = |p: usize| if p == 2 { 1.0 / target.scale } else { 1.0 };
                let entry = |p: usize, q: usize| {
                    let (p0, q0) = (3 * i + p, 3 * i + q);
                    prior(p0) * prior(q0) * inverted[p0 * n + q0] * unit(p) * unit(q)
                };
                let covariance = Matrix3::from_fn(entry);
                hypothesis.tracks[i].covariance = covariance;
            }
        } else {
            cost = f64::INFINITY;
        }
        Fit { chi2: guess.chi2, cost }
    }
}
