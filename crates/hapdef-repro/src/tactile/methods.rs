//! The methods on one run of the skin, each with the paper's settings and with settings chosen on
//! part of the training presses.

use std::time::Instant;

use hapdef_bench::stats::{mean, quantile, sorted};
use hapdef_nets::{Activation, TrainParams};

use super::runs::TactileRun;
use crate::baselines::{LinearParams, SvrParams};
use crate::error::ReproError;
use crate::search::{Learner, NetSettings, Samples, TrialBudget};

/// The settings of a method that validation chooses among.
type Settings = fn(&TrialBudget) -> Vec<Learner>;

/// Every method, in the table's order; the first of its settings are the paper's (Sun & Martius 2019,
/// section 4.1; the net's training is shorter than theirs).
pub const TACTILE_METHODS: [(&str, Settings); 4] = [
    ("LR", |_| {
        [0.0, 1e-4, 1e-3, 1e-2, 1e-1]
            .map(|ridge| Learner::Linear(LinearParams { ridge, ..LinearParams::default() }))
            .to_vec()
    }),
    ("k-NN", |_| [6, 1, 2, 3, 4, 5, 8, 10].map(|k| Learner::Knn { k }).to_vec()),
    ("SVR", |budget| {
        let svr = |(c, gamma, epsilon)| {
            Learner::Svr(SvrParams {
                c,
                gamma,
                epsilon,
                max_samples: budget.n_svr,
                seed: budget.seed,
                ..SvrParams::default()
            })
        };
        [
            (20.0, 0.125, 1e-6),
            (20.0, 0.125, 1e-2),
            (20.0, 0.5, 1e-2),
            (200.0, 0.125, 1e-2),
            (200.0, 0.03125, 1e-2),
        ]
        .map(svr)
        .to_vec()
    }),
    ("FNN", |budget| {
        vec![
            net(budget, &[500; 5], Activation::Relu, 1e-4, 1.0),
            net(budget, &[500; 5], Activation::Relu, 1e-3, 1e-2),
            net(budget, &[128; 3], Activation::Relu, 2e-3, 1e-2),
            net(budget, &[128; 3], Activation::Tanh, 2e-3, 1e-2),
            net(budget, &[128; 2], Activation::Tanh, 5e-3, 1e-2),
        ]
    }),
];

/// How one method did on the test presses.
#[derive(Clone, Debug, PartialEq)]
pub struct TactileScore {
    /// The method.
    pub method: &'static str,
    /// Its settings in words.
    pub settings: String,
    /// Whether the settings were chosen on validation presses; else they are the paper's.
    pub is_chosen: bool,
    /// Mean distance between the place found and the true one, mm.
    pub mean_mm: f64,
    /// Median of that distance, mm.
    pub median_mm: f64,
    /// Presses trained on.
    pub n_train: usize,
    /// Presses tested on.
    pub n_test: usize,
    /// Time of choice, fit and prediction, s.
    pub elapsed_s: f64,
}

fn net(
    budget: &TrialBudget,
    hidden: &[usize],
    activation: Activation,
    learning_rate: f64,
    fall: f64,
) -> Learner {
    let training = TrainParams {
        steps: budget.steps,
        batch: 100,
        learning_rate,
        final_learning_rate: Some(learning_rate * fall),
        ..TrainParams::paper(budget.seed)
    };
    Learner::Net(NetSettings { hidden: hidden.to_vec(), activation, training })
}

/// Scores a method on a run, with the paper's settings and with chosen ones.
///
/// `order` is a permutation of the presses: the first four fifths train, the rest test. Settings
/// are chosen by the mean distance on the last fifth of the training presses, then fitted to all
/// training presses.
pub fn tactile_scores(
    run: &TactileRun,
    order: &[usize],
    (method, settings): (&'static str, &[Learner]),
) -> Result<[TactileScore; 2], ReproError> {
    let (train, test) = order.split_at(order.len() * 4 / 5);
    let (fit, validation) = train.split_at(train.len() * 4 / 5);
    let score = |is_chosen: bool, learner: &Learner, start: Instant| {
        let distances = sorted(tactile_distances_mm(run, learner, train, test)?);
        Ok::<_, ReproError>(TactileScore {
            method,
            settings: in_words(learner, train.len()),
            is_chosen,
            mean_mm: mean(distances.iter().copied()),
            median_mm: quantile(&distances, 0.5),
            n_train: train.len(),
            n_test: test.len(),
            elapsed_s: start.elapsed().as_secs_f64(),
        })
    };
    let paper = score(false, &settings[0], Instant::now())?;
    let start = Instant::now();
    let mut best = (f64::INFINITY, &settings[0]);
    for learner in settings {
        let error_mm = mean(tactile_distances_mm(run, learner, fit, validation)?);
        if error_mm < best.0 {
            best = (error_mm, learner);
        }
    }
    Ok([paper, score(true, best.1, start)?])
}

/// Distances between the places that `learner` finds and the true ones, `[queries.len()]`, mm;
/// `train` and `queries` are presses of the run.
pub fn tactile_distances_mm(
    run: &TactileRun,
    learner: &Learner,
    train: &[usize],
    queries: &[usize],
) -> Result<Vec<f64>, ReproError> {
    let x = rows(&run.channels, run.n_channels, train);
    let y = rows(&run.place_mm, 2, train);
    let samples = Samples { x: &x, n_inputs: run.n_channels, y: &y, n_outputs: 2 };
    let fitted = learner.fit(&samples, &|| false)?;
    let x = rows(&run.channels, run.n_channels, queries);
    let found = fitted.predictions(&x, queries.len())?;
    let truth = rows(&run.place_mm, 2, queries);
    let pairs = found.chunks_exact(2).zip(truth.chunks_exact(2));
    Ok(pairs.map(|(a, b)| f64::from(a[0] - b[0]).hypot(f64::from(a[1] - b[1]))).collect())
}

fn rows(all: &[f32], width: usize, picked: &[usize]) -> Vec<f32> {
    picked.iter().flat_map(|row| &all[row * width..(row + 1) * width]).copied().collect()
}

fn in_words(learner: &Learner, n_train: usize) -> String {
    match learner {
        Learner::Linear(params) => format!("ridge {}", params.ridge),
        Learner::Knn { k } => format!("k = {k}, weights 1/distance"),
        Learner::Svr(p) => format!(
            "C {}, γ {}, ε {}, {} of {n_train} presses",
            p.c,
            p.gamma,
            p.epsilon,
            p.max_samples.min(n_train)
        ),
        Learner::Net(net) => format!(
            "{:?} {:?}, rate {}, {} steps",
            net.hidden, net.activation, net.training.learning_rate, net.training.steps
        ),
    }
}
