//! Times of short pieces of work, in rounds.

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use hapdef_bench::stats::{sorted, upper_quantile};
use serde::Serialize;

/// Runs before the clock starts, in every round: caches fill as they would at run time.
const WARM_UP: usize = 4;

/// Runs that are timed in every round.
const TIMED: usize = 25;

/// Times of one piece of work, µs.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    micros: Vec<f64>,
}

/// Half the times, and 99 of 100, are not above these, µs.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Quantiles {
    pub(super) p50_us: f64,
    pub(super) p99_us: f64,
}

impl Times {
    /// Runs `work` for one round.
    pub(super) fn round(&mut self, mut work: impl FnMut() -> Result<()>) -> Result<()> {
        for _ in 0..WARM_UP {
            work()?;
        }
        for _ in 0..TIMED {
            let start = Instant::now();
            work()?;
            self.micros.push(start.elapsed().as_secs_f64() * 1e6);
        }
        Ok(())
    }

    /// Adds times that another program took.
    pub(super) fn extend(&mut self, micros: &[f64]) {
        self.micros.extend_from_slice(micros);
    }

    /// Of all rounds.
    pub(super) fn quantiles(&self) -> Quantiles {
        let rising = sorted(self.micros.iter().copied());
        Quantiles { p50_us: upper_quantile(&rising, 0.5), p99_us: upper_quantile(&rising, 0.99) }
    }
}

/// Bytes that are read from end to end: nothing that uses them all can be faster.
pub(super) struct Stream {
    words: Vec<u64>,
    pub(super) times: Times,
}

impl Stream {
    /// `n_bytes` of memory of its own.
    pub(super) fn new(n_bytes: usize) -> Self {
        Self { words: (0..n_bytes as u64 / 8).collect(), times: Times::default() }
    }

    /// Reads them for one round.
    pub(super) fn round(&mut self) -> Result<()> {
        let words = &self.words;
        self.times.round(|| {
            let mut sums = [0u64; 16];
            for words in words.as_chunks::<16>().0 {
                for (sum, word) in sums.iter_mut().zip(words) {
                    *sum = sum.wrapping_add(*word);
                }
            }
            black_box(sums);
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_sorted_times() {
        let mut times = Times::default();
        times.extend(&(0..200).rev().map(f64::from).collect::<Vec<_>>());
        let Quantiles { p50_us, p99_us } = times.quantiles();
        assert_eq!([p50_us, p99_us], [100.0, 198.0]);
        assert!(Times::default().quantiles().p50_us.is_nan());
    }
}
