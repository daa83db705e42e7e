//! The smallest force that would be seen wherever it pressed.

use crate::chi_square::tail_point;
use crate::dense::{cholesky, solve_lower};
use crate::estimator::ContactEstimator;
use crate::noise::NoiseParams;

/// A frame of noise alone is taken for a contact so rarely: the usual `touch_p` of
/// [`crate::ConditionerParams`].
const SEEN_P: f64 = 1e-6;

/// How the gauges answer to a newton at each site, beside noise and loads that are no contacts.
#[derive(Clone, Debug)]
pub struct SeenForces {
    /// `[n_sites, n_gauges]`, per N.
    answers: Vec<f64>,
    noise: NoiseParams,
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
        let (map, sites) = (estimator.map(), &estimator.model.sites);
        Self {
            answers: sites.points().iter().flat_map(|point| map.normal(point)).collect(),
            noise: estimator.noise.clone(),
            needed: (0..=map.n_gauges()).map(needed_chi2).collect(),
        }
    }

    /// The smallest force, N, that shows in a single frame wherever on the skin it presses, by the gauges
    /// of `live` `[n_gauges]`, by all if `None`: there the mean of χ², n + A² gᵀ R⁻¹ g, is what noise
    /// exceeds once in a million frames. Infinite with fewer than three gauges, which no contact is
    /// found by.
    #[must_use]
    pub fn smallest_n(&self, live: Option<&[bool]>) -> f64 {
        let n_gauges = self.noise.gauge_sd.len();
        let counts = |gauge: usize| live.is_none_or(|live| live.get(gauge) == Some(&true));
        let live: Vec<usize> = (0..n_gauges).filter(|&gauge| counts(gauge)).collect();
        let n_live = live.len();
        let mut l = self.noise.covariance(&live);
        if n_live < 3 || !cholesky(&mut l, n_live, 0.0) {
            return f64::INFINITY;
        }
        let mut row = vec![0.0; n_live];
        let mut answer_2 = |of: &[f64]| -> f64 {
            row.iter_mut().zip(&live).for_each(|(r, &gauge)| *r = of[gauge]);
            solve_lower(&l, n_live, &mut row);
            row.iter().map(|r| r * r).sum()
        };
        let mut faintest = f64::INFINITY;
        for of in self.answers.chunks_exact(n_gauges) {
            faintest = faintest.min(answer_2(of));
        }
        (self.needed[n_live] / faintest).sqrt()
    }
}
