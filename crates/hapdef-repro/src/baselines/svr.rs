//! ε-support-vector regression with an RBF kernel, one machine per output.
//!
//! exp(−γ‖a−b‖²) on standardised inputs, outputs standardised too; the solver is libsvm's
//! (Chang & Lin, ACM TIST 2(3):27, 2011) in Rust. Training time grows with about the square of
//! the samples, so callers subsample; the result says how many samples it rests on.

use hapdef_report::{ArgumentError, check_len};
use libsvm_rs::predict::predict;
use libsvm_rs::train::svm_train;
use libsvm_rs::{KernelType, SvmModel, SvmNode, SvmParameterBuilder, SvmProblem, SvmType};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use serde::Serialize;

use crate::error::{ReproError, check_finite, check_parameter, whole_rows};

/// Parameters of [`Svr::train`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SvrParams {
    /// Penalty C of a residual beyond ε.
    pub c: f64,
    /// Half width ε of the tube without penalty, in standard deviations of the output.
    pub epsilon: f64,
    /// Kernel width γ, per squared standard deviation of the inputs.
    pub gamma: f64,
    /// libsvm's stopping tolerance on the optimality conditions.
    pub tolerance: f64,
    /// Most samples to train on; more are thinned by a seeded draw without replacement.
    pub max_samples: usize,
    /// Seed of that draw.
    pub seed: u64,
}

impl Default for SvrParams {
    /// The paper's C = 20, ε = 1e-6, γ = 2⁻³; libsvm's tolerance 1e-3; 2,000 samples, seed 0.
    fn default() -> Self {
        Self { c: 20.0, epsilon: 1e-6, gamma: 0.125, tolerance: 1e-3, max_samples: 2000, seed: 0 }
    }
}

/// What [`Svr::train`] did.
#[derive(Clone, Debug, PartialEq)]
pub struct SvrInfo {
    /// Samples offered.
    pub n_offered: usize,
    /// Samples trained on; fewer than offered when thinned.
    pub n_trained: usize,
    /// Seed of the thinning.
    pub seed: u64,
    /// Support vectors of each output's machine, `[n_outputs]`.
    pub n_support: Vec<usize>,
}

/// One trained machine per output.
#[derive(Clone, Debug)]
pub struct Svr {
    x_scaling: Vec<Scaling>,
    y_scaling: Vec<Scaling>,
    machines: Vec<SvmModel>,
}

impl Svr {
    /// Trains on `x` `[n, n_inputs]` and `y` `[n, n_outputs]`, row-major.
    ///
    /// Standardisation uses the samples trained on. An output that never varies is predicted as
    /// that constant. Machines train in parallel; the result does not depend on threads.
    pub fn train(
        x: &[f32],
        y: &[f32],
        n_inputs: usize,
        n_outputs: usize,
        params: &SvrParams,
    ) -> Result<(Self, SvrInfo), ReproError> {
        let n = whole_rows("SVR inputs", n_inputs, x.len())?;
        check_len("SVR outputs", n * n_outputs, y.len())?;
        check_finite("SVR inputs", n_inputs, x)?;
        check_finite("SVR outputs", n_outputs, y)?;
        params.check()?;
        let picked = draw(n, params.max_samples, params.seed);
        if picked.len() < 2 {
            let found = picked.len();
            return Err(ReproError::TooFewSamples { what: "SVR", needed: 2, found });
        }
        let x_scaling = scalings(x, n_inputs, &picked);
        let y_scaling = scalings(y, n_outputs, &picked);
        let instances: Vec<Vec<SvmNode>> = picked
            .iter()
            .map(|&i| nodes(&x[i * n_inputs..(i + 1) * n_inputs], &x_scaling))
            .collect();
        libsvm_rs::set_quiet(true);
        let svm = params.libsvm()?;
        let train = |j: usize| {
            let scaled = |&i: &usize| y_scaling[j].forward(y[i * n_outputs + j]);
            let labels = picked.iter().map(scaled).collect();
            let instances = instances.clone();
            svm_train(&SvmProblem { labels, instances }, &svm)
        };
        let machines: Vec<SvmModel> = (0..n_outputs).into_par_iter().map(train).collect();
        let info = SvrInfo {
            n_offered: n,
            n_trained: picked.len(),
            seed: params.seed,
            n_support: machines.iter().map(|m| m.sv.len()).collect(),
        };
        let svr = Self { x_scaling, y_scaling, machines };
        Ok((svr, info))
    }

