//! What frames say about the places of held contacts and the map's error there.

use hapdef_contact::Phase;

use crate::dense::{add_scaled, dot, solve_lower, solve_upper};
use crate::estimator::{MAX_CONTACTS, Model};
use crate::other_loads::OtherLoads;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::metric::{Metric, Solved};
use crate::walk::AtWall;

/// Edges that a step crosses at most.
pub(super) const MAX_CROSSINGS: usize = 24;

/// Variance of a gauge that is not read, in units of its noise: it counts for nothing, and its rows and
/// columns stay where they are, so that nothing is allocated when gauges come and go.
const UNREAD: f64 = 1e14;

/// Buffers of an update.
#[derive(Clone, Debug)]
pub(super) struct Filter {
    /// P Hᵀ `[stride, width]`.
    t: Vec<f64>,
    /// `[m, m]`.
    s: Vec<f64>,
    /// `[MAX_CONTACTS, width]`.
    basis: Vec<f64>,
    change: Vec<f64>,
    /// The map's error per N², mean over the sites `[m, m]`; empty if the map is exact.
    mean_error: Vec<f64>,
    /// Covariance of loads that are no contacts, in units of the noise `[m, m]`; empty without such.
    loads: Vec<f64>,
    /// Gauges that are read `[m]`.
    pub(super) live: Vec<bool>,
}

impl Filter {
    pub(super) fn new(model: &Model, stride: usize, loads: &OtherLoads) -> Self {
        Self {
            loads: in_noise(model, loads),
            t: vec![0.0; stride * model.width],
            s: vec![0.0; model.m * model.m],
            basis: vec![0.0; MAX_CONTACTS * model.width],
            change: vec![0.0; stride],
            mean_error: model.mean_error(),
            live: vec![true; model.m],
        }
    }

    /// S = 1 + H P Hᵀ + c² B and the atoms of `hypothesis` for `forces` into `metric`, P Hᵀ into the
    /// buffers; H of contact i is Aᵢ (∂₁g, ∂₂g, 1), B the covariance of loads that are no contacts and c
    /// `scale`, how many times larger the forces are than those of one frame: loads stay while frames add up,
    /// as noise doesn't.
    pub(super) fn weigh(
        &mut self,
        hypothesis: &Hypothesis,
        forces: &[f64; MAX_CONTACTS],
        scale: f64,
        metric: &mut Metric,
    ) {
        self.weigh_beside(hypothesis, forces, scale, 0.0, metric);
    }

    /// The same with the map's error for a contact anywhere of force `newcomer_n`.
    pub(super) fn weigh_beside(
        &mut self,
        hypothesis: &Hypothesis,
        forces: &[f64; MAX_CONTACTS],
        scale: f64,
        newcomer_n: f64,
        metric: &mut Metric,
    ) {
        let (width, m, d) = (hypothesis.width, metric.m, hypothesis.d);
        for a in 0..hypothesis.n * d {
            let row =
                &hypothesis.p[a * hypothesis.stride..a * hypothesis.stride + hypothesis.n * d];
            let t = &mut self.t[a * width..(a + 1) * width];
            t.fill(0.0);
            for (i, state) in row.chunks_exact(d).enumerate() {
                let force = forces[i];
                for (slope, p) in
                    hypothesis.slopes[2 * i * width..].chunks_exact(width).zip(&state[..2])
                {
                    add_scaled(t, force * p, slope);
                }
                for (t, p) in t.iter_mut().zip(&state[2..]) {
                    *t += force * p;
                }
            }
        }
        self.s.fill(0.0);
        for g in 0..m {
            let row = &mut self.s[g * m..(g + 1) * m];
            for (i, &force) in forces[..hypothesis.n].iter().enumerate() {
                let mut add = |state: usize, weight: f64| {
                    let t = &self.t[(i * d + state) * width..(i * d + state + 1) * width];
                    for (s, t) in row.iter_mut().zip(t) {
                        *s += weight * t;
                    }
                };
                add(0, force * hypothesis.slopes[2 * i * width + g]);
                add(1, force * hypothesis.slopes[(2 * i + 1) * width + g]);
                if d > 2 {
                    add(2 + g, force);
                }
            }
            row[g] += if self.live[g] { 1.0 } else { UNREAD };
        }
        for (s, c) in self.s.iter_mut().zip(&self.mean_error) {
            *s += newcomer_n * newcomer_n * c;
        }
        for (s, b) in self.s.iter_mut().zip(&self.loads) {
            *s += scale * scale * b;
        }
        metric.set_covariance(&self.s);
        metric.set_atoms(&hypothesis.atoms, hypothesis.n);
    }

    /// Learns from the frame `z`, whose forces are about `scale` times those of `hypothesis`: an
    /// extended Kalman update with the forces left free (a flat prior, which projects their atoms
    /// out of the innovation). Contacts that move are held from now on, their places known no
    /// better before than their slides' lengths were, or than `prior_sd_m`.
    pub(super) fn update(
        &mut self,
        model: &Model,
        hypothesis: &mut Hypothesis,
        z: &[f64],
        scale: f64,
        prior_sd_m: f64,
        metric: &mut Metric,
    ) -> Solved {
        for i in 0..hypothesis.n {
            if hypothesis.tracks[i].is_mobile() {
                hypothesis.tracks[i].phase = Phase::Held;
                let slide = hypothesis.tracks[i].slide.take();
                let prior_sd_m = slide.map_or(prior_sd_m, |(_, sd_m)| sd_m);
                for a in i * hypothesis.d..i * hypothesis.d + 2 {
                    hypothesis.p[a * hypothesis.stride + a] = prior_sd_m * prior_sd_m;
                }
            }
        }
        self.weigh(hypothesis, &hypothesis.forces().map(|a| a * scale), scale, metric);
        let guess = metric.solve(z).forces;
        self.weigh(hypothesis, &guess, scale, metric);
        let solved = metric.solve(z);
        self.learn(hypothesis, &solved, metric);
        for i in 0..hypothesis.n {
            self.apply(model, hypothesis, i);
        }
        hypothesis.set_forces(&solved.forces, scale);
        hypothesis.data_cost += solved.chi2 + metric.log_det + metric.log_det_atoms();
        solved
    }

