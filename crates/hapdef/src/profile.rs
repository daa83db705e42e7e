//! How much of everything a run makes: the paper's amounts, or a quick look.

use hapdef_nets::{Loss, TrainBackend};
use serde::{Deserialize, Serialize};

/// Amounts of data and training.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// `quick` or `full`.
    pub name: String,
    /// Single-contact samples, simulated; the paper has 27,000.
    pub n_single: usize,
    /// Samples of each of two, three and four contacts; the paper has 6,000.
    pub n_multi: usize,
    /// Single presses on the rig; the paper has 27,000.
    pub n_real_single: usize,
    /// Pairs of the double presses on the rig; the paper has 270.
    pub n_pairs: usize,
    /// Amplitudes per pair; the paper has 25.
    pub n_amplitudes: usize,
    /// Where each F_R's training samples come from.
    pub samples: Samples,
    /// Training of F_T.
    pub transfer: Schedule,
    /// Training of each F_R.
    pub reconstruction: Schedule,
    /// Modes of the map that F_R is trained in, to be unfolded to all surface nodes after; 0 trains
    /// the nodes themselves.
    #[serde(default)]
    pub output_modes: usize,
    /// By what the standardised outputs of F_R are divided.
    #[serde(default)]
    pub output_scale: OutputScale,
    /// Training of F_S.
    pub sensitivity: Schedule,
    /// Training of the direct net.
    pub direct: Schedule,
    /// What trains the nets.
    pub backend: TrainBackend,
    /// Samples the support-vector baseline is trained on; its cost grows with the square.
    pub n_svr: usize,
}

/// Where an F_R's training samples come from. Validation and test samples are those of the sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Samples {
    /// The training parts of the sets, as in the paper.
    Fixed,
    /// Drawn when needed, in equal shares of every contact count, none twice.
    Drawn,
}

/// By what the centred outputs of F_R are divided before training.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OutputScale {
    /// Each by its own deviation, as in the paper: all nodes count alike.
    #[default]
    Each,
    /// All by one deviation: micrometres count alike.
    One,
}

/// How long and how fast one net is trained.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Schedule {
    /// Optimiser steps; the paper has 1,000,000.
    pub steps: usize,
    /// Samples of a step; the paper has 100.
    pub batch: usize,
    /// Steps over which the learning rate first rises.
    pub warmup_steps: usize,
    /// Learning rate after that; the paper has 1e-4 throughout.
    pub learning_rate: f64,
    /// Learning rate at the last step, reached along a cosine.
    pub final_learning_rate: f64,
    /// What is minimised; the paper has √MSE.
    #[serde(default)]
    pub loss: Loss,
    /// Weight of the L2 term on the weights.
    pub l2: f64,
    /// Looks at the validation set, of 20, without a lower loss after which the training ends; 0
    /// goes on to the end. The weights with the lowest loss are kept in any case.
    pub patience: u64,
}

impl Profile {
    /// A run of minutes: fewer samples, short training.
    #[must_use]
    pub fn quick() -> Self {
        Self {
            name: "quick".into(),
            n_single: 8_000,
            n_multi: 2_000,
            n_real_single: 8_000,
            n_pairs: 60,
            n_amplitudes: 25,
            samples: Samples::Fixed,
            transfer: schedule(2_000, 1e-3),
            reconstruction: schedule(500, 5e-4),
            output_modes: 0,
            output_scale: OutputScale::Each,
            sensitivity: schedule(2_000, 1e-3),
            direct: schedule(1_500, 1e-3),
            backend: TrainBackend::Slices,
            n_svr: 1_000,
        }
    }

    /// The paper's data for every net but F_R, whose training samples are drawn, 6 million of them.
    /// Training is shorter than the paper's million steps and starts at a higher learning rate; F_R
    /// is trained to what Table 1 counts, micrometres and not squares of each node's deviation.
    #[must_use]
    pub fn full() -> Self {
        Self {
            name: "full".into(),
            n_single: 27_000,
            n_multi: 6_000,
            n_real_single: 27_000,
            n_pairs: 270,
            n_amplitudes: 25,
            samples: Samples::Drawn,
            transfer: schedule(10_000, 1e-3),
            reconstruction: Schedule {
                batch: 256,
                warmup_steps: 200,
                loss: Loss::MeanOfSamples,
                ..schedule(24_000, 3e-3)
            },
            output_modes: 512,
            output_scale: OutputScale::One,
            sensitivity: schedule(10_000, 1e-3),
            direct: schedule(10_000, 1e-3),
            backend: TrainBackend::Slices,
            n_svr: 4_000,
        }
    }
}

fn schedule(steps: usize, learning_rate: f64) -> Schedule {
    Schedule {
        steps,
        batch: 100,
        warmup_steps: 0,
        learning_rate,
        final_learning_rate: learning_rate * 1e-2,
        loss: Loss::RootMeanSquare,
        l2: 0.0,
        patience: 0,
    }
}
