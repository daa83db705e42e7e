//! Times of the stages.

use crate::health::StageTimes;
use crate::histogram::Histogram;

/// A stage.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stage {
    Queue,
    Conditioning,
    Estimate,
    Sinks,
    Compute,
}

const N_STAGES: usize = 5;

/// Times of all stages, of this second and since the start.
pub(super) struct Stages {
    second: [Histogram; N_STAGES],
    total: [Histogram; N_STAGES],
}

impl Stages {
    pub(super) fn new() -> Self {
        let empty = || std::array::from_fn(|_| Histogram::new());
        Self { second: empty(), total: empty() }
    }

    pub(super) fn add(&mut self, stage: Stage, ns: u64) {
        self.second[stage as usize].add(ns);
    }

    /// Times of this second, which ends, and since the start.
    pub(super) fn end_second(&mut self) -> (StageTimes, StageTimes) {
        for (total, second) in self.total.iter_mut().zip(&self.second) {
            total.merge(second);
        }
        let times = (times(&self.second), times(&self.total));
        self.second.iter_mut().for_each(Histogram::clear);
        times
    }
}

fn times(of: &[Histogram; N_STAGES]) -> StageTimes {
    let latency = |stage: Stage| of[stage as usize].latency();
    StageTimes {
        queue: latency(Stage::Queue),
        conditioning: latency(Stage::Conditioning),
        estimate: latency(Stage::Estimate),
        sinks: latency(Stage::Sinks),
        compute: latency(Stage::Compute),
    }
}
