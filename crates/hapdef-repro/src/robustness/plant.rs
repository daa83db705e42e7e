//! The problem that every row starts from: a smooth map of a few channels, and the methods on it.

use hapdef_nets::{Activation, TrainParams};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::baselines::{LinearParams, SvrParams};
use crate::error::ReproError;
use crate::search::{Fitted, Learner, NetSettings, Samples};

pub(super) const N_TRAIN: usize = 200;
const N_TEST: usize = 100;
pub(super) const N_OUT: usize = 3;

/// A method with its training and test samples; the test outputs are the truth.
#[derive(Clone)]
pub struct Plant {
    pub(super) learner: Learner,
    pub(super) n_in: usize,
    pub(super) x: Vec<f32>,
    pub(super) y: Vec<f32>,
    pub(super) test_x: Vec<f32>,
    pub(super) test_y: Vec<f32>,
}

impl Plant {
    /// Four channels evenly in ±1; y = (a + b²/2, sin c + a d, b − c).
    pub(super) fn new(seed: u64, learner: Learner) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_add(1));
        let mut draw = |n: usize| -> (Vec<f32>, Vec<f32>) {
            let word = |rng: &mut ChaCha8Rng| (rng.next_u32() >> 8) as f32 / 8_388_608.0 - 1.0;
            let x: Vec<f32> = (0..4 * n).map(|_| word(&mut rng)).collect();
            let rows = x.chunks_exact(4);
            let y = rows
                .flat_map(|r| [r[0] + 0.5 * r[1] * r[1], r[2].sin() + r[0] * r[3], r[1] - r[2]]);
            let y = y.collect();
            (x, y)
        };
        let ((x, y), (test_x, test_y)) = (draw(N_TRAIN), draw(N_TEST));
        Self { learner, n_in: 4, x, y, test_x, test_y }
    }

    /// Another method on the samples.
    pub(super) fn by(&self, learner: Learner) -> Self {
        Self { learner, ..self.clone() }
    }

    /// The samples after `change`.
    pub(super) fn changed(&self, change: impl FnOnce(&mut Self)) -> Self {
        let mut changed = self.clone();
        change(&mut changed);
        changed
    }

    /// Every input row through `change`, which may also change its width.
    pub(super) fn with_inputs(&self, change: impl Fn(&[f32]) -> Vec<f32>) -> Self {
        let through =
            |x: &[f32]| -> Vec<f32> { x.chunks_exact(self.n_in).flat_map(&change).collect() };
        let (x, test_x) = (through(&self.x), through(&self.test_x));
        Self { n_in: x.len() / N_TRAIN, x, test_x, ..self.clone() }
    }

    /// The method after its fit.
    pub(super) fn fitted(&self) -> Result<Fitted, ReproError> {
        let samples = Samples { x: &self.x, n_inputs: self.n_in, y: &self.y, n_outputs: N_OUT };
        self.learner.fit(&samples, &|| false)
    }

    /// Predictions for the test inputs.
    pub(super) fn predictions(&self) -> Result<Vec<f32>, ReproError> {
        self.fitted()?.predictions(&self.test_x, N_TEST)
    }

    /// RMS error on the test samples over the RMS spread of the test outputs about their means,
    /// for the outputs from `first` on: 1 is as good as the mean.
    pub(super) fn error_from(&self, first: usize) -> Result<f64, ReproError> {
        let found = self.predictions()?;
        let (mut squares, mut spread) = (0.0, 0.0);
        for column in first..N_OUT {
            let truth = || self.test_y.iter().skip(column).step_by(N_OUT).map(|v| f64::from(*v));
            let mean = truth().sum::<f64>() / N_TEST as f64;
            spread += truth().map(|v| (v - mean).powi(2)).sum::<f64>();
            let found = found.iter().skip(column).step_by(N_OUT).map(|v| f64::from(*v));
            squares += truth().zip(found).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        }
        Ok((squares / spread).sqrt())
    }

    /// [`Plant::error_from`] over all outputs.
    pub(super) fn error(&self) -> Result<f64, ReproError> {
        self.error_from(0)
    }

    /// Error over the error of another problem.
    pub(super) fn over(&self, other: &Self) -> Result<f64, ReproError> {
        Ok(self.error()? / other.error()?)
    }

    /// How far the predictions of another problem are from these.
    pub(super) fn apart(&self, other: &Self) -> Result<f64, ReproError> {
        Ok(largest_difference(&self.predictions()?, &other.predictions()?))
    }
}

/// The methods by name.
pub(super) fn methods() -> [(&'static str, Learner); 4] {
    let svr = SvrParams { epsilon: 1e-3, ..SvrParams::default() };
    [
        ("LR", Learner::Linear(LinearParams::default())),
        ("k-NN", Learner::Knn { k: 6 }),
        ("SVR", Learner::Svr(svr)),
        ("net", net(3e-3)),
    ]
}

/// A small net with this learning rate.
pub(super) fn net(learning_rate: f64) -> Learner {
    net_of(Activation::Relu, learning_rate)
}

/// The same of this activation.
pub(super) fn net_of(activation: Activation, learning_rate: f64) -> Learner {
    Learner::Net(NetSettings {
        hidden: vec![32, 32],
        activation,
        training: TrainParams {
            steps: 300,
            batch: 32,
            learning_rate,
            final_learning_rate: Some(learning_rate * 1e-2),
            ..TrainParams::paper(1)
        },
    })
}

/// The largest difference over the largest value.
pub(super) fn largest_difference(a: &[f32], b: &[f32]) -> f64 {
    let apart = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs()));
    let largest = a.iter().map(|a| f64::from(a.abs())).fold(f64::MIN_POSITIVE, f64::max);
    apart.fold(0.0, f64::max) / largest
}
