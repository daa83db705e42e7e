//! Preconditioned conjugate gradients on up to eight right-hand sides side by side.

use super::hierarchy::MultigridParams;
use super::multigrid::Multigrid;
use super::ritz::extreme_ritz_values;
use super::vectors::{add_scaled, dot, scale_and_add, scaled_max};
use crate::SolveParams;

/// When the iteration stops.
///
/// Besides the backward error of [`SolveParams`], which is the promise of both paths, the relative
/// error in energy ‖u − û‖_K / ‖û‖_K is estimated by √(rᵀ M r / λ) / √(ûᵀ K û): M is the
/// preconditioner and λ the smallest eigenvalue of M K that the iteration has found. It bounds the
/// error of the solution itself where the backward error leaves a factor of cond(K).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterativeParams {
    /// Iterations at most, all restarts together.
    pub max_iterations: usize,
    /// The iteration goes on until the estimated relative error in energy is below this.
    pub energy_error_below: f64,
    /// A larger estimate than this at the end is an error.
    pub energy_error_fail_above: f64,
    /// How the levels are made.
    pub multigrid: MultigridParams,
}

impl Default for IterativeParams {
    fn default() -> Self {
        Self {
            max_iterations: 2000,
            energy_error_below: 1e-11,
            energy_error_fail_above: 1e-6,
            multigrid: MultigridParams::default(),
        }
    }
}

/// What was reached for one right-hand side.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reached {
    pub(crate) relative_residual: f64,
    pub(crate) backward_error: f64,
    pub(crate) energy_error: f64,
    pub(crate) n_iterations: usize,
    pub(crate) n_restarts: usize,
    /// Eigenvalues of M K: smallest and largest found.
    pub(crate) spectrum: (f64, f64),
}

impl Reached {
    fn widen(&mut self, (smallest, largest): (f64, f64)) {
        let first = self.spectrum.0 == 0.0;
        self.spectrum.0 = if first { smallest } else { smallest.min(self.spectrum.0) };
        self.spectrum.1 = largest.max(self.spectrum.1);
    }
}

/// The scaled system's norm and scale, and both stopping rules.
pub(crate) struct Measure<'a> {
    pub(crate) scale: &'a [f64],
    pub(crate) scaled_norm: f64,
    pub(crate) solve: &'a SolveParams,
    pub(crate) iterative: &'a IterativeParams,
}

/// Iterations between two looks at the spectrum.
const SPECTRUM_EVERY: usize = 5;

/// Within a run the recurrence must get this much below a limit, so that the true residual is too.
const MARGIN: f64 = 0.5;

/// A backward error below this is that of a solution rounded to f64: nothing is left to gain.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Solves K x = b for `k` ≤ 8 columns; `x` `[n_equations, k]`, row-major, in the caller's order of
/// rows, holds b on entry and the solution on return.
pub(crate) fn solve_block(
    multigrid: &Multigrid,
    x: &mut [f64],
    k: usize,
    measure: &Measure<'_>,
) -> Vec<Reached> {
    let reached = match k {
        1 => padded::<1>(multigrid, x, k, measure),
        2 => padded::<2>(multigrid, x, k, measure),
        3 | 4 => padded::<4>(multigrid, x, k, measure),
        _ => padded::<8>(multigrid, x, k, measure),
    };
    reached[..k].to_vec()
}

/// The widest block that [`solve_block`] takes.
pub(crate) const WIDEST: usize = 8;

fn padded<const K: usize>(
    multigrid: &Multigrid,
    x: &mut [f64],
    k: usize,
    measure: &Measure<'_>,
) -> Vec<Reached> {
    let sequence = multigrid.sequence();
    let at = |i: usize| 3 * sequence[i / 3] as usize + i % 3;
    let n = 3 * sequence.len();
    let row = |i: usize| std::array::from_fn(|l| if l < k { x[at(i) * k + l] } else { 0.0 });
    let b: Vec<[f64; K]> = (0..n).map(row).collect();
    let scale: Vec<f64> = (0..n).map(|i| measure.scale[at(i)]).collect();
    let measure = Measure { scale: &scale, ..*measure };
    let mut run = Run::new(multigrid, b, &measure);
    run.solve();
    for (i, values) in run.x.iter().enumerate() {
        x[at(i) * k..(at(i) + 1) * k].copy_from_slice(&values[..k]);
    }
    run.reached.to_vec()
}

/// The state of the iteration.
struct Run<'a, const K: usize> {
    multigrid: &'a Multigrid,
    measure: &'a Measure<'a>,
    b: Vec<[f64; K]>,
    x: Vec<[f64; K]>,
    r: Vec<[f64; K]>,
    z: Vec<[f64; K]>,
    /// ‖b̂‖∞ and ‖b‖₂.
    loaded: ([f64; K], [f64; K]),
    coefficients: [Vec<(f64, f64)>; K],
    reached: [Reached; K],
}

