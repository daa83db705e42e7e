//! Position and force errors of many contacts in a few numbers.

use hapdef_bench::stats::{quantile, sorted};
use serde::{Deserialize, Serialize};

use crate::scoring::ContactPair;

/// A position error beyond this counts as a miss, m.
const FAR_M: f64 = 0.010;

/// Errors of the contacts that were found. Contacts that were not found have no error: `n_expected`
/// tells how many there were. All errors are zero when `n` is 0.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct ContactStats {
    /// Contacts found and measured.
    pub n: usize,
    /// Contacts that were to be found.
    pub n_expected: usize,
    /// Mean distance to the true contact, mm.
    pub mean_mm: f64,
    /// Median distance, mm.
    pub median_mm: f64,
    /// 90th percentile of the distance, mm.
    pub p90_mm: f64,
    /// Share of contacts farther than 10 mm.
    pub share_beyond_10mm: f64,
    /// Mean absolute force error, N.
    pub mean_n: f64,
}

impl ContactStats {
    /// Sums up measured contacts of `n_expected`.
    #[must_use]
    pub fn of(pairs: &[ContactPair], n_expected: usize) -> Self {
        let n = pairs.len();
        if n == 0 {
            return Self { n_expected, ..Self::default() };
        }
        let distances = sorted(pairs.iter().map(|p| p.position_error_m));
        let far = distances.iter().filter(|d| **d > FAR_M).count();
        Self {
            n,
            n_expected,
            mean_mm: distances.iter().sum::<f64>() / n as f64 * 1e3,
            median_mm: quantile(&distances, 0.5) * 1e3,
            p90_mm: quantile(&distances, 0.9) * 1e3,
            share_beyond_10mm: far as f64 / n as f64,
            mean_n: pairs.iter().map(|p| p.force_error_n.abs()).sum::<f64>() / n as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eleven_contacts_one_to_eleven_millimetres_off() {
        let pair = |i: u32| ContactPair {
            detected: 0,
            truth: 0,
            position_error_m: f64::from(i) * 1e-3,
            force_error_n: if i.is_multiple_of(2) { 1.0 } else { -2.0 },
        };
        let stats = ContactStats::of(&(1..=11).map(pair).collect::<Vec<_>>(), 12);
        assert!((stats.mean_mm - 6.0).abs() < 1e-12 && (stats.median_mm - 6.0).abs() < 1e-12);
        assert!((stats.p90_mm - 10.0).abs() < 1e-12, "{}", stats.p90_mm);
        assert!((stats.share_beyond_10mm - 1.0 / 11.0).abs() < 1e-12);
        assert!((stats.mean_n - 17.0 / 11.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_found_is_counted_as_nothing() {
        let stats = ContactStats::of(&[], 3);
        assert_eq!((stats.n, stats.n_expected), (0, 3));
    }
}
