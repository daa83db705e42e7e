//! Greedy choice by the mean log-det of the single-contact information.

use crate::error::InverseError;
use crate::placement::{Candidates, PlacementParams, no_place};

/// Gauges chosen one by one, each the candidate that adds most to the mean over the sites of
/// ln det (1 + D I D), I the information on one contact (position and force) there and D its prior:
/// the mean information gained, which is submodular, so that greedy reaches 63 % of the best
/// (Shamaiah, Banerjee and Vikalo 2010; Joshi and Boyd 2009 for the criterion). The mounted gauges
/// come first in the result.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or if the spacing leaves too few places.
pub fn place_greedy(
    candidates: &Candidates,
    params: &PlacementParams,
) -> Result<Vec<usize>, InverseError> {
    candidates.check(params)?;
    let mut chosen = params.mounted.clone();
    let mut inverses = vec![UNIT; candidates.n_sites()];
    for &c in &chosen {
        take(candidates, params, c, &mut inverses);
    }
    while chosen.len() < params.n_gauges {
        let best = (0..candidates.n())
            .filter(|&c| candidates.fits(c, &chosen, params))
            .map(|c| (c, gain(candidates, params, c, &inverses)))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let Some((c, _)) = best else {
            return Err(no_place(params.n_gauges, chosen.len()));
        };
        take(candidates, params, c, &mut inverses);
        chosen.push(c);
    }
    Ok(chosen)
}

/// A symmetric 3 × 3 matrix.
pub(crate) type Sym = [[f64; 3]; 3];

pub(crate) const UNIT: Sym = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn times(m: &Sym, j: &[f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * j[0] + row[1] * j[1] + row[2] * j[2])
}

/// Mean of ln (1 + jᵀ M⁻¹ j), the growth of ln det M by jjᵀ.
pub(crate) fn gain(
    candidates: &Candidates,
    params: &PlacementParams,
    c: usize,
    inverses: &[Sym],
) -> f64 {
    let mut sum = 0.0;
    for (site, inverse) in inverses.iter().enumerate() {
        let j = candidates.row(c, site, params);
        let v = times(inverse, &j);
        sum += (j[0] * v[0] + j[1] * v[1] + j[2] * v[2]).ln_1p();
    }
    sum / inverses.len() as f64
}

/// Adds a gauge: M⁻¹ less M⁻¹jjᵀM⁻¹ / (1 + jᵀM⁻¹j) (Sherman and Morrison).
pub(crate) fn take(
    candidates: &Candidates,
    params: &PlacementParams,
    c: usize,
    inverses: &mut [Sym],
) {
    for (site, inverse) in inverses.iter_mut().enumerate() {
        let j = candidates.row(c, site, params);
        let v = times(inverse, &j);
        let scale = 1.0 / (1.0 + j[0] * v[0] + j[1] * v[1] + j[2] * v[2]);
        for p in 0..3 {
            for q in 0..3 {
                inverse[p][q] -= scale * v[p] * v[q];
            }
        }
    }
}
