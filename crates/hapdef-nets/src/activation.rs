//! What a hidden neuron does to its sum.

use serde::{Deserialize, Serialize};

/// The function after every hidden layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// Hyperbolic tangent. NaN becomes 1: check inputs before.
    Tanh,
    /// max(x, 0). NaN becomes 0: check inputs before.
    Relu,
}

impl Activation {
    /// `z[i] ← σ(z[i] + bias[i])`.
    pub(crate) fn apply(self, z: &mut [f32], bias: &[f32]) {
        let pairs = z.iter_mut().zip(bias);
        match self {
            Self::Relu => pairs.for_each(|(z, b)| *z = (*z + b).max(0.0)),
            Self::Tanh => pairs.for_each(|(z, b)| *z = tanh(*z + b)),
        }
    }

    /// `gradient[i] ← gradient[i] · σ'`, where σ' follows from the output a = σ(z) alone:
    /// 1 − a² for tanh, 1 where a > 0 and else 0 for ReLU.
    #[cfg(feature = "train")]
    pub(crate) fn apply_derivative(self, gradient: &mut [f32], output: &[f32]) {
        let pairs = gradient.iter_mut().zip(output);
        match self {
            Self::Relu => pairs.for_each(|(g, a)| *g = if *a > 0.0 { *g } else { 0.0 }),
            Self::Tanh => pairs.for_each(|(g, a)| *g *= 1.0 - a * a),
        }
    }
}

/// tanh without branches or calls, so that a loop over it becomes vector code; absolute error
/// below 3e-7.
///
/// |x| < 0.6: Lambert's continued fraction x/(1 + x²/(3 + x²/(5 + …))), cut at 13. Else
/// ±(1 − 2/(e^{2|x|} + 1)), which is exactly ±1 in f32 beyond |x| = 10.
#[inline(always)]
pub(crate) fn tanh(x: f32) -> f32 {
    let square = x * x;
    let numerator = x * (10_395.0 + square * (1_260.0 + square * 21.0));
    let denominator = 10_395.0 + square * (4_725.0 + square * (210.0 + square));
    let near = numerator / denominator;
    let magnitude = x.abs().min(10.0);
    let far = (1.0 - 2.0 / (exp(2.0 * magnitude) + 1.0)).copysign(x);
    if magnitude < 0.6 { near } else { far }
}

/// e^y for 0 ≤ y ≤ 20: y = k ln 2 + r, |r| ≤ ½ ln 2, Taylor's series to r⁷ for e^r.
#[inline(always)]
fn exp(y: f32) -> f32 {
    // Adding 1.5 · 2²³ rounds to an integer and leaves it in the low bits of the mantissa.
    const ROUND: f32 = 12_582_912.0;
    const LN2_HIGH: f32 = 0.693_359_4;
    const LN2_LOW: f32 = -2.121_944_4e-4;
    let shifted = y * std::f32::consts::LOG2_E + ROUND;
    let k = shifted - ROUND;
    let r = y - k * LN2_HIGH - k * LN2_LOW;
    let tail = 1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r / 5_040.0));
    let e_r = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * tail)));
    e_r * f32::from_bits((shifted.to_bits() << 23).wrapping_add(0x3f80_0000))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tanh_is_tanh() {
        let mut worst = (0.0, 0.0);
        for i in -2_000_000..=2_000_000 {
            let x = i as f32 * 6.1e-6;
            let error = (f64::from(tanh(x)) - f64::from(x).tanh()).abs();
            if error > worst.0 {
                worst = (error, x);
            }
        }
        assert!(worst.0 < 3e-7, "error {:.1e} at {}", worst.0, worst.1);
    }

    #[test]
    fn tanh_keeps_its_digits_near_zero_and_its_ends() {
        for x in [1e-30, 1e-6, 1e-3, 0.1f32] {
            let exact = f64::from(x).tanh();
            assert!((f64::from(tanh(x)) / exact - 1.0).abs() < 3e-7, "{x}");
        }
        assert_eq!([tanh(0.0), tanh(50.0), tanh(-1e30)], [0.0, 1.0, -1.0]);
        assert_eq!([tanh(f32::INFINITY), tanh(f32::NEG_INFINITY)], [1.0, -1.0]);
        assert_eq!(tanh(0.3), -tanh(-0.3));
    }
}
