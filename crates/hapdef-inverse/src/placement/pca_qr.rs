//! Pivoted QR on the main modes of the response, for comparison.

use crate::error::InverseError;
use crate::placement::random::Draws;
use crate::placement::{Candidates, PlacementParams, no_place};

/// Rounds of subspace iteration: the modes only have to span the main subspace.
const N_ROUNDS: usize = 30;

/// Gauges by QR with column pivoting on the first `n_gauges` principal modes of the response, rows
/// candidates and columns sites (Manohar, Brunton, Kutz and Brunton, Data-driven sparse sensor
/// placement, IEEE Control Systems 38, 2018): each is the candidate with the largest part outside
/// the span of those before. The mounted ones come first.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or if the spacing leaves too few places.
pub fn place_pca_qr(
    candidates: &Candidates,
    params: &PlacementParams,
) -> Result<Vec<usize>, InverseError> {
    candidates.check(params)?;
    let n_modes = params.n_gauges.min(candidates.n()).min(candidates.n_sites());
    let mut modes = principal_modes(candidates, n_modes);
    let mut chosen = Vec::new();
    for &c in &params.mounted {
        deflate(&mut modes, c);
        chosen.push(c);
    }
    while chosen.len() < params.n_gauges {
        let size = |c: &usize| -> f64 { modes[*c].iter().map(|v| v * v).sum() };
        let best = (0..candidates.n())
            .filter(|&c| candidates.fits(c, &chosen, params))
            .max_by(|a, b| size(a).total_cmp(&size(b)).then(b.cmp(a)));
        let Some(c) = best else {
            return Err(no_place(params.n_gauges, chosen.len()));
        };
        deflate(&mut modes, c);
        chosen.push(c);
    }
    Ok(chosen)
}

/// Takes the direction of row `c` out of all rows.
fn deflate(modes: &mut [Vec<f64>], c: usize) {
    let row = modes[c].clone();
    let square: f64 = row.iter().map(|v| v * v).sum();
    if square <= 0.0 {
        return;
    }
    for other in modes.iter_mut() {
        let share = other.iter().zip(&row).map(|(a, b)| a * b).sum::<f64>() / square;
        for (a, b) in other.iter_mut().zip(&row) {
            *a -= share * b;
        }
    }
}

/// `[n_candidates][n_modes]`: coordinates of the candidates in the main left singular vectors of the
/// response, by subspace iteration with G Gᵀ.
fn principal_modes(candidates: &Candidates, n_modes: usize) -> Vec<Vec<f64>> {
    let (n, n_sites) = (candidates.n(), candidates.n_sites());
    let g = |c: usize, site: usize| candidates.responses[c * n_sites + site][0];
    let mut draws = Draws::new(1);
    let mut basis: Vec<Vec<f64>> =
        (0..n_modes).map(|_| (0..n).map(|_| draws.below(2000) as f64 - 999.5).collect()).collect();
    for _ in 0..N_ROUNDS {
        for vector in &mut basis {
            let mut at_sites = vec![0.0; n_sites];
            for (c, v) in vector.iter().enumerate() {
                for (site, sum) in at_sites.iter_mut().enumerate() {
                    *sum += v * g(c, site);
                }
            }
            for (c, v) in vector.iter_mut().enumerate() {
                *v = (0..n_sites).map(|site| g(c, site) * at_sites[site]).sum();
            }
        }
        orthogonalise(&mut basis);
    }
    (0..n).map(|c| basis.iter().map(|vector| vector[c]).collect()).collect()
}

/// Gram–Schmidt, modified; vectors in the span of those before become 0.
fn orthogonalise(basis: &mut [Vec<f64>]) {
    for i in 0..basis.len() {
        let (before, rest) = basis.split_at_mut(i);
        let vector = &mut rest[0];
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let full = product(vector, vector).sqrt();
        for other in before.iter() {
            let share = product(other, vector);
            for (a, b) in vector.iter_mut().zip(other) {
                *a -= share * b;
            }
        }
        let left = product(vector, vector).sqrt();
        let scale = if left > 1e-12 * full { 1.0 / left } else { 0.0 };
        vector.iter_mut().for_each(|v| *v *= scale);
    }
}
