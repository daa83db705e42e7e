//! Contacts followed from frame to frame: what comes is found, what holds keeps its name, what goes
//! is let go, and noise alone is nothing.

mod coming;
mod efforts;
mod holding;
use crate::world;

use hapdef_inverse::{
    AtWall, BackgroundSearch, ContactTracker, EstimatorParams, InverseError, ModelError,
    NoiseParams, Phase, SearchOutcome, Searcher, SkinPoint, TrackedFrame, TrackerParams, Verdict,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use world::World;

const SD: f64 = 1.0;

fn noise(relative: f64) -> NoiseParams {
    NoiseParams {
        model_error: ModelError { relative, ..ModelError::default() },
        ..NoiseParams::uniform(10, SD)
    }
}

fn tracker(world: &World, relative: f64, params: TrackerParams) -> ContactTracker {
    let estimator = world.estimator(noise(relative), EstimatorParams::default());
    ContactTracker::new(&estimator, params).unwrap()
}

/// Readings of `contacts` with noise `sd`.
fn frame(world: &World, contacts: &[(SkinPoint, f64)], sd: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut y = world.readings(contacts);
    world::add_noise(&mut y, sd, rng);
    y
}

/// A ramp from 0 to `force_n` in 30 frames from `start` on.
fn ramp(index: usize, start: usize, force_n: f64) -> f64 {
    force_n * (index.saturating_sub(start) as f64 / 30.0).min(1.0)
}

/// The largest distance of a contact of `found` from its match in `truth`, m; infinite if counts
/// differ.
fn worst_m(world: &World, truth: &[(SkinPoint, f64)], found: &TrackedFrame) -> f64 {
    if truth.len() != found.contacts.len() {
        return f64::INFINITY;
    }
    let skin = world.map.skin();
    let places: Vec<_> = truth.iter().map(|t| skin.position(&t.0)).collect();
    let found: Vec<_> = found.contacts.iter().map(|c| c.contact.position_m).collect();
    let gaps = world::matched(&places, &found).into_iter().enumerate();
    gaps.map(|(i, j)| j.map_or(f64::INFINITY, |j| (places[i] - found[j]).norm()))
        .fold(0.0, f64::max)
}
