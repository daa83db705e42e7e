//! Greedy choice by the mean log-det of the single-contact information.

use crate::error::InverseError;
use crate::placement::information::Information;
use crate::placement::{Candidates, PlacementParams, no_place};

/// Gauges chosen one by one, each the candidate that adds most to the mean over the sites of
/// ln det (1 + D I D), I the information on one contact (position and force) there and D its prior:
/// the mean information gained, which is submodular, so that greedy reaches 63 % of the best
/// (Shamaiah, Banerjee and Vikalo 2010; Joshi and Boyd 2009 for the criterion). Beside loads that are no contacts it is
/// the information that is left when these are unknown, too, of which nothing is proven. The mounted gauges come first
/// in the result.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or if the spacing leaves too few places.
pub fn place_greedy(
    candidates: &Candidates,
    params: &PlacementParams,
) -> Result<Vec<usize>, InverseError> {
    candidates.check(params)?;
    let mut chosen = params.mounted.clone();
    let mut information = Information::of(candidates, params, &chosen);
    while chosen.len() < params.n_gauges {
        let best = (0..candidates.n())
            .filter(|&c| candidates.fits(c, &chosen, params))
            .map(|c| (c, information.gain(c)))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let Some((c, _)) = best else {
            return Err(no_place(params.n_gauges, chosen.len()));
        };
        information.take(c);
        chosen.push(c);
    }
    Ok(chosen)
}
