//! Greedy choice by the error of nearest neighbours, for comparison.

use crate::error::InverseError;
use crate::placement::{Candidates, PlacementParams, no_place};

/// Sites whose readings are nearest, that a place is estimated from.
const N_NEAREST: usize = 3;

/// Gauges chosen one by one, each the candidate that leaves the least mean error when every site is
/// estimated from the other sites with the nearest readings: the distance to the mean of their places (the
/// way of Sun and Martius, Optimal placement of strain gauges, with sites in place of samples). The
/// mounted ones come first.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or if the spacing leaves too few places.
pub fn place_nearest_neighbours(
    candidates: &Candidates,
    params: &PlacementParams,
) -> Result<Vec<usize>, InverseError> {
    candidates.check(params)?;
    let n_sites = candidates.n_sites();
    let mut chosen = Vec::new();
    let mut gaps = vec![0.0_f32; n_sites * n_sites];
    for &c in &params.mounted {
        add(candidates, c, &mut gaps);
        chosen.push(c);
    }
    while chosen.len() < params.n_gauges {
        let best = (0..candidates.n())
            .filter(|&c| candidates.fits(c, &chosen, params))
            .map(|c| (c, mean_error_m(candidates, c, &gaps)))
            .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let Some((c, _)) = best else {
            return Err(no_place(params.n_gauges, chosen.len()));
        };
        add(candidates, c, &mut gaps);
        chosen.push(c);
    }
    Ok(chosen)
}

fn readings(candidates: &Candidates, c: usize) -> Vec<f32> {
    let n_sites = candidates.n_sites();
    let of_candidate = &candidates.responses[c * n_sites..(c + 1) * n_sites];
    of_candidate.iter().map(|[g, _, _]| *g as f32).collect()
}

/// Adds a gauge to the squared distances of the sites' readings `[n_sites, n_sites]`.
fn add(candidates: &Candidates, c: usize, gaps: &mut [f32]) {
    let g = readings(candidates, c);
    for (row, own) in gaps.chunks_exact_mut(g.len()).zip(&g) {
        row.iter_mut().zip(&g).for_each(|(gap, other)| *gap += (own - other).powi(2));
    }
}

/// Mean error over the sites with candidate `c` besides what `gaps` gives.
fn mean_error_m(candidates: &Candidates, c: usize, gaps: &[f32]) -> f64 {
    let g = readings(candidates, c);
    let mut sum = 0.0;
    for (site, row) in gaps.chunks_exact(g.len()).enumerate() {
        let mut nearest = [(f32::INFINITY, site); N_NEAREST];
        for (other, gap) in row.iter().enumerate() {
            let gap = gap + (g[site] - g[other]).powi(2);
            if gap < nearest[N_NEAREST - 1].0 && other != site {
                nearest[N_NEAREST - 1] = (gap, other);
                let mut i = N_NEAREST - 1;
                while i > 0 && nearest[i].0 < nearest[i - 1].0 {
                    nearest.swap(i, i - 1);
                    i -= 1;
                }
            }
        }
        let places = nearest.iter().map(|(_, s)| candidates.sites_m[*s].coords);
        let mean = places.sum::<nalgebra::Vector3<f64>>() / N_NEAREST as f64;
        sum += (mean - candidates.sites_m[site].coords).norm();
    }
    sum / g.len() as f64
}
