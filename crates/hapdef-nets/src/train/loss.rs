//! The losses that a training minimises.

use rayon::prelude::*;

use crate::params::Loss;

/// The loss of outputs `p` against `y`, both `[n, width]`, and in place of `p` its derivative by
/// them; 0 where the root is of 0.
pub(super) fn differentiate(loss: Loss, p: &mut [f32], y: &[f32], width: usize) -> f64 {
    match loss {
        Loss::RootMeanSquare => {
            let n = p.len() as f64;
            let root = (subtract(p, y) / n).sqrt();
            let factor = reciprocal(n * root);
            let blocks = p.par_chunks_mut(SUM_BLOCK);
            blocks.for_each(|p| p.iter_mut().for_each(|p| *p *= factor));
            root
        }
        Loss::MeanOfSamples => {
            let n_samples = (p.len() / width) as f64;
            let roots = each_sample(p, y, width, |p, root| {
                let factor = reciprocal(n_samples * width as f64 * root);
                p.iter_mut().for_each(|p| *p *= factor);
            });
            roots.iter().sum::<f64>() / n_samples
        }
    }
}

/// The loss of many batches as one.
pub(super) struct LossSum {
    loss: Loss,
    width: usize,
    n_samples: usize,
    /// Σ of the squares, or of the samples' roots.
    sum: f64,
}

impl LossSum {
    pub(super) fn new(loss: Loss, width: usize) -> Self {
        Self { loss, width, n_samples: 0, sum: 0.0 }
    }

    /// Adds a batch of outputs `p` against `y`, both `[n, width]`; leaves p − y in place of `p`.
    pub(super) fn add(&mut self, p: &mut [f32], y: &[f32]) {
        self.n_samples += p.len() / self.width;
        self.sum += match self.loss {
            Loss::RootMeanSquare => subtract(p, y),
            Loss::MeanOfSamples => each_sample(p, y, self.width, |_, _| {}).iter().sum(),
        };
    }

    pub(super) fn value(&self) -> f64 {
        match self.loss {
            Loss::RootMeanSquare => (self.sum / (self.n_samples * self.width) as f64).sqrt(),
            Loss::MeanOfSamples => self.sum / self.n_samples as f64,
        }
    }
}

/// Values that one thread adds up. Blocks do not depend on the number of threads.
const SUM_BLOCK: usize = 1 << 15;

/// `p ← p − y`; returns Σ (p − y)².
fn subtract(p: &mut [f32], y: &[f32]) -> f64 {
    let blocks = p.par_chunks_mut(SUM_BLOCK).zip(y.par_chunks(SUM_BLOCK));
    let sums: Vec<f64> = blocks
        .map(|(p, y)| {
            p.iter_mut().zip(y).for_each(|(p, y)| *p -= y);
            sum_of_squares(p)
        })
        .collect();
    sums.into_iter().sum()
}

/// `p ← p − y`; returns √MSE of every sample, after `with` had it and its difference.
fn each_sample(
    p: &mut [f32],
    y: &[f32],
    width: usize,
    with: impl Fn(&mut [f32], f64) + Sync,
) -> Vec<f64> {
    let samples = p.par_chunks_mut(width).zip(y.par_chunks(width));
    samples
        .map(|(p, y)| {
            p.iter_mut().zip(y).for_each(|(p, y)| *p -= y);
            let root = (sum_of_squares(p) / width as f64).sqrt();
            with(p, root);
            root
        })
        .collect()
}

fn reciprocal(value: f64) -> f32 {
    if value > 0.0 { (1.0 / value) as f32 } else { 0.0 }
}

/// Σ v² in f64, as eight independent sums added in a fixed order.
pub(super) fn sum_of_squares(values: &[f32]) -> f64 {
    let (blocks, rest) = values.as_chunks::<8>();
    let mut sums = [0.0f64; 8];
    for block in blocks {
        for (sum, &v) in sums.iter_mut().zip(block) {
            *sum += f64::from(v) * f64::from(v);
        }
    }
    let rest = rest.iter().map(|&v| f64::from(v) * f64::from(v));
    sums.into_iter().chain(rest).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two samples of two outputs, off by (3, 4) and by nothing.
    const P: [f32; 4] = [4.0, 6.0, 5.0, 5.0];
    const Y: [f32; 4] = [1.0, 2.0, 5.0, 5.0];

    #[test]
    fn the_losses_of_two_samples_by_hand() {
        let of_sample = 12.5f64.sqrt();
        let cases = [
            (Loss::RootMeanSquare, 2.5, [3.0 / 10.0, 4.0 / 10.0]),
            (Loss::MeanOfSamples, of_sample / 2.0, [3.0, 4.0].map(|e| e / (4.0 * of_sample))),
        ];
        for (loss, expected, derivative) in cases {
            let mut p = P;
            let value = differentiate(loss, &mut p, &Y, 2);
            assert!((value - expected).abs() < 1e-12, "{loss:?}: {value}");
            for (found, expected) in p.iter().zip(derivative) {
                assert!((f64::from(*found) - expected).abs() < 1e-6, "{loss:?}: {p:?}");
            }
            assert_eq!(p[2..], [0.0, 0.0]);
        }
    }

    #[test]
    fn batches_add_up_to_the_loss_of_all() {
        for loss in [Loss::RootMeanSquare, Loss::MeanOfSamples] {
            let whole = differentiate(loss, &mut P.clone(), &Y, 2);
            let mut sum = LossSum::new(loss, 2);
            for (p, y) in P.clone().chunks_mut(2).zip(Y.chunks(2)) {
                sum.add(p, y);
            }
            assert!((sum.value() - whole).abs() < 1e-12, "{loss:?}");
        }
    }
}