    /// dx and the new covariance.
    fn learn(&mut self, hypothesis: &mut Hypothesis, solved: &Solved, metric: &Metric) {
        let (width, m, n) = (hypothesis.width, metric.m, hypothesis.n * hypothesis.d);
        let n_basis = metric.span(&solved.forces, &mut self.basis);
        for a in 0..n {
            let row = &mut self.t[a * width..(a + 1) * width];
            solve_lower(&metric.l, m, &mut row[..m]);
            for q in self.basis.chunks_exact(width).take(n_basis) {
                let along = dot(q, row);
                add_scaled(row, -along, q);
            }
            self.change[a] = dot(row, &metric.r);
        }
        for a in 0..n {
            let mine = &self.t[a * width..(a + 1) * width];
            for b in 0..=a {
                let less = dot(mine, &self.t[b * width..(b + 1) * width]);
                let p = hypothesis.p[a * hypothesis.stride + b] - less;
                hypothesis.p[a * hypothesis.stride + b] = p;
                hypothesis.p[b * hypothesis.stride + a] = p;
            }
        }
    }

    fn apply(&self, model: &Model, hypothesis: &mut Hypothesis, i: usize) {
        let (d, width) = (hypothesis.d, hypothesis.width);
        let change = &self.change[i * d..(i + 1) * d];
        let delta = &mut hypothesis.delta[i * width..(i + 1) * width];
        for (delta, change) in delta.iter_mut().zip(&change[2..]) {
            *delta += change;
        }
        let [t1, t2] = hypothesis.tangents[i];
        let step = t1 * change[0] + t2 * change[1];
        let point = model
            .skin()
            .walk_at_most(&hypothesis.tracks[i].point, &step, AtWall::Slide, MAX_CROSSINGS)
            .point;
        hypothesis.carry(model, i, point);
    }

    /// Covariances of places and forces of the held contacts of `hypothesis` for frames with its forces,
    /// and `metric` for them.
    pub(super) fn refresh(&mut self, hypothesis: &mut Hypothesis, metric: &mut Metric) {
        self.weigh(hypothesis, &hypothesis.forces(), 1.0, metric);
        let (n, width, d) = (hypothesis.n, hypothesis.width, hypothesis.d);
        let mut forces = [0.0; MAX_CONTACTS * MAX_CONTACTS];
        self.set_force_noise(hypothesis, metric);
        let is_known = metric.force_covariance(&mut forces);
        for i in 0..n {
            let track = &mut hypothesis.tracks[i];
            if track.is_mobile() {
                continue;
            }
            track.covariance[(2, 2)] = if is_known { forces[i * n + i] } else { f64::MAX };
            for p in 0..2 {
                let row = &mut self.t[(i * d + p) * width..(i * d + p + 1) * width];
                solve_lower(&metric.l, metric.m, &mut row[..metric.m]);
                let cross: f64 =
                    (0..n).map(|j| -dot(row, metric.atom(j)) * forces[j * n + i]).sum();
                track.covariance[(p, 2)] = cross;
                track.covariance[(2, p)] = cross;
                for q in 0..2 {
                    track.covariance[(p, q)] =
                        hypothesis.p[(i * d + p) * hypothesis.stride + i * d + q];
                }
            }
        }
    }

    /// What the noise alone does to forces in one frame: the diagonal of G L⁻¹ L⁻ᵀ Gᵀ with
    /// G = (hᵀh)⁻¹ hᵀ, h the atoms whitened by S = L Lᵀ.
    fn set_force_noise(&mut self, hypothesis: &mut Hypothesis, metric: &Metric) {
        let (n, width, m) = (hypothesis.n, hypothesis.width, metric.m);
        let mut covariance = [0.0; MAX_CONTACTS * MAX_CONTACTS];
        if !metric.force_covariance(&mut covariance) {
            return;
        }
        let row = &mut self.basis[..width];
        for i in 0..n {
            row.fill(0.0);
            for j in 0..n {
                add_scaled(row, covariance[i * n + j], metric.atom(j));
            }
            solve_upper(&metric.l, m, &mut row[..m]);
            let variance: f64 = (0..m).filter(|&g| self.live[g]).map(|g| row[g] * row[g]).sum();
            hypothesis.tracks[i].force_noise_n = variance.sqrt();
        }
    }
}

/// Covariance of `loads` in units of the noise that `model` is whitened by.
fn in_noise(model: &Model, loads: &OtherLoads) -> Vec<f64> {
    if loads.is_empty() {
        return Vec::new();
    }
    let m = model.m;
    let mut covariance = vec![0.0; m * m];
    loads.add_to(&model.live, model.map.n_gauges(), &mut covariance);
    let sd = |g: usize| model.l[g * m + g];
    for (k, c) in covariance.iter_mut().enumerate() {
        *c /= sd(k / m) * sd(k % m);
    }
    covariance
}
