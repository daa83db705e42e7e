//! Adam, in one pass over the weights.

use crate::train::loss::sum_of_squares;

/// One step of Adam (D. P. Kingma and J. Ba, "Adam: A Method for Stochastic Optimization", ICLR
/// 2015, arXiv 1412.6980, algorithm 1, in the order of operations that its section 2 proposes).
#[derive(Debug, Clone, Copy)]
pub(super) struct AdamStep {
    /// α √(1 − β₂ᵗ)/(1 − β₁ᵗ).
    pub(super) step_size: f32,
    /// ε √(1 − β₂ᵗ).
    pub(super) epsilon: f32,
    /// 2 λ, the derivative of λ w² by w, over w.
    pub(super) decay: f32,
}

/// β₁.
pub(super) const BETA_1: f32 = 0.9;
/// β₂.
pub(super) const BETA_2: f32 = 0.999;
const EPSILON: f64 = 1e-8;

/// Some weights or biases with their moments.
pub(super) struct Part<'a> {
    pub(super) w: &'a mut [f32],
    pub(super) m: &'a mut [f32],
    pub(super) v: &'a mut [f32],
}

/// What becomes of the derivatives of a backward pass.
pub(super) trait Update: Sync {
    /// Takes the derivatives by some weights.
    fn weights(&self, part: Part<'_>, gradient: &[f32]) -> f64;

    /// Takes the derivatives by a layer's biases.
    fn biases(&self, part: Part<'_>, gradient: &[f32]) -> f64;
}

impl Update for AdamStep {
    /// Changes the weights, and returns Σ w² of them as they were; 0 where there is no penalty.
    fn weights(&self, part: Part<'_>, gradient: &[f32]) -> f64 {
        let sum = match self.decay > 0.0 {
            true => sum_of_squares(part.w),
            false => 0.0,
        };
        self.change(part.w, gradient, part.m, part.v);
        sum
    }

    /// Changes the biases, which carry no penalty.
    fn biases(&self, part: Part<'_>, gradient: &[f32]) -> f64 {
        let without_decay = Self { decay: 0.0, ..*self };
        without_decay.change(part.w, gradient, part.m, part.v);
        0.0
    }
}

impl AdamStep {
    /// The step after `n_done` steps, with step size `learning_rate` and the penalty `l2` Σ w².
    pub(super) fn new(n_done: u64, learning_rate: f64, l2: f64) -> Self {
        let t = (n_done + 1) as f64;
        let correction_1 = 1.0 - f64::from(BETA_1).powf(t);
        let correction_2 = (1.0 - f64::from(BETA_2).powf(t)).sqrt();
        Self {
            step_size: (learning_rate * correction_2 / correction_1) as f32,
            epsilon: (EPSILON * correction_2) as f32,
            decay: (2.0 * l2) as f32,
        }
    }

    fn change(&self, w: &mut [f32], g: &[f32], m: &mut [f32], v: &mut [f32]) {
        let moments = m.iter_mut().zip(v);
        for ((w, g), (m, v)) in w.iter_mut().zip(g).zip(moments) {
            let g = g + self.decay * *w;
            *m = flush(BETA_1 * *m + (1.0 - BETA_1) * g);
            *v = flush(BETA_2 * *v + (1.0 - BETA_2) * g * g);
            *w -= self.step_size * *m / (v.sqrt() + self.epsilon);
        }
    }
}

/// 0 in place of a subnormal number. Where a gradient stays 0, a moment would decay to a subnormal
/// number and stay there, and arithmetic on those is a hundred times slower.
#[inline]
fn flush(x: f32) -> f32 {
    if x.abs() < f32::MIN_POSITIVE { 0.0 } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Algorithm 1 of the paper, word for word, in f64.
    fn textbook(w: f64, gradients: &[f64], alpha: f64) -> f64 {
        let (mut m, mut v, mut w) = (0.0, 0.0, w);
        for (t, g) in (1..).zip(gradients) {
            m = 0.9 * m + 0.1 * g;
            v = 0.999 * v + 0.001 * g * g;
            let m_hat = m / (1.0 - 0.9f64.powi(t));
            let v_hat = v / (1.0 - 0.999f64.powi(t));
            w -= alpha * m_hat / (v_hat.sqrt() + 1e-8);
        }
        w
    }

    #[test]
    fn steps_are_the_textbook_s() {
        for scale in [1e-7, 1.0, 1e3] {
            let gradients: Vec<f64> =
                (0..200).map(|i| scale * (f64::from(i) * 0.7).sin()).collect();
            let (mut w, mut m, mut v) = ([0.5f32], [0.0f32], [0.0f32]);
            for (done, g) in (0..).zip(&gradients) {
                AdamStep::new(done, 1e-2, 0.0).change(&mut w, &[*g as f32], &mut m, &mut v);
            }
            let expected = textbook(0.5, &gradients, 1e-2);
            assert!((f64::from(w[0]) - expected).abs() < 2e-5, "{scale}: {w:?}, {expected}");
        }
    }

    #[test]
    fn moments_of_a_dead_weight_end_at_zero() {
        let (mut w, mut m, mut v) = ([0.5f32], [1e-6f32], [1e-30f32]);
        for done in 0..30_000 {
            AdamStep::new(done, 1e-4, 0.0).change(&mut w, &[0.0], &mut m, &mut v);
        }
        assert_eq!((m, v), ([0.0], [0.0]));
        assert!(w[0].is_finite());
    }

    #[test]
    fn the_penalty_pulls_weights_to_zero_and_is_summed() {
        let n = 1017;
        let (mut w, mut m, mut v) = (vec![0.5f32; n], vec![0.0; n], vec![0.0; n]);
        let zeros = vec![0.0; n];
        let step = AdamStep::new(0, 1e-2, 1e-3);
        let part = Part { w: &mut w, m: &mut m, v: &mut v };
        let sum = step.weights(part, &zeros);
        assert_eq!(sum, 0.25 * n as f64);
        assert!(w.iter().all(|w| (w - 0.49).abs() < 1e-6), "{}", w[0]);
    }
}
