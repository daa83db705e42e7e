//! What property tests of streams draw, and where they keep what failed.

use hapdef_inverse::SkinPoint;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::N_GAUGES;
use super::world::World;

/// So many cases; what failed once is tried first.
pub fn config(cases: u32) -> ProptestConfig {
    let kept = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/laws.proptest-regressions");
    ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::Direct(kept))),
        ..ProptestConfig::with_cases(cases)
    }
}

/// How the zeros of all gauges drift, up to `most` in any direction and faster in the directions that drift has,
/// µε/s `[n_gauges]`.
pub fn rates(most: f64) -> impl Strategy<Value = Vec<f64>> {
    let each = prop::collection::vec(-most..most, N_GAUGES);
    let common = (-2.5 * most..2.5 * most).prop_map(|rate| vec![rate; N_GAUGES]);
    let single = (0..N_GAUGES, -2.5 * most..2.5 * most).prop_map(|(gauge, rate)| {
        let mut rates = vec![0.0; N_GAUGES];
        rates[gauge] = rate;
        rates
    });
    prop_oneof![1 => Just(vec![0.0; N_GAUGES]), 3 => each, 1 => common, 1 => single]
}

/// Places 3 cm apart.
pub fn points(world: &World, n: usize, seed: u64) -> Vec<SkinPoint> {
    world.draw_points(n, 0.03, &mut ChaCha8Rng::seed_from_u64(seed))
}

/// How far zeros have drifted after so many milliseconds, µε `[n_gauges]`.
pub fn drifted(rates: &[f64], ms: usize) -> Vec<f64> {
    rates.iter().map(|rate| rate * ms as f64 * 1e-3).collect()
}
