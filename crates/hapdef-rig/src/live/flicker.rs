//! 1/f noise of amplifiers: a sum of relaxations, as in W. H. Press, Comments Astrophys. 7(4), 1978.
//!
//! A relaxation of variance v and time τ has the one-sided spectrum 4 v τ / (1 + (2 π f τ)²). With the
//! same variance at times a factor q apart the sum is v / (ln q · f) between the first and the last
//! corner, but for a ripple below 1 % at q = 4: so v = h ln q for a density √(h/f). Sampled, with the last
//! corner at 0.26 of the rate, it is within 2 % of that up to a quarter of the rate.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Ratio of neighbouring corner frequencies.
const RATIO: f64 = 4.0;
/// The lowest corner is at most this, Hz; below it the spectrum is flat.
const LOWEST_HZ: f64 = 1e-3;
/// Highest corner, in sampling rates.
const HIGHEST: f64 = 0.26;

/// 1/f noise of several channels from 1 mHz up to a quarter of the sampling rate.
#[derive(Clone, Debug)]
pub(super) struct Flicker {
    /// Of each relaxation: what is left of it a sample later, and the standard deviation that comes
    /// in, µε.
    steps: Vec<(f64, f64)>,
    /// `[n_channels, n_relaxations]`, µε.
    states_ue: Vec<f64>,
    rng: ChaCha8Rng,
}

impl Flicker {
    /// `density_ue` is the density at 1 Hz, µε/√Hz. The noise begins in its steady state.
    pub(super) fn new(density_ue: f64, rate_hz: f64, n_channels: usize, rng: ChaCha8Rng) -> Self {
        let sd_ue = density_ue * RATIO.ln().sqrt();
        let n = if density_ue > 0.0 {
            (HIGHEST * rate_hz / LOWEST_HZ).log(RATIO).ceil().max(0.0) as i32 + 1
        } else {
            0
        };
        let step = |i: i32| {
            let corner = HIGHEST * RATIO.powi(-i);
            let left = (-std::f64::consts::TAU * corner).exp();
            (left, sd_ue * (1.0 - left * left).sqrt())
        };
        let mut rng = rng;
        let states = (0..n_channels * n as usize).map(|_| {
            let z: f64 = StandardNormal.sample(&mut rng);
            sd_ue * z
        });
        Self { states_ue: states.collect(), steps: (0..n).map(step).collect(), rng }
    }

    /// The next sample of a channel, µε.
    pub(super) fn next(&mut self, channel: usize) -> f64 {
        let n = self.steps.len();
        let states = &mut self.states_ue[channel * n..(channel + 1) * n];
        let mut sum_ue = 0.0;
        for (state, (left, sd_ue)) in states.iter_mut().zip(&self.steps) {
            let z: f64 = StandardNormal.sample(&mut self.rng);
            *state = *state * left + sd_ue * z;
            sum_ue += *state;
        }
        sum_ue
    }
}
