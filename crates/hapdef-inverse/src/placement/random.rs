//! Random layouts, and the draws behind them.

use crate::error::InverseError;
use crate::placement::{Candidates, PlacementParams, no_place};

/// Gauges at random candidates that fit, the mounted ones first.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or if the spacing leaves too few places.
pub fn place_random(
    candidates: &Candidates,
    params: &PlacementParams,
) -> Result<Vec<usize>, InverseError> {
    candidates.check(params)?;
    let mut draws = Draws::new(params.seed);
    let mut chosen = params.mounted.clone();
    while chosen.len() < params.n_gauges {
        let free: Vec<usize> =
            (0..candidates.n()).filter(|&c| candidates.fits(c, &chosen, params)).collect();
        if free.is_empty() {
            return Err(no_place(params.n_gauges, chosen.len()));
        }
        chosen.push(free[draws.below(free.len())]);
    }
    Ok(chosen)
}

/// SplitMix64 (Steele, Lea and Flood 2014): enough for drawing places.
pub(crate) struct Draws(u64);

impl Draws {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number below `n`, which is not 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    }
}
