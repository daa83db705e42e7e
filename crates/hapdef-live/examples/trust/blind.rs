//! Frames in which the sensor can't see what presses.

use hapdef_inverse::BELIEVED_OF_RANGE;
use hapdef_inverse::SkinPoint;
use hapdef_live::{Bundle, Retare, TouchPhase};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{BEFORE, play, silent};

/// The press that must not go unseen unsaid: a quarter of the strongest expected.
const SHARE: f64 = 0.25;

/// Frames after which a press that is seen has been reported, and frozen readings are known to be.
const SOON: usize = 200;

/// Frames that the press lasts.
const HELD: usize = 1200;

/// Frames of `n` streams each with gauges gone, with all readings frozen, and with a press in the first tare, and looks at
/// a stream that has stopped, in which no press is reported: how many of them are unknown, and how many there are.
pub(crate) fn count(bundle: &Bundle, seed: u64, n: u64) -> (usize, usize) {
    let each = (seed..seed + n).flat_map(|seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xb11d);
        [
            without_gauges(bundle, &mut rng),
            frozen(bundle, &mut rng),
            tared_under(bundle, &mut rng),
            silent::phases(bundle, &mut rng),
        ]
    });
    each.flatten()
        .filter(|phase| *phase != TouchPhase::Touched)
        .fold((0, 0), |(unknown, n), phase| {
            (unknown + usize::from(phase.why_unknown().is_some()), n + 1)
        })
}

/// Some gauges are at the end of their range; then it is pressed where the others feel least.
fn without_gauges(bundle: &Bundle, rng: &mut ChaCha8Rng) -> Vec<TouchPhase> {
    let n_gauges = bundle.map().n_gauges();
    let mut order: Vec<usize> = (0..n_gauges).collect();
    order.shuffle(rng);
    let gone = order.split_off(rng.random_range(0..n_gauges));
    let answer = |g: &Vec<f64>| order.iter().map(|gauge| g[*gauge].powi(2)).sum::<f64>();
    let faintest = responses(bundle).min_by(|a, b| answer(a).total_cmp(&answer(b)));
    let (g, force_n) = (faintest.unwrap_or_default(), SHARE * range_n(bundle));
    after(bundle, rng, BEFORE + SOON, move |index, y| {
        if index >= BEFORE + SOON {
            y.iter_mut().zip(&g).for_each(|(y, g)| *y += g * force_n);
        }
        if index >= BEFORE {
            gone.iter().for_each(|gauge| y[*gauge] = f64::INFINITY);
        }
    })
}

/// The device repeats its last frame, whatever presses.
fn frozen(bundle: &Bundle, rng: &mut ChaCha8Rng) -> Vec<TouchPhase> {
    let mut last = Vec::new();
    after(bundle, rng, BEFORE, move |index, y| {
        if index < BEFORE {
            last = y.to_vec();
        }
        y.copy_from_slice(&last);
    })
}

/// A press rises during the first tare and stays.
fn tared_under(bundle: &Bundle, rng: &mut ChaCha8Rng) -> Vec<TouchPhase> {
    let all: Vec<Vec<f64>> = responses(bundle).collect();
    let g = all[rng.random_range(0..all.len())].clone();
    let force_n = rng.random_range(SHARE..1.0) * range_n(bundle);
    after(bundle, rng, 1000 - SOON, move |index, y| {
        let share = (index as f64 / 1000.0).min(1.0);
        y.iter_mut().zip(&g).for_each(|(y, g)| *y += g * force_n * share);
    })
}

/// Phases of the frames that come [`SOON`] after frame `from` or later.
fn after(
    bundle: &Bundle,
    rng: &mut ChaCha8Rng,
    from: usize,
    add: impl FnMut(usize, &mut [f64]) + Send + 'static,
) -> Vec<TouchPhase> {
    let from = from + SOON;
    let frames = play(bundle, from + HELD, rng.random(), Retare::Ask, add);
    frames.into_iter().skip(from).map(|seen| seen.phase).collect()
}

/// What the gauges read for a newton at each node of the skin.
fn responses(bundle: &Bundle) -> impl Iterator<Item = Vec<f64>> + '_ {
    let points = bundle.skin().node_points().into_iter().flatten();
    points.map(|point: SkinPoint| bundle.map().normal(&point))
}

fn range_n(bundle: &Bundle) -> f64 {
    bundle.info.settings.max_force_n / BELIEVED_OF_RANGE
}