impl<'a, const K: usize> Run<'a, K> {
    fn new(multigrid: &'a Multigrid, b: Vec<[f64; K]>, measure: &'a Measure<'a>) -> Self {
        let zero = vec![[0.0; K]; b.len()];
        Self {
            multigrid,
            measure,
            r: b.clone(),
            z: zero.clone(),
            x: zero,
            loaded: (scaled_max(&b, measure.scale, false), dot(&b, &b).map(f64::sqrt)),
            b,
            coefficients: std::array::from_fn(|_| Vec::new()),
            reached: [Reached::default(); K],
        }
    }

    /// Runs of conjugate gradients, each from the true residual of the one before.
    fn solve(&mut self) {
        let mut open: [bool; K] = std::array::from_fn(|l| self.loaded.1[l] > 0.0);
        while open.contains(&true) {
            self.iterate(open);
            self.true_residual();
            for l in 0..K {
                let reached = &self.reached[l];
                open[l] &= !self.is_good(reached, 1.0)
                    && reached.backward_error.is_finite()
                    && reached.n_restarts < self.measure.solve.max_refinements
                    && reached.n_iterations < self.measure.iterative.max_iterations;
                self.reached[l].n_restarts += usize::from(open[l]);
            }
        }
    }

    fn is_good(&self, reached: &Reached, margin: f64) -> bool {
        reached.backward_error <= margin * self.measure.solve.refine_above
            && (reached.energy_error <= margin * self.measure.iterative.energy_error_below
                || reached.backward_error <= margin * ROUNDING)
    }

    /// One run on the `active` columns; the others stand still.
    fn iterate(&mut self, mut active: [bool; K]) {
        let mut p = vec![[0.0; K]; self.b.len()];
        let mut q = p.clone();
        self.multigrid.apply(&self.r, &mut self.z);
        let mut rz = dot(&self.r, &self.z);
        let mut beta = [0.0; K];
        self.coefficients.iter_mut().for_each(Vec::clear);
        while active.contains(&true) {
            scale_and_add(&beta, &self.z, &mut p);
            self.multigrid.matrix().multiply(&p, &mut q);
            let pq = dot(&p, &q);
            let alpha = std::array::from_fn(|l| if active[l] { rz[l] / pq[l] } else { 0.0 });
            add_scaled(&alpha, &p, &mut self.x);
            add_scaled(&alpha.map(|a| -a), &q, &mut self.r);
            self.multigrid.apply(&self.r, &mut self.z);
            let next = dot(&self.r, &self.z);
            for l in (0..K).filter(|&l| active[l]) {
                beta[l] = next[l] / rz[l];
                self.coefficients[l].push((alpha[l], beta[l]));
                self.reached[l].n_iterations += 1;
            }
            rz = next;
            self.judge(&rz);
            for l in 0..K {
                let reached = &self.reached[l];
                active[l] &= !self.is_good(reached, MARGIN)
                    && reached.n_iterations < self.measure.iterative.max_iterations
                    && alpha[l].is_finite()
                    && alpha[l] > 0.0
                    && rz[l] > 0.0;
            }
            for l in 0..K {
                if !active[l] {
                    beta[l] = 0.0;
                }
            }
        }
    }

    /// r ← b − K x afresh, and what it says.
    fn true_residual(&mut self) {
        self.r.copy_from_slice(&self.b);
        self.multigrid.matrix().subtract(&self.x, &mut self.r);
        self.multigrid.apply(&self.r, &mut self.z);
        let rz = dot(&self.r, &self.z);
        self.judge(&rz);
    }

    /// Sets the errors of every column from r, x and rᵀ M r.
    fn judge(&mut self, rz: &[f64; K]) {
        let left = scaled_max(&self.r, self.measure.scale, false);
        let moved = scaled_max(&self.x, self.measure.scale, true);
        let euclidean = dot(&self.r, &self.r);
        let energy = dot(&self.x, &self.b);
        for l in 0..K {
            let reached = &mut self.reached[l];
            let coefficients = &self.coefficients[l];
            if coefficients.len() % SPECTRUM_EVERY == 1
                && let Some(spectrum) = extreme_ritz_values(coefficients)
            {
                reached.widen(spectrum);
            }
            let size = self.measure.scaled_norm * moved[l] + self.loaded.0[l];
            reached.backward_error = ratio(left[l], size);
            reached.relative_residual = ratio(euclidean[l].sqrt(), self.loaded.1[l]);
            reached.energy_error = ratio((rz[l] / reached.spectrum.0).sqrt(), energy[l].sqrt());
        }
    }
}

/// Zero for nothing left of nothing loaded.
fn ratio(left: f64, of: f64) -> f64 {
    if left == 0.0 { 0.0 } else { left / of }
}
