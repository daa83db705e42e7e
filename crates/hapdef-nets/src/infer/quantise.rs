//! Numbers in fewer bits.

/// Largest magnitude of a weight in one byte.
const WEIGHT_STEPS: f32 = 127.0;

/// What a signed activation's byte is shifted by.
pub(super) const SIGNED_OFFSET: i32 = 128;

/// The scale of a row of finite weights: its largest magnitude is 127 of it; 0 for a row of zeros.
pub(super) fn row_scale(row: &[f32]) -> f32 {
    let largest = row.iter().fold(0.0f32, |m, w| m.max(w.abs()));
    scale(largest, WEIGHT_STEPS)
}

/// A weight in steps of its row's scale.
pub(super) fn quantised_weight(weight: f32, scale: f32) -> i8 {
    if scale > 0.0 {
        // `as` saturates; the scale is such that nothing is beyond ±127.
        (weight / scale).round() as i8
    } else {
        0
    }
}

/// `largest / steps`, so that `largest / scale` rounds to no more than `steps`, also where f32 runs
/// out of digits.
fn scale(largest: f32, steps: f32) -> f32 {
    let scale = largest / steps;
    if largest > 0.0 && (scale == 0.0 || (largest / scale).round() > steps) {
        scale.next_up()
    } else {
        scale
    }
}

/// How a vector of activations was turned to whole numbers of `P` bytes:
/// `x = scale · (steps − offset · 256^(P − 1))`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ByteScale {
    /// Value of a step.
    pub(super) scale: f32,
    /// The uppermost byte of 0; its others are 0.
    pub(super) offset: i32,
}

/// Turns activations, of which `largest` is the largest magnitude, to whole numbers of `P` bytes, 1 or 2.
#[inline(always)]
pub(super) fn quantise<const P: usize>(
    x: &[f32],
    largest: f32,
    is_signed: bool,
    steps: &mut [u16],
) -> ByteScale {
    let n_values = (1 << (8 * P)) as f32;
    let last = n_values - 1.0;
    let (offset, most) = if is_signed { (SIGNED_OFFSET, n_values / 2.0 - 1.0) } else { (0, last) };
    let scale = scale(largest, most);
    let shift = (offset << (8 * (P - 1))) as f32;
    if scale == 0.0 {
        steps.fill(shift as u16);
        return ByteScale { scale, offset };
    }
    let inverse = 1.0 / scale;
    let pairs = steps.iter_mut().zip(x);
    if inverse.is_finite() {
        pairs.for_each(|(steps, x)| *steps = nearest(x * inverse + shift, last));
    } else {
        pairs.for_each(|(steps, x)| *steps = nearest(x / scale + shift, last));
    }
    ByteScale { scale, offset }
}

/// The nearest whole number from 0 to `last`. Adding 2²³ leaves the rounded number in the low bits of
/// the mantissa, which a loop over many numbers does in vectors.
#[inline(always)]
fn nearest(value: f32, last: f32) -> u16 {
    const ROUND: f32 = 8_388_608.0;
    (value.clamp(0.0, last) + ROUND).to_bits() as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// `x` in steps of `P` bytes, and back in numbers.
    fn there_and_back<const P: usize>(x: &[f32]) -> (f64, Vec<f64>) {
        let largest = x.iter().fold(0.0f32, |m, x| m.max(x.abs()));
        let mut steps = vec![7; x.len()];
        let is_signed = x.iter().any(|x| *x < 0.0);
        let ByteScale { scale, offset } = quantise::<P>(x, largest, is_signed, &mut steps);
        let zero = offset << (8 * (P - 1));
        let value = |steps: &u16| f64::from(scale) * f64::from(i32::from(*steps) - zero);
        (f64::from(scale), steps.iter().map(value).collect())
    }

    proptest! {
        #[test]
        fn bytes_are_within_half_a_step(
            exponent in -150..127i32,
            shares in prop::collection::vec(-1.0..1.0f32, 1..40),
            signed in any::<bool>(),
        ) {
            let unit = 2f64.powi(exponent);
            let x: Vec<f32> = shares.iter().map(|s| {
                (f64::from(if signed { *s } else { s.abs() }) * unit) as f32
            }).collect();
            // f32 holds 2⁸ steps to 1/65,536 of one, 2¹⁶ steps to 1/256.
            let both = [(there_and_back::<1>(&x), 0.5001), (there_and_back::<2>(&x), 0.505)];
            for ((scale, back), most) in both {
                for (x, back) in x.iter().zip(back) {
                    let error = (back - f64::from(*x)).abs();
                    prop_assert!(error <= most * scale, "{x:e} {back:e} {scale:e}");
                }
            }
            let row = row_scale(&x);
            for x in &x {
                let error = (f64::from(row) * f64::from(quantised_weight(*x, row)) - f64::from(*x)).abs();
                prop_assert!(error <= 0.5001 * f64::from(row), "{x:e} {row:e}");
            }
        }
    }

    #[test]
    fn zeros_have_no_scale() {
        assert_eq!(row_scale(&[0.0, -0.0]), 0.0);
        assert_eq!(there_and_back::<1>(&[0.0; 2]), (0.0, vec![0.0; 2]));
        assert_eq!(there_and_back::<2>(&[0.0; 2]), (0.0, vec![0.0; 2]));
    }
}
