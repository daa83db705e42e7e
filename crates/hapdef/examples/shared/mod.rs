//! What the examples on contacts by superposition have in common.
#![allow(dead_code, reason = "each example uses its part")]

use hapdef::{MAX_ONE_TO_ONE, OneToOne, ScoredContact, ScoringError, score_one_to_one};
use hapdef_inverse::{Skin, SkinPoint};
use nalgebra::Point3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// `n` places of faces drawn at random, no two nearer to each other than `gap_m`.
pub(crate) fn places_apart(
    skin: &Skin,
    n: usize,
    gap_m: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<SkinPoint> {
    let mut places: Vec<SkinPoint> = Vec::new();
    while places.len() < n {
        let face = rng.random_range(0..skin.n_faces());
        let Ok(place) = SkinPoint::drawn(skin, face, [rng.random(), rng.random()]) else {
            continue;
        };
        let x = skin.position(&place);
        let is_apart = |p: &SkinPoint| (skin.position(p) - x).norm() >= gap_m;
        if places.iter().all(is_apart) {
            places.push(place);
        }
    }
    places
}

/// True and found contacts, each a place and a force in N, one to one at the least summed distance.
pub(crate) fn matched(
    truth: impl IntoIterator<Item = (Point3<f64>, f64)>,
    found: impl IntoIterator<Item = (Point3<f64>, f64)>,
) -> Result<OneToOne, ScoringError> {
    let scored = |(x, force_n): (Point3<f64>, f64)| -> ScoredContact { (x.coords.into(), force_n) };
    let truth: Vec<_> = truth.into_iter().map(scored).collect();
    let found = found.into_iter().map(scored).take(MAX_ONE_TO_ONE);
    score_one_to_one(&found.collect::<Vec<_>>(), &truth)
}

/// 0 of nothing.
pub(crate) fn mean(values: &[f64]) -> f64 {
    (values.iter().sum::<f64>() + 0.0) / values.len().max(1) as f64
}

/// 0 of nothing.
pub(crate) fn percent(n: usize, of: usize) -> f64 {
    n as f64 / of.max(1) as f64 * 100.0
}

/// The value at share `q`, the nearest one; NaN of nothing.
pub(crate) fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = (values.len().saturating_sub(1) as f64 * q).round() as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}
