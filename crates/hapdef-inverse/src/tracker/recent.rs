//! The last frames, for a full search.

use crate::estimator::Model;
use crate::tracker::gathered::Gathered;

/// Frames averaged for a full search: a quarter of one frame's noise, and none older than twice as many.
const N_RECENT: usize = 16;

/// The last frames, for a full search.
#[derive(Clone, Debug)]
pub(super) struct Recent {
    sum: Vec<f64>,
    pub(super) mean: Vec<f64>,
    pub(super) live: Vec<bool>,
    n: usize,
    gathering: Gathered,
    /// Those of `mean`.
    pub(super) gathered: Gathered,
    /// Frames, of late, that nothing explains.
    pub(super) n_bad: usize,
    /// Frames since a search was handed out.
    pub(super) asked: Option<usize>,
}

impl Recent {
    pub(super) fn new(n_gauges: usize, width: usize) -> Self {
        Self {
            sum: vec![0.0; n_gauges],
            mean: vec![0.0; n_gauges],
            live: vec![false; n_gauges],
            n: 0,
            gathering: Gathered::new(width),
            gathered: Gathered::new(width),
            n_bad: 0,
            asked: None,
        }
    }

    pub(super) fn add(&mut self, model: &Model, readings: &[f64], z: &[f64], live: &[bool]) {
        for (g, &gauge) in model.live.iter().enumerate() {
            self.live[gauge] = live[g];
            self.sum[gauge] += if live[g] { readings[gauge] } else { 0.0 };
        }
        self.gathering.add(z, 1.0);
        self.n += 1;
        if self.n == N_RECENT {
            for (mean, sum) in self.mean.iter_mut().zip(&self.sum) {
                *mean = sum / N_RECENT as f64;
            }
            self.gathered.copy_from(&self.gathering);
            self.clear();
        }
        self.asked = self.asked.map(|n| n + 1);
    }

    fn clear(&mut self) {
        self.sum.fill(0.0);
        self.gathering.clear();
        self.n = 0;
    }

    /// Forgets all frames; the gauges that are read have changed.
    pub(super) fn start_over(&mut self) {
        self.clear();
        self.gathered.clear();
    }

    pub(super) fn judge(&mut self, is_alarm: bool) {
        self.n_bad = if is_alarm { self.n_bad + 1 } else { self.n_bad.saturating_sub(1) };
    }

    pub(super) fn forgive(&mut self) {
        self.n_bad = 0;
        self.asked = None;
    }
}
