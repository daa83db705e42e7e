//! The smallest force that would be seen wherever it pressed.

use crate::chi_square::tail_point;
use crate::estimator::ContactEstimator;

/// A frame of noise alone is taken for a contact so rarely: the usual `touch_p` of
/// [`crate::ConditionerParams`].
const SEEN_P: f64 = 1e-6;

/// How strongly the gauges answer to a newton at each site, in standard deviations of their noise.
#[derive(Clone, Debug)]
pub struct SeenForces {
    /// Squares of them `[n_sites, n_gauges]`, per N².
    answers_2: Vec<f64>,
    n_gauges: usize,
    /// Σ answers² A² that takes the mean χ² of a frame to what noise exceeds with [`SEEN_P`], by gauges.
    needed: Vec<f64>,
}

/// By how much a force must raise the mean χ² of `n_gauges` readings to be seen.
pub(crate) fn needed_chi2(n_gauges: usize) -> f64 {
    tail_point(SEEN_P, n_gauges) - n_gauges as f64
}

impl SeenForces {
    /// On the sites and the noise of `estimator`, for all gauges.
    #[must_use]
    pub fn new(estimator: &ContactEstimator) -> Self {
        let (map, sites, sd) = (estimator.map(), &estimator.model.sites, estimator.gauge_sd());
        let answers = sites.points().iter().flat_map(|point| {
            map.normal(point).into_iter().zip(sd).map(|(unit, sd)| (unit / sd).powi(2))
        });
        Self {
            answers_2: answers.collect(),
            n_gauges: map.n_gauges(),
            needed: (0..=map.n_gauges()).map(needed_chi2).collect(),
        }
    }

    /// The smallest force, N, that shows in a single frame wherever on the skin it presses, by the gauges
    /// of `live` `[n_gauges]`, by all if `None`: there the mean of χ², n + Σ (g A/σ)², is what noise
    /// exceeds once in a million frames. Infinite with fewer than three gauges, which no contact is
    /// found by.
    #[must_use]
    pub fn smallest_n(&self, live: Option<&[bool]>) -> f64 {
        let counts = |gauge: usize| live.is_none_or(|live| live.get(gauge) == Some(&true));
        let n_live = (0..self.n_gauges).filter(|&gauge| counts(gauge)).count();
        if n_live < 3 {
            return f64::INFINITY;
        }
        let answer_2 = |of: &[f64]| -> f64 {
            of.iter().enumerate().filter(|(g, _)| counts(*g)).map(|(_, square)| square).sum()
        };
        let faintest = self.answers_2.chunks_exact(self.n_gauges).map(answer_2);
        (self.needed[n_live] / faintest.fold(f64::INFINITY, f64::min)).sqrt()
    }
}
