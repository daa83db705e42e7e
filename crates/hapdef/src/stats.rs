//! Position and force errors of many contacts in a few numbers.

use hapdef_bench::stats::{quantile, sorted};
use serde::{Deserialize, Serialize};

use crate::scoring::ContactPair;

/// A position error beyond this counts as a miss, m.
pub const FAR_M: f64 = 0.010;

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

/// Errors of contacts in a range of their force, where they were found.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct ForceBin {
    /// Middle of the range, N.
    pub force_n: f64,
    /// Mean position error, mm.
    pub position_mm: f64,
    /// Mean absolute force error, N.
    pub force_error_n: f64,
    /// Presses in which it was found.
    pub n: usize,
    /// Presses in which it was not.
    pub n_missed: usize,
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

/// Errors by force, in bins of equal width up to `strongest_n` in which any contact was found: true forces, N,
/// and what was found of each, if anything was.
#[must_use]
pub fn by_force(all: &[(f64, Option<ContactPair>)], strongest_n: f64) -> Vec<ForceBin> {
    const N_BINS: usize = 8;
    let width = strongest_n / N_BINS as f64;
    let bin_of = |force_n: f64| ((force_n / width) as usize).min(N_BINS - 1);
    let bin = |i: usize| {
        let inside = || all.iter().filter(move |(force_n, _)| bin_of(*force_n) == i);
        let found: Vec<&ContactPair> = inside().filter_map(|(_, pair)| pair.as_ref()).collect();
        let mean = |value: &dyn Fn(&ContactPair) -> f64| {
            found.iter().map(|pair| value(pair)).sum::<f64>() / found.len() as f64
        };
        (!found.is_empty()).then(|| ForceBin {
            force_n: (i as f64 + 0.5) * width,
            position_mm: mean(&|pair| pair.position_error_m * 1e3),
            force_error_n: mean(&|pair| pair.force_error_n.abs()),
            n: found.len(),
            n_missed: inside().count() - found.len(),
        })
    };
    (0..N_BINS).filter_map(bin).collect()
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

    #[test]
    fn every_press_falls_into_one_bin_found_or_missed() {
        let pair = |position_error_m| ContactPair {
            detected: 0,
            truth: 1,
            position_error_m,
            force_error_n: -2.0,
        };
        let varied = [
            (0.0, Some(pair(0.004))),
            (1.0, Some(pair(0.002))),
            (2.0, None),
            (34.0, Some(pair(0.001))),
        ];
        let bins = by_force(&varied, 34.0);
        assert_eq!(bins.len(), 2);
        assert_eq!((bins[0].n, bins[0].n_missed, bins[1].n), (2, 1, 1));
        assert!((bins[0].position_mm - 3.0).abs() < 1e-12);
        assert!((bins[1].force_error_n - 2.0).abs() < 1e-12);
    }
}
