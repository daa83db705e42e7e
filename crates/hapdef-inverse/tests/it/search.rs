//! Searches find what the readings prefer: hardly anything explains a frame better than what is found.

use crate::world::{self, World};

use hapdef_inverse::{ContactEstimate, EstimatorParams, NoiseParams, SkinPoint};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Of `n_frames` frames of `k` contacts of 5 to 34 N, 20 mm apart, on `n_gauges`, their number given: those in
/// which contacts refined from the true places have better evidence than what was found, by more than a tie.
fn missed(k: usize, n_gauges: usize, n_frames: usize, seed: u64) -> usize {
    let world = World::new(n_gauges, 800, seed);
    let params = EstimatorParams { known_count: Some(k), ..EstimatorParams::default() };
    let estimator = world.estimator(NoiseParams::uniform(n_gauges, 1.0), params);
    let (mut scratch, mut of_truth) = (estimator.scratch(), ContactEstimate::default());
    let mut found = ContactEstimate::default();
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 100);
    let mut n_missed = 0;
    for _ in 0..n_frames {
        let points = world.draw_points(k, 0.02, &mut rng);
        let contacts: Vec<(SkinPoint, f64)> =
            points.iter().map(|&point| (point, rng.random_range(5.0..34.0))).collect();
        let mut readings = world.readings(&contacts);
        world::add_noise(&mut readings, 1.0, &mut rng);
        estimator.estimate_into(&readings, &mut scratch, &mut found).unwrap();
        estimator.refine_into(&readings, &points, &mut scratch, &mut of_truth).unwrap();
        n_missed += usize::from(found.cost > of_truth.cost + params.tie_delta);
        assert!(!found.contacts.is_empty(), "no contact, χ² {:e}", found.chi2);
    }
    n_missed
}

#[test]
fn what_is_found_explains_a_frame_no_worse_than_the_truth() {
    for (k, n_gauges, n_frames, most) in
        [(2, 10, 60, 0), (3, 10, 60, 2), (3, 16, 60, 1), (4, 16, 100, 3)]
    {
        let n_missed = missed(k, n_gauges, n_frames, 21);
        let shown = format!("{k} contacts on {n_gauges} gauges: {n_missed} of {n_frames} missed");
        println!("{shown}");
        assert!(n_missed <= most, "{shown}");
    }
}
