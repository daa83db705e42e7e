//! Bounds that a layout reaches.

use crate::dense::{cholesky, inverse};
use crate::error::InverseError;
use crate::placement::information::unit;
use crate::placement::random::Draws;
use crate::placement::{Candidates, PlacementParams};

/// Cramér–Rao bounds of a layout, with the prior as further information, so that blind spots count
/// with the prior's spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacementScore {
    /// Mean over the sites of a single contact's position bound √(σ₁² + σ₂²), m.
    pub single_mean_m: f64,
    /// 95th percentile of the same, m.
    pub single_p95_m: f64,
    /// Median position bound over the contacts of drawn pairs, m.
    pub pair_median_m: f64,
    /// 95th percentile of the same, m.
    pub pair_p95_m: f64,
}

/// The bounds of the gauges `chosen`.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or a gauge that is no candidate.
pub fn placement_score(
    candidates: &Candidates,
    chosen: &[usize],
    params: &PlacementParams,
) -> Result<PlacementScore, InverseError> {
    let checked = PlacementParams { mounted: chosen.to_vec(), ..params.clone() };
    candidates.check(&checked)?;
    let mut singles: Vec<f64> = (0..candidates.n_sites())
        .flat_map(|site| bounds::<1>(candidates, chosen, params, [site]))
        .collect();
    let pairs = draw_pairs(candidates, params);
    let mut doubles: Vec<f64> =
        pairs.iter().flat_map(|pair| bounds::<2>(candidates, chosen, params, *pair)).collect();
    let mean = singles.iter().sum::<f64>() / singles.len().max(1) as f64;
    Ok(PlacementScore {
        single_mean_m: mean,
        single_p95_m: quantile(&mut singles, 0.95),
        pair_median_m: quantile(&mut doubles, 0.5),
        pair_p95_m: quantile(&mut doubles, 0.95),
    })
}

/// Pairs of sites at least the gap apart, where a few tries find such.
pub(crate) fn draw_pairs(candidates: &Candidates, params: &PlacementParams) -> Vec<[usize; 2]> {
    let mut draws = Draws::new(params.seed);
    let n = candidates.n_sites();
    let mut pair = || {
        let mut sites = [0, 0];
        for _ in 0..100 {
            sites = [draws.below(n), draws.below(n)];
            let [a, b] = sites.map(|s| candidates.sites_m[s]);
            if (a - b).norm() >= params.min_gap_m {
                break;
            }
        }
        sites
    };
    (0..params.n_pairs).map(|_| pair()).collect()
}

/// Position bounds of `K` contacts at `sites`, m, whatever the loads are that are no contacts.
pub(crate) fn bounds<const K: usize>(
    candidates: &Candidates,
    chosen: &[usize],
    params: &PlacementParams,
    sites: [usize; K],
) -> [f64; K] {
    let n = 3 * K + candidates.n_loads();
    let mut a = unit(n);
    let mut j = vec![0.0; n];
    for &c in chosen {
        candidates.unknowns(c, &sites, params, &mut j);
        for p in 0..n {
            for q in 0..=p {
                a[p * n + q] += j[p] * j[q];
            }
        }
    }
    if !cholesky(&mut a, n, 0.0) {
        return [params.prior_sd.0; K];
    }
    let mut covariance = vec![0.0; n * n];
    inverse(&a, n, &mut covariance);
    let variance = |q: usize| covariance[q * n + q];
    std::array::from_fn(|k| params.prior_sd.0 * (variance(3 * k) + variance(3 * k + 1)).sqrt())
}

pub(crate) fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = (values.len().saturating_sub(1) as f64 * q).round() as usize;
    values.get(place).copied().unwrap_or(0.0)
}
