//! Following contacts allocates nothing, whatever they do.
#![allow(unsafe_code, reason = "an allocator that counts")]

use crate::world;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use hapdef_inverse::{
    AtWall, ContactTracker, EstimatorParams, ModelError, NoiseParams, SkinPoint, TrackerParams,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use world::World;

struct Counting;

thread_local! {
    static N_ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = N_ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Two at once, two more, a slide, releases.
fn script(points: &[SkinPoint], world: &World, index: usize) -> Vec<(SkinPoint, f64)> {
    let skin = world.map.skin();
    let ramp = |start: usize| (index.saturating_sub(start) as f64 / 30.0).min(1.0);
    let starts = [30, 30, 300, 550];
    let gone = (index as f64 - 900.0).clamp(0.0, 300.0) * 4e-5;
    let mut contacts = Vec::new();
    for (i, start) in starts.into_iter().enumerate() {
        let force = 15.0 * (ramp(start) - ramp(1400 + 100 * i));
        let step = skin.tangents(&points[i])[0] * if i == 2 { gone } else { 0.0 };
        let point = skin.walk(&points[i], &step, AtWall::Slide).point;
        if force > 0.0 {
            contacts.push((point, force));
        }
    }
    contacts
}

#[test]
fn following_contacts_allocates_nothing() {
    for (seed, relative) in [(1, 0.0), (2, 0.014), (3, 0.014)] {
        let world = World::new(10, 400, seed);
        let noise = NoiseParams {
            model_error: ModelError { relative, ..ModelError::default() },
            ..NoiseParams::uniform(10, 1.0)
        };
        let estimator = world.estimator(noise, EstimatorParams::default());
        let mut tracker = ContactTracker::new(&estimator, TrackerParams::default()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let points = world.draw_points(4, 0.025, &mut rng);
        let frames: Vec<Vec<f64>> = (0..2000)
            .map(|index| {
                let mut y = world.readings(&script(&points, &world, index));
                world::add_noise(&mut y, 1.0, &mut rng);
                y
            })
            .collect();
        let (mut n_born, mut n_rows, mut n_released, mut n_slides) = (0, 0, 0, 0);
        let before = N_ALLOCATIONS.get();
        for y in &frames {
            let info = tracker.step(y, None).unwrap().info;
            n_born += info.n_born;
            n_rows += info.n_pair_rows;
            n_released += info.n_released;
            n_slides += info.n_slides;
        }
        let n = N_ALLOCATIONS.get() - before;
        assert_eq!(n, 0, "allocations in {} frames", frames.len());
        assert!(
            n_born >= 4 && n_released >= 4 && n_slides >= 1 && n_rows > 0,
            "seed {seed}: {n_born} births, {n_released} releases, {n_slides} slides, {n_rows} rows"
        );
    }
}
