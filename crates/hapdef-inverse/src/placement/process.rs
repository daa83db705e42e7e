//! Choices that look at the wall only, by a Gaussian process on it, for comparison.

use nalgebra::Point3;

use crate::dense::{cholesky, inverse, solve_lower};
use crate::error::InverseError;
use crate::placement::{Candidates, PlacementParams, no_place};

/// Correlation length of what gauges read, m, and the noise's part of the variance, without which places
/// nearer than a fraction of the length make the covariance singular.
const LENGTH_M: f64 = 0.03;
const NUGGET: f64 = 1e-3;

/// Gauges at the places of greatest entropy given those before: each the one whose reading is least
/// predicted by the chosen ones (Shewry and Wynn 1987). The covariance of two places on the wall is
/// Matérn's with smoothness 5/2 of their distance in space, which is positive definite on any
/// surface, as one of geodesic distances is not. Of a place with several axes the first is taken;
/// the mounted gauges come first.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or if the spacing leaves too few places.
pub fn place_entropy(
    candidates: &Candidates,
    params: &PlacementParams,
) -> Result<Vec<usize>, InverseError> {
    choose(candidates, params, variances)
}

/// Gauges at the places that say most about all the others (mutual information; Krause, Singh and
/// Guestrin, Journal of Machine Learning Research 9, 2008, algorithm 1): each the one of greatest
/// variance given the chosen ones over that given all the rest. Covariance as for
/// [`place_entropy`].
///
/// # Errors
/// As [`place_entropy`].
pub fn place_mutual_information(
    candidates: &Candidates,
    params: &PlacementParams,
) -> Result<Vec<usize>, InverseError> {
    choose(candidates, params, |places, chosen| {
        let mut worth = variances(places, chosen)?;
        for (place, precision) in precisions(places, chosen)? {
            worth[place] *= precision;
        }
        Ok(worth)
    })
}

/// Greedy over the places of candidates that are allowed, by `worth`(places, chosen places)
/// `[n_places]`.
fn choose(
    candidates: &Candidates,
    params: &PlacementParams,
    worth: impl Fn(&[Point3<f64>], &[usize]) -> Result<Vec<f64>, InverseError>,
) -> Result<Vec<usize>, InverseError> {
    candidates.check(params)?;
    // the first candidate of each place, mounted ones for theirs
    let mut firsts = params.mounted.clone();
    for c in (0..candidates.n()).filter(|&c| candidates.allowed[c]) {
        let x = candidates.positions_m[c];
        let is_known = |o: &usize| candidates.positions_m[*o] == x;
        if !firsts.iter().any(is_known) {
            firsts.push(c);
        }
    }
    let places: Vec<Point3<f64>> = firsts.iter().map(|&c| candidates.positions_m[c]).collect();
    let mut chosen: Vec<usize> = (0..params.mounted.len()).collect();
    while chosen.len() < params.n_gauges {
        let taken: Vec<usize> = chosen.iter().map(|&p| firsts[p]).collect();
        let worth = worth(&places, &chosen)?;
        let best = (0..places.len())
            .filter(|&p| candidates.fits(firsts[p], &taken, params))
            .max_by(|&a, &b| worth[a].total_cmp(&worth[b]).then(b.cmp(&a)));
        let Some(place) = best else {
            return Err(no_place(params.n_gauges, chosen.len()));
        };
        chosen.push(place);
    }
    Ok(chosen.into_iter().map(|p| firsts[p]).collect())
}

fn covariance(a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    let r = 5.0_f64.sqrt() * (a - b).norm() / LENGTH_M;
    (1.0 + r + r * r / 3.0) * (-r).exp()
}

/// Covariance of readings at places of indices `of`, factored `[n, n]`.
fn factored(places: &[Point3<f64>], of: &[usize]) -> Result<Vec<f64>, InverseError> {
    let n = of.len();
    let mut l = vec![0.0; n * n];
    for (i, &p) in of.iter().enumerate() {
        for (j, &q) in of[..=i].iter().enumerate() {
            l[i * n + j] = covariance(&places[p], &places[q]);
        }
        l[i * n + i] += NUGGET;
    }
    if cholesky(&mut l, n, 0.0) {
        return Ok(l);
    }
    let what = "the covariance of readings on the wall";
    Err(InverseError::NotPositiveDefinite { what })
}

/// Variances of readings at all places given those at the places `known` `[n_places]`.
fn variances(places: &[Point3<f64>], known: &[usize]) -> Result<Vec<f64>, InverseError> {
    let l = factored(places, known)?;
    let at = |x: &Point3<f64>| {
        let mut k: Vec<f64> = known.iter().map(|&p| covariance(&places[p], x)).collect();
        solve_lower(&l, known.len(), &mut k);
        1.0 + NUGGET - k.iter().map(|v| v * v).sum::<f64>()
    };
    Ok(places.iter().map(at).collect())
}

/// One over the variance of a reading at each place that is not chosen given all others that are
/// not, with the place.
fn precisions(places: &[Point3<f64>], chosen: &[usize]) -> Result<Vec<(usize, f64)>, InverseError> {
    let is_free = |p: &usize| !chosen.contains(p);
    let free: Vec<usize> = (0..places.len()).filter(is_free).collect();
    let n = free.len();
    let mut precision = vec![0.0; n * n];
    inverse(&factored(places, &free)?, n, &mut precision);
    let each = free.into_iter().enumerate();
    Ok(each.map(|(i, p)| (p, precision[i * n + i])).collect())
}
