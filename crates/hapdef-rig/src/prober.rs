//! What the probing robot presses: the protocol of Sun & Martius 2019, sections 3.1 and 4.4.

use hapdef_contact::DrawnContact;
use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::RigError;

/// Single presses at random sites with random forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SinglePressParams {
    /// Number of presses.
    pub n_presses: usize,
    /// Forces are uniform in this range, N.
    pub force_range_n: (f64, f64),
    /// Seed of sites and forces.
    pub seed: u64,
}

/// Pairs of presses: one held by a robot arm, the other applied by hand with varied force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoublePressParams {
    /// Number of pairs of sites; the paper has 270.
    pub n_pairs: usize,
    /// Forces of the varied contact per pair; the paper has 25.
    pub n_amplitudes: usize,
    /// Distance of the two sites, m; the paper has 12–75 mm.
    pub spacing_range_m: (f64, f64),
    /// The held force, N; the paper has around 30 N.
    pub held_force_n: f64,
    /// The held force is uniform in `held_force_n ± held_spread_n`, N.
    pub held_spread_n: f64,
    /// The varied force goes from the first to the second, N; the paper has 0–34 N.
    pub varied_range_n: (f64, f64),
    /// Seed of sites and forces.
    pub seed: u64,
}

/// Draws single presses on `n_sites` contact sites.
#[must_use]
pub fn single_presses(n_sites: usize, params: &SinglePressParams) -> Vec<DrawnContact> {
    let mut rng = ChaCha8Rng::seed_from_u64(params.seed);
    let (low, high) = params.force_range_n;
    let mut press = || DrawnContact {
        node: rng.random_range(0..n_sites),
        force_n: rng.random_range(low..=high),
    };
    (0..params.n_presses).map(|_| press()).collect()
}

/// Draws the double presses, `n_pairs × n_amplitudes` of them, the held contact first.
///
/// # Errors
/// [`RigError::TooFewPairs`] when random search does not find the wanted number of pairs.
pub fn double_presses(
    sites: &[Point3<f64>],
    params: &DoublePressParams,
) -> Result<Vec<[DrawnContact; 2]>, RigError> {
    let mut rng = ChaCha8Rng::seed_from_u64(params.seed);
    let pairs = draw_pairs(sites, params, &mut rng)?;
    let mut presses = Vec::with_capacity(params.n_pairs * params.n_amplitudes);
    for [held, varied] in pairs {
        for step in 0..params.n_amplitudes {
            let spread = rng.random_range(-params.held_spread_n..=params.held_spread_n);
            presses.push([
                DrawnContact { node: held, force_n: params.held_force_n + spread },
                DrawnContact { node: varied, force_n: amplitude(step, params) },
            ]);
        }
    }
    Ok(presses)
}

/// Evenly spaced forces over the varied range, both ends included.
fn amplitude(step: usize, params: &DoublePressParams) -> f64 {
    let (low, high) = params.varied_range_n;
    let last = params.n_amplitudes.max(2) - 1;
    low + (high - low) * step as f64 / last as f64
}

fn draw_pairs(
    sites: &[Point3<f64>],
    params: &DoublePressParams,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<[usize; 2]>, RigError> {
    let (min, max) = params.spacing_range_m;
    let mut pairs = Vec::with_capacity(params.n_pairs);
    for _ in 0..params.n_pairs * 1000 {
        if pairs.len() == params.n_pairs || sites.is_empty() {
            break;
        }
        let pair = [rng.random_range(0..sites.len()), rng.random_range(0..sites.len())];
        if (min..=max).contains(&(sites[pair[0]] - sites[pair[1]]).norm()) {
            pairs.push(pair);
        }
    }
    if pairs.len() < params.n_pairs {
        let (found, wanted) = (pairs.len(), params.n_pairs);
        return Err(RigError::TooFewPairs { found, wanted, min_mm: min * 1e3, max_mm: max * 1e3 });
    }
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring() -> Vec<Point3<f64>> {
        (0..60)
            .map(|i| {
                let angle = f64::from(i) / 60.0 * std::f64::consts::TAU;
                Point3::new(0.036 * angle.cos(), 0.05, 0.036 * angle.sin())
            })
            .collect()
    }

    fn doubles() -> DoublePressParams {
        DoublePressParams {
            n_pairs: 27,
            n_amplitudes: 25,
            spacing_range_m: (0.012, 0.075),
            held_force_n: 30.0,
            held_spread_n: 1.0,
            varied_range_n: (0.0, 34.0),
            seed: 5,
        }
    }

    #[test]
    fn doubles_follow_the_protocol() {
        let sites = ring();
        let presses = double_presses(&sites, &doubles()).unwrap();
        assert_eq!(presses.len(), 27 * 25);
        for [held, varied] in &presses {
            let spacing = (sites[held.node] - sites[varied.node]).norm();
            assert!((0.012..=0.075).contains(&spacing), "{spacing}");
            assert!((29.0..=31.0).contains(&held.force_n), "{}", held.force_n);
        }
        assert_eq!((presses[0][1].force_n, presses[24][1].force_n), (0.0, 34.0));
    }

    #[test]
    fn sites_too_close_together_are_refused() {
        let error = double_presses(&ring()[..2], &doubles()).unwrap_err();
        assert!(matches!(error, RigError::TooFewPairs { found: 0, wanted: 27, .. }), "{error}");
    }

    #[test]
    fn singles_cover_sites_and_forces() {
        let params = SinglePressParams { n_presses: 4000, force_range_n: (0.0, 34.0), seed: 1 };
        let presses = single_presses(10, &params);
        assert!((0..10).all(|site| presses.iter().any(|p| p.node == site)));
        let mean = presses.iter().map(|p| p.force_n).sum::<f64>() / 4000.0;
        assert!((mean - 17.0).abs() < 0.5, "mean force {mean}");
    }
}
