//! Time of one frame while contacts are held, updates included; 800 sites, 10 gauges.
#![allow(missing_docs, reason = "criterion's macros")]

#[path = "../tests/it/world/mod.rs"]
mod world;

use criterion::{Criterion, criterion_group, criterion_main};
use hapdef_inverse::{
    ContactTracker, EstimatorParams, ModelError, NoiseParams, SkinPoint, TrackerParams,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use world::World;

fn held(c: &mut Criterion) {
    let world = World::new(10, 800, 7);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for relative in [0.0, 0.014] {
        for k in 0..=4 {
            let noise = NoiseParams {
                model_error: ModelError { relative, ..ModelError::default() },
                ..NoiseParams::uniform(10, 1.0)
            };
            let estimator = world.estimator(noise, EstimatorParams::default());
            let Ok(mut tracker) = ContactTracker::new(&estimator, TrackerParams::default()) else {
                continue;
            };
            let points = world.draw_points(k, 0.025, &mut rng);
            let mut frame = |index: usize| {
                let press = |(i, p): (usize, &SkinPoint)| {
                    let since = index.saturating_sub(200 * i) as f64;
                    (*p, 15.0 * (since / 30.0).min(1.0))
                };
                let contacts: Vec<_> = points.iter().enumerate().map(press).collect();
                let mut y = world.readings(&contacts);
                world::add_noise(&mut y, 1.0, &mut rng);
                y
            };
            for index in 0..1000 {
                let _ = tracker.step(&frame(index), None);
            }
            let frames: Vec<_> = (0..256).map(|_| frame(1000)).collect();
            let mut next = 0;
            c.bench_function(&format!("{k} held, map error {relative}"), |b| {
                b.iter(|| {
                    next = (next + 1) % frames.len();
                    tracker.step(&frames[next], None).map(|found| found.chi2)
                });
            });
        }
    }
}

criterion_group!(benches, held);
criterion_main!(benches);
