//! Layouts under which no place on the skin is blind.

use crate::error::{InverseError, check_positive};
use crate::estimator::needed_chi2;
use crate::placement::exchange::Tail;
use crate::placement::{Candidates, PlacementParams};

/// What a layout is to see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoverParams {
    /// Standard deviation of a reading's noise.
    pub noise_sd: f64,
    /// A force of this is to show wherever it presses, N.
    pub force_n: f64,
}

/// The smallest force that would be seen wherever it pressed, as of
/// [`crate::SeenForces::smallest_n`], and the site where no smaller one is.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or a gauge that is no candidate.
pub fn smallest_seen_n(
    candidates: &Candidates,
    chosen: &[usize],
    noise_sd: f64,
) -> Result<(f64, usize), InverseError> {
    candidates.check(&of_layout(chosen, noise_sd))?;
    check_positive("noise_sd", noise_sd)?;
    let sums = sums(candidates, chosen);
    let faintest = (0..sums.len()).min_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0);
    let answer_2 = sums[faintest] / noise_sd.powi(2);
    Ok(((needed_chi2(chosen.len()) / answer_2).sqrt(), faintest))
}

/// Gauges of `chosen`, none of them mounted, put elsewhere one at a time until the wanted force is seen
/// at every site, or no further move helps. Each time it is the move that lowers most what is missing, summed
/// over the sites; of those that leave nothing missing, the one under which two contacts are placed best.
///
/// What tells places apart is strain that varies, and near the mount there is hardly any of either: a
/// layout chosen by information alone leaves such places dark.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or a gauge that is no candidate.
pub fn cover(
    candidates: &Candidates,
    chosen: &[usize],
    params: &PlacementParams,
    wanted: &CoverParams,
) -> Result<Vec<usize>, InverseError> {
    candidates.check(&PlacementParams { mounted: chosen.to_vec(), ..params.clone() })?;
    check_positive("noise_sd", wanted.noise_sd)?;
    check_positive("force_n", wanted.force_n)?;
    let needed = needed_chi2(chosen.len()) * (wanted.noise_sd / wanted.force_n).powi(2);
    let tail = Tail::new(candidates, params);
    let mut layout = chosen.to_vec();
    let mut sums = sums(candidates, &layout);
    let mut missing = missing_of(&sums, needed);
    while missing > 0.0 {
        let moves = moves(candidates, &layout, params);
        let judged = moves.into_iter().map(|(place, c)| {
            let moved = moved(candidates, &sums, layout[place], c);
            (missing_of(&moved, needed), place, c)
        });
        let mut better: Vec<_> = judged.filter(|(left, ..)| *left < missing).collect();
        better.sort_by(|a, b| a.0.total_cmp(&b.0));
        let n_enough = better.iter().filter(|(left, ..)| *left == 0.0).count();
        better.truncate(n_enough.max(1));
        let after = |place: usize, c: usize| {
            let mut trial = layout.clone();
            trial[place] = c;
            trial
        };
        let best = better
            .into_iter()
            .map(|(left, place, c)| (tail.of(&after(place, c)), left, place, c))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, left, place, c)) = best else {
            break;
        };
        sums = moved(candidates, &sums, layout[place], c);
        (layout, missing) = (after(place, c), left);
    }
    Ok(layout)
}

/// Parameters that the check of a layout needs.
fn of_layout(chosen: &[usize], noise_sd: f64) -> PlacementParams {
    PlacementParams { mounted: chosen.to_vec(), ..PlacementParams::new(chosen.len(), noise_sd) }
}

/// All moves of a gauge that is not mounted to a candidate that fits.
fn moves(
    candidates: &Candidates,
    layout: &[usize],
    params: &PlacementParams,
) -> Vec<(usize, usize)> {
    let movable = (0..layout.len()).filter(|place| !params.mounted.contains(&layout[*place]));
    let of = |place: usize| {
        let mut others = layout.to_vec();
        others.remove(place);
        let free = (0..candidates.n()).filter(move |c| candidates.fits(*c, &others, params));
        free.map(move |c| (place, c))
    };
    movable.flat_map(of).collect()
}

/// Σ g² over a layout's gauges at each site `[n_sites]`.
fn sums(candidates: &Candidates, layout: &[usize]) -> Vec<f64> {
    let n_sites = candidates.n_sites();
    let mut sums = vec![0.0; n_sites];
    for &c in layout {
        for (sum, row) in sums.iter_mut().zip(&candidates.responses[c * n_sites..]) {
            *sum += row[0] * row[0];
        }
    }
    sums
}

/// The sums with gauge `from` at `to`.
fn moved(candidates: &Candidates, sums: &[f64], from: usize, to: usize) -> Vec<f64> {
    let n_sites = candidates.n_sites();
    let row = |c: usize| &candidates.responses[c * n_sites..(c + 1) * n_sites];
    let changes = row(from).iter().zip(row(to)).map(|(old, new)| new[0].powi(2) - old[0].powi(2));
    sums.iter().zip(changes).map(|(sum, change)| sum + change).collect()
}

/// The part of what is needed that is missing, summed over the sites.
fn missing_of(sums: &[f64], needed: f64) -> f64 {
    sums.iter().map(|sum| (1.0 - sum / needed).max(0.0)).sum()
}
