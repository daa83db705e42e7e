//! The parameters of a training.

use serde::{Deserialize, Serialize};

use crate::backend::TrainBackend;
use crate::error::NetsError;

/// What a training minimises, of the differences between a net's outputs and the standardised ones.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Loss {
    /// √MSE over a batch and all outputs, the paper's.
    #[default]
    RootMeanSquare,
    /// Mean over the samples of each one's √MSE (the norm L2,1 of C. Ding et al., "R1-PCA", ICML
    /// 2006): no sample is heard more than another because its error is large.
    MeanOfSamples,
}

impl Loss {
    fn is_the_papers(&self) -> bool {
        *self == Self::RootMeanSquare
    }
}

/// How a net is trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainParams {
    /// Steps of the optimiser in all, those before a resume included.
    pub steps: u64,
    /// Samples per step, drawn with replacement.
    pub batch: usize,
    /// Adam's step size at the start.
    pub learning_rate: f64,
    /// Step size at the end, reached along half a cosine; none keeps it constant.
    pub final_learning_rate: Option<f64>,
    /// Steps over which the step size first rises, in proportion, to the start of the cosine; 0
    /// for none.
    pub warmup_steps: u64,
    /// What is minimised; without it the paper's √MSE.
    #[serde(default, skip_serializing_if = "Loss::is_the_papers")]
    pub loss: Loss,
    /// λ of the penalty λ Σ w² over the weights, biases left out, that is added to the loss.
    ///
    /// The paper states 1e-3 for F_T, 1e-4 for F_R, 6e-4 for F_S; the authors' published code,
    /// read closely, applies next to none of it, and 0 agrees best with what they report.
    pub l2: f64,
    /// What does the arithmetic.
    #[serde(default)]
    pub backend: TrainBackend,
    /// Seed of the order in which samples are drawn.
    pub seed: u64,
    /// Steps between checkpoints; 0 writes one at the end alone.
    pub checkpoint_every: u64,
    /// Steps between looks at the validation set; 0 looks at the end alone.
    pub validate_every: u64,
    /// Whether the weights of the look with the lowest validation loss are the result, rather than
    /// those of the last step.
    pub keep_best: bool,
    /// Looks at the validation set in a row without a new lowest loss after which the training
    /// ends (early stopping); 0 goes on to the last step.
    pub patience: u64,
}

impl TrainParams {
    /// The settings of the authors' code: 1,000,000 steps of 100 samples, step size 1e-4, no
    /// penalty; with a checkpoint and a validation every 10,000 steps.
    pub fn paper(seed: u64) -> Self {
        Self {
            steps: 1_000_000,
            batch: 100,
            learning_rate: 1e-4,
            final_learning_rate: None,
            warmup_steps: 0,
            loss: Loss::RootMeanSquare,
            l2: 0.0,
            backend: TrainBackend::default(),
            seed,
            checkpoint_every: 10_000,
            validate_every: 10_000,
            keep_best: false,
            patience: 0,
        }
    }

    /// Fails if a parameter is out of range.
    pub fn check(&self) -> Result<(), NetsError> {
        let refuse = |name, value, range| Err(NetsError::Param { name, value, range });
        let is_rate = |rate: f64| rate > 0.0 && rate.is_finite();
        let last = self.final_learning_rate.unwrap_or(self.learning_rate);
        if self.batch == 0 {
            return refuse("batch", 0.0, "at least 1");
        }
        if !is_rate(self.learning_rate) {
            return refuse("learning_rate", self.learning_rate, "positive and finite");
        }
        if !is_rate(last) {
            return refuse("final_learning_rate", last, "positive and finite");
        }
        if !(self.l2 >= 0.0 && self.l2.is_finite()) {
            return refuse("l2", self.l2, "finite and at least 0");
        }
        Ok(())
    }

    /// Step size of `step`, counted from 0.
    ///
    /// During the warm-up of w steps: `first (step + 1)/(w + 1)` (P. Goyal et al., "Accurate,
    /// Large Minibatch SGD", arXiv 1706.02677, section 2.2). After it, with a final value:
    /// `last + ½ (first − last)(1 + cos(π s))`, s running from 0 after the warm-up to 1 at the last
    /// step (I. Loshchilov and F. Hutter, "SGDR", ICLR 2017, arXiv 1608.03983, equation 5, without
    /// restarts).
    pub fn learning_rate_at(&self, step: u64) -> f64 {
        if step < self.warmup_steps {
            return self.learning_rate * (step + 1) as f64 / (self.warmup_steps + 1) as f64;
        }
        let Some(last) = self.final_learning_rate else {
            return self.learning_rate;
        };
        let end = self.steps.saturating_sub(1 + self.warmup_steps).max(1);
        let share = (step - self.warmup_steps).min(end) as f64 / end as f64;
        last + 0.5 * (self.learning_rate - last) * (1.0 + (std::f64::consts::PI * share).cos())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_size_falls_from_the_first_to_the_last_value() {
        let mut params = TrainParams::paper(0);
        assert_eq!(params.learning_rate_at(999_999), 1e-4);
        params.final_learning_rate = Some(1e-6);
        assert_eq!(params.learning_rate_at(0), 1e-4);
        assert!((params.learning_rate_at(500_000) / 0.505e-4 - 1.0).abs() < 1e-4);
        assert!((params.learning_rate_at(999_999) / 1e-6 - 1.0).abs() < 1e-9);
        let rates: Vec<_> = (0..100).map(|i| params.learning_rate_at(i * 10_000)).collect();
        assert!(rates.is_sorted_by(|a, b| a > b));
    }

    #[test]
    fn the_step_size_rises_to_the_cosine_and_then_falls() {
        let params = TrainParams {
            steps: 1000,
            warmup_steps: 99,
            final_learning_rate: Some(1e-6),
            ..TrainParams::paper(0)
        };
        assert!((params.learning_rate_at(0) / 1e-6 - 1.0).abs() < 1e-9);
        assert!((params.learning_rate_at(49) / 0.5e-4 - 1.0).abs() < 1e-9);
        assert_eq!(params.learning_rate_at(99), 1e-4);
        assert!((params.learning_rate_at(999) / 1e-6 - 1.0).abs() < 1e-9);
        let rates: Vec<_> = (0..1000).map(|i| params.learning_rate_at(i)).collect();
        assert!(rates[..=99].is_sorted_by(|a, b| a < b));
        assert!(rates[99..].is_sorted_by(|a, b| a > b));
    }

    #[test]
    fn knobs_out_of_range_are_refused_by_name() {
        let refused = |change: fn(&mut TrainParams)| {
            let mut params = TrainParams::paper(0);
            change(&mut params);
            match params.check() {
                Err(NetsError::Param { name, .. }) => name,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(refused(|p| p.batch = 0), "batch");
        assert_eq!(refused(|p| p.learning_rate = f64::NAN), "learning_rate");
        assert_eq!(refused(|p| p.final_learning_rate = Some(0.0)), "final_learning_rate");
        assert_eq!(refused(|p| p.l2 = -1.0), "l2");
    }
}
