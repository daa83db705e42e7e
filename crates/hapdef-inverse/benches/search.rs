//! Time of one frame by what touches, and of a warm start; 800 sites, 10 gauges.
#![allow(missing_docs, reason = "criterion's macros")]

#[path = "../tests/it/world/mod.rs"]
mod world;

use criterion::{Criterion, criterion_group, criterion_main};
use hapdef_inverse::{ContactEstimate, EstimatorParams, NoiseParams};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use world::World;

fn frames(c: &mut Criterion) {
    let world = World::new(10, 800, 7);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for (name, k) in [("untouched", 0), ("cold single", 1), ("cold pair", 2), ("cold triple", 3)] {
        let params =
            EstimatorParams { known_count: (k > 0).then_some(k), ..EstimatorParams::default() };
        let estimator = world.estimator(NoiseParams::uniform(10, 1.0), params);
        let points = world.draw_points(k, 0.015, &mut rng);
        let contacts: Vec<_> = points.iter().map(|p| (*p, 15.0)).collect();
        let mut y = world.readings(&contacts);
        world::add_noise(&mut y, 1.0, &mut rng);
        let (mut scratch, mut out) = (estimator.scratch(), ContactEstimate::default());
        c.bench_function(name, |b| {
            b.iter(|| estimator.estimate_into(&y, &mut scratch, &mut out));
        });
        if k > 0 {
            c.bench_function(&format!("{name}, warm start"), |b| {
                b.iter(|| estimator.refine_into(&y, &points, &mut scratch, &mut out));
            });
        }
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
