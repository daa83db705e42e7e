//! Times of the stages.

use std::time::Instant;

use super::info::StageTime;

/// Notes how long each stage took.
pub(super) struct Stopwatch {
    started: Instant,
    pub stages: Vec<StageTime>,
}

impl Stopwatch {
    pub fn new() -> Self {
        Self { started: Instant::now(), stages: Vec::new() }
    }

    /// The time since the last lap is that of `stage`.
    pub fn lap(&mut self, stage: &'static str) {
        let elapsed_s = self.started.elapsed().as_secs_f64();
        self.stages.push(StageTime { stage, elapsed_s });
        self.started = Instant::now();
    }
}
