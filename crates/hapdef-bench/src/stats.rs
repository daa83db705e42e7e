//! Means, medians and quantiles.

/// The mean; 0 of no values.
#[must_use]
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, n) = values.into_iter().fold((0.0, 0.0), |(sum, n), v| (sum + v, n + 1.0));
    sum / f64::max(n, 1.0)
}

/// The mean and the standard deviation of these values, not of what they were drawn from; NaN of no
/// values.
#[must_use]
pub fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

/// The values in rising order.
#[must_use]
pub fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// The middle value, the upper one of two; NaN of no values.
#[must_use]
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    quantile(&sorted(values), 0.5)
}

/// The value at share `q` of rising values, the nearest one; NaN of no values.
#[must_use]
pub fn quantile(rising: &[f64], q: f64) -> f64 {
    let last = rising.len().saturating_sub(1) as f64;
    rising.get((last * q).round() as usize).copied().unwrap_or(f64::NAN)
}

/// The least of rising values that a share `q` of all of them comes before; NaN of no values. In few
/// values it lies farther out than [`quantile`].
#[must_use]
pub fn upper_quantile(rising: &[f64], q: f64) -> f64 {
    let place = (q * rising.len() as f64) as usize;
    rising.get(place).or(rising.last()).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_were_measured() {
        let rising = sorted((0..200).rev().map(f64::from));
        assert_eq!([0.0, 0.5, 0.99, 1.0].map(|q| quantile(&rising, q)), [0.0, 100.0, 197.0, 199.0]);
        assert_eq!([0.5, 0.99, 1.0].map(|q| upper_quantile(&rising, q)), [100.0, 198.0, 199.0]);
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median([4.0, 3.0, 1.0, 2.0]), 3.0);
    }

    #[test]
    fn no_values_have_no_quantile() {
        assert!(quantile(&[], 0.5).is_nan() && upper_quantile(&[], 0.5).is_nan());
        assert!(median([]).is_nan());
        assert_eq!(mean([]), 0.0);
    }

    #[test]
    fn deviations_are_those_of_the_values_themselves() {
        assert_eq!(mean_and_sd(&[1.0, 3.0]), (2.0, 1.0));
    }
}