    /// Values in one output row.
    pub fn n_outputs(&self) -> usize {
        self.machines.len()
    }

    /// Predicts `out` `[n, n_outputs]` from `x` `[n, n_inputs]`, row-major, in training units.
    pub fn predict(&self, x: &[f32], out: &mut [f32]) -> Result<(), ReproError> {
        let (p, q) = (self.x_scaling.len(), self.machines.len());
        let n = whole_rows("SVR inputs", p, x.len())?;
        check_len("SVR predictions", n * q, out.len())?;
        check_finite("SVR inputs", p, x)?;
        if q == 0 {
            return Ok(());
        }
        out.par_chunks_mut(q).zip(x.par_chunks(p)).for_each(|(out, x)| {
            let x = nodes(x, &self.x_scaling);
            for (j, out) in out.iter_mut().enumerate() {
                *out = self.y_scaling[j].back(predict(&self.machines[j], &x));
            }
        });
        Ok(())
    }
}

impl SvrParams {
    fn check(&self) -> Result<(), ReproError> {
        for (what, value) in
            [("SVR c", self.c), ("SVR gamma", self.gamma), ("SVR tolerance", self.tolerance)]
        {
            let is_fine = value > 0.0 && value.is_finite();
            check_parameter(what, value, "finite and above 0", is_fine)?;
        }
        let is_fine = self.epsilon >= 0.0 && self.epsilon.is_finite();
        check_parameter("SVR epsilon", self.epsilon, "finite and at least 0", is_fine)
    }

    fn libsvm(&self) -> Result<libsvm_rs::SvmParameter, ReproError> {
        SvmParameterBuilder::new()
            .svm_type(SvmType::EpsilonSvr)
            .kernel_type(KernelType::Rbf)
            .gamma(self.gamma)
            .c(self.c)
            .p(self.epsilon)
            .eps(self.tolerance)
            .cache_size(200.0)
            .build()
            .map_err(|_| {
                let what = "SVR gamma";
                let expected = "a value that libsvm accepts";
                ArgumentError::Parameter { what, value: self.gamma, expected }.into()
            })
    }
}

/// Affine map of one column to mean 0, standard deviation 1.
#[derive(Clone, Copy, Debug)]
struct Scaling {
    mean: f64,
    std: f64,
}

impl Scaling {
    fn forward(&self, value: f32) -> f64 {
        if self.std > 0.0 { (f64::from(value) - self.mean) / self.std } else { 0.0 }
    }

    fn back(&self, value: f64) -> f32 {
        (value * self.std + self.mean) as f32
    }
}

fn scalings(rows: &[f32], width: usize, picked: &[usize]) -> Vec<Scaling> {
    let n = picked.len() as f64;
    (0..width)
        .map(|j| {
            let column = || picked.iter().map(|&i| f64::from(rows[i * width + j]));
            let mean = column().sum::<f64>() / n;
            let std = (column().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt();
            Scaling { mean, std: if std > 1e-12 * mean.abs() { std } else { 0.0 } }
        })
        .collect()
}

fn nodes(row: &[f32], scaling: &[Scaling]) -> Vec<SvmNode> {
    let node = |(i, (v, s)): (usize, (&f32, &Scaling))| SvmNode {
        index: i as i32 + 1,
        value: s.forward(*v),
    };
    row.iter().zip(scaling).enumerate().map(node).collect()
}

/// `min(n, most)` of `0..n` in rising order: partial Fisher–Yates, indices by rejection.
fn draw(n: usize, most: usize, seed: u64) -> Vec<usize> {
    let mut all: Vec<usize> = (0..n).collect();
    if n > most {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for i in 0..most {
            all.swap(i, i + below(&mut rng, (n - i) as u64) as usize);
        }
        all.truncate(most);
        all.sort_unstable();
    }
    all
}

/// Uniform in `0..bound`.
fn below(rng: &mut ChaCha8Rng, bound: u64) -> u64 {
    let limit = u64::MAX - u64::MAX % bound;
    loop {
        let value = rng.next_u64();
        if value < limit {
            return value % bound;
        }
    }
}

#[cfg(test)]
mod tests;
