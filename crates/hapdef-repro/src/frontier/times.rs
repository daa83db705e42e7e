//! Times of a configuration's frames, in rounds, each beside the usual configuration's.

use anyhow::Result;
use hapdef_bench::stats::{quantile, sorted};
use hapdef_inverse::ContactEstimate;
use serde::{Deserialize, Serialize};

use super::lab::Ready;
use crate::compare::cells::estimate_us;
use crate::compare::world::Frame;

/// Frames of a round in which the usual configuration is timed, too.
const N_BESIDE: usize = 40;

/// Times of a frame of two contacts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct FrameTimes {
    /// Frames of two contacts that were timed, all rounds together.
    pub(super) n: usize,
    /// Median of the rounds' medians, µs.
    pub(super) p50_us: f64,
    /// Largest minus smallest of the rounds' medians, over [`Self::p50_us`].
    pub(super) p50_spread: f64,
    /// 99 % quantile of all rounds' frames together, µs.
    pub(super) p99_us: f64,
    /// Largest minus smallest of the rounds' 99 % quantiles, over [`Self::p99_us`].
    pub(super) p99_spread: f64,
    /// The slowest frame, µs; of scripts that are followed that of any frame, before the second contact
    /// has come, too.
    pub(super) slowest_us: f64,
    /// The usual configuration's median in the same rounds, µs.
    pub(super) usual_us: f64,
}

/// Times as they are measured.
#[derive(Clone, Debug, Default)]
pub(super) struct Rounds {
    own: Vec<Vec<f64>>,
    usual: Vec<Vec<f64>>,
    slowest_us: f64,
}

impl Rounds {
    /// Times the usual configuration on the first of a round's frames, before the configuration itself.
    pub(super) fn beside(&mut self, usual: &Ready, frames: &[Frame]) -> Result<()> {
        let frames = &frames[..N_BESIDE.min(frames.len())];
        self.usual.push(search_times_us(usual, frames)?);
        Ok(())
    }

    /// Adds a round's times of frames of two contacts, µs.
    pub(super) fn add(&mut self, times_us: Vec<f64>) {
        self.slowest(&times_us);
        self.own.push(times_us);
    }

    /// Minds the slowest of frames that are no frames of two contacts, µs.
    pub(super) fn slowest(&mut self, times_us: &[f64]) {
        self.slowest_us = times_us.iter().copied().fold(self.slowest_us, f64::max);
    }

    pub(super) fn times(&self) -> FrameTimes {
        let all = sorted(self.own.iter().flatten().copied());
        let (medians, tails) = (quantiles(&self.own, 0.5), quantiles(&self.own, 0.99));
        let (p50_us, p99_us) = (quantile(&medians, 0.5), quantile(&all, 0.99));
        FrameTimes {
            n: all.len(),
            p50_us,
            p50_spread: range(&medians) / p50_us,
            p99_us,
            p99_spread: range(&tails) / p99_us,
            slowest_us: self.slowest_us,
            usual_us: quantile(&quantiles(&self.usual, 0.5), 0.5),
        }
    }
}

impl FrameTimes {
    /// The times as they would be where the usual configuration takes `usual_us`.
    pub(super) fn beside(&self, usual_us: f64) -> Self {
        let scale = usual_us / self.usual_us;
        Self {
            p50_us: self.p50_us * scale,
            p99_us: self.p99_us * scale,
            slowest_us: self.slowest_us * scale,
            usual_us,
            ..self.clone()
        }
    }
}

/// Times of frames of which nothing is known before, µs.
pub(super) fn search_times_us(ready: &Ready, frames: &[Frame]) -> Result<Vec<f64>> {
    let mut scratch = ready.estimator.scratch();
    let mut estimate = ContactEstimate::default();
    let mut times_us = Vec::with_capacity(frames.len());
    for frame in frames {
        let readings = &frame.readings_ue[ready.channels.clone()];
        times_us.push(estimate_us(&ready.estimator, readings, &mut scratch, &mut estimate)?);
    }
    Ok(times_us)
}

/// The same quantile of every round, rising.
fn quantiles(rounds: &[Vec<f64>], q: f64) -> Vec<f64> {
    sorted(rounds.iter().map(|round| quantile(&sorted(round.iter().copied()), q)))
}

/// Last minus first of rising values.
fn range(rising: &[f64]) -> f64 {
    rising.last().copied().unwrap_or(0.0) - rising.first().copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_and_their_spread_are_those_of_the_rounds() {
        let mut rounds = Rounds::default();
        for (round, usual_us) in [(0, 100.0), (10, 110.0), (20, 90.0)] {
            rounds.usual.push(vec![usual_us; 3]);
            rounds.add((1..=200).map(|i| f64::from(i + round)).collect());
        }
        rounds.slowest(&[5.0, 900.0]);
        let times = rounds.times();
        let medians = [101.0, 111.0, 121.0];
        assert_eq!((times.n, times.p50_us, times.usual_us), (600, 111.0, 100.0));
        assert_eq!(times.p50_spread, (medians[2] - medians[0]) / medians[1]);
        assert_eq!(times.p99_spread, 20.0 / times.p99_us);
        assert!(times.p99_us > 200.0 && times.p99_us < 220.0, "{times:?}");
        assert_eq!(times.slowest_us, 900.0);
        assert_eq!(times.beside(200.0).slowest_us, 1800.0);
    }
}
