//! How far answers are from those of a better model.

use hapdef_bench::stats::median;
use serde::Serialize;

/// Relative difference up to which a shell is good enough, and a solid fine enough.
pub const GOOD_DIFFERENCE: f64 = 0.1;

/// Relative differences from a solid's answers; those of one place or press are
/// ‖a − solid‖ / ‖solid‖, over the gauges or of the one displacement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Differences {
    /// The median.
    pub median: f64,
    /// The largest.
    pub worst: f64,
    /// The norm of all differences over the norm of all the solid's answers.
    pub overall: f64,
    /// The median of ‖a‖ / ‖solid‖.
    pub median_ratio: f64,
}

impl Differences {
    /// Of answers `[n][m]` from the solid's.
    pub(crate) fn of(answers: &[Vec<f64>], solid: &[Vec<f64>]) -> Self {
        let pairs = || answers.iter().zip(solid);
        let ratio = |(a, b): (&Vec<f64>, &Vec<f64>)| norm(a) / norm(b).max(f64::MIN_POSITIVE);
        Self {
            median: median(pairs().map(|(a, b)| relative(a, b))),
            worst: largest(pairs().map(|(a, b)| relative(a, b))),
            overall: relative(&answers.concat(), &solid.concat()),
            median_ratio: median(pairs().map(ratio)),
        }
    }
}

/// ‖a − solid‖ / ‖solid‖; 0 where both are 0.
pub(crate) fn relative(a: &[f64], solid: &[f64]) -> f64 {
    match (distance(a, solid), norm(solid)) {
        (0.0, _) => 0.0,
        (distance, whole) => distance / whole.max(f64::MIN_POSITIVE),
    }
}

/// ‖a − b‖.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

pub(crate) fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_relative_to_the_solid() {
        let shell = [vec![3.0, 4.0], vec![2.0, 0.0], vec![0.0, 0.0]];
        let solid = [vec![0.0, 4.0], vec![1.0, 0.0], vec![0.0, 0.0]];
        let found = Differences::of(&shell, &solid);
        assert_eq!((found.median, found.worst), (0.75, 1.0));
        assert!((found.overall - (10.0_f64 / 17.0).sqrt()).abs() < 1e-15);
    }
}
