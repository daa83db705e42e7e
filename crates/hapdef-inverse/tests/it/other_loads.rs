//! Loads that are no contacts hide nothing that the readings decide, and are never taken for contacts.

use crate::world;

use hapdef_inverse::{
    ContactEstimator, ContactTracker, EstimatorParams, InverseError, NoiseParams, OtherLoads,
    SeenForces, SkinPoint, TrackerParams, joint_bounds,
};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use world::World;

const SD: f64 = 1.0;
/// Of each load, in a unit that moves gauges by about 10.
const LOAD_SD: f64 = 30.0;

/// Loads as through the limb's free end, µε: bending about two axes by a force and by a moment, pull and
/// twist.
fn loads(world: &World, sd: f64) -> OtherLoads {
    let of = |load: usize| {
        world.gauges.iter().map(move |gauge| {
            let arm = 1.0 - gauge.height_m / world::LENGTH_M;
            match load {
                0 => 12.0 * arm * gauge.angle.cos(),
                1 => 12.0 * arm * gauge.angle.sin(),
                2 => 8.0 * gauge.angle.cos(),
                3 => 8.0 * gauge.angle.sin(),
                4 => 6.0,
                _ => 5.0 * (2.0 * gauge.angle).sin(),
            }
        })
    };
    OtherLoads { response: (0..6).flat_map(of).collect(), sd: vec![sd; 6] }
}

fn estimator(world: &World, sd: f64) -> ContactEstimator {
    let noise =
        NoiseParams { loads: loads(world, sd), ..NoiseParams::uniform(world.gauges.len(), SD) };
    world.estimator(noise, EstimatorParams::default())
}

fn drawn(rng: &mut ChaCha8Rng) -> [f64; 6] {
    std::array::from_fn(|_| {
        let unit: f64 = StandardNormal.sample(rng);
        LOAD_SD * unit
    })
}

/// Readings of contacts beside loads, with noise.
fn frame(
    world: &World,
    contacts: &[(SkinPoint, f64)],
    amounts: &[f64; 6],
    rng: &mut ChaCha8Rng,
) -> Vec<f64> {
    let mut y = world.readings(contacts);
    loads(world, LOAD_SD).take_off(&amounts.map(|a| -a), &mut y).unwrap();
    world::add_noise(&mut y, SD, rng);
    y
}

/// The covariance with loads marginalised is that of contacts and loads estimated together (the block of
/// the inverse of the joint information).
#[test]
fn a_marginalised_load_costs_what_estimating_it_costs() {
    let world = World::new(16, 400, 2);
    let skin = world.map.skin();
    for (seed, sd) in [(1, 0.01), (2, 1.0), (3, 30.0)] {
        let estimator = estimator(&world, sd);
        let loads = loads(&world, sd);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let point = world.draw_points(1, 0.0, &mut rng)[0];
        let force_n = 10.0;
        let bound = joint_bounds(&estimator, &[(point, force_n)]).unwrap().unwrap()[0];
        let tangents = skin.tangents(&point);
        let step_m = 1e-7;
        let slope = |p: usize| {
            let at = |sign: f64| {
                let step = tangents[p] * (sign * step_m);
                let moved = skin.walk(&point, &step, hapdef_inverse::AtWall::Slide).point;
                DVector::from_vec(world.map.normal(&moved))
            };
            (at(1.0) - at(-1.0)) * (0.5 * force_n / step_m)
        };
        let mut columns = vec![slope(0), slope(1), DVector::from_vec(world.map.normal(&point))];
        columns.extend(loads.response.chunks_exact(16).map(DVector::from_row_slice));
        let jacobian = DMatrix::from_columns(&columns);
        let mut information = jacobian.transpose() * &jacobian / (SD * SD);
        for load in 3..9 {
            information[(load, load)] += 1.0 / (sd * sd);
        }
        let covariance = information.try_inverse().unwrap();
        let expected_m = (covariance[(0, 0)] + covariance[(1, 1)]).sqrt();
        let expected_n = covariance[(2, 2)].sqrt();
        assert!((bound.position_sd_m / expected_m - 1.0).abs() < 1e-4, "{bound:?} {expected_m}");
        assert!((bound.force_sd_n / expected_n - 1.0).abs() < 1e-4, "{bound:?} {expected_n}");
    }
}

/// Ten and sixteen gauges; each frame has other loads of a few hundred microstrains. Frames are taken for
/// touched no more often than those of noise alone, `touch_p` of them: 2 of 2,000, at most 6 by chance (Poisson,
/// 99.5 %).
#[test]
fn loads_alone_are_no_contact() {
    for n_gauges in [10, 16] {
        let world = World::new(n_gauges, 400, 3);
        let with = estimator(&world, LOAD_SD);
        let without =
            world.estimator(NoiseParams::uniform(n_gauges, SD), EstimatorParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let (mut n_with, mut n_without) = (0, 0);
        for index in 0..2000 {
            let y = frame(&world, &[], &drawn(&mut rng), &mut rng);
            n_with += usize::from(!with.estimate(&y).unwrap().contacts.is_empty());
            if index < 50 {
                n_without += usize::from(!without.estimate(&y).unwrap().contacts.is_empty());
            }
        }
        assert!(n_with <= 6, "{n_gauges} gauges: {n_with} of 2000");
        assert!(n_without > 45, "the loads show: {n_without} of 50");
    }
}

/// A contact is as far off as its bound says, whatever the loads are.
#[test]
fn a_contact_beside_loads_is_found_within_its_bound() {
    let world = World::new(16, 400, 5);
    let estimator = estimator(&world, LOAD_SD);
    let skin = world.map.skin();
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let (mut n_found, mut ratios) = (0, Vec::new());
    for _ in 0..100 {
        let point = world.draw_points(1, 0.0, &mut rng)[0];
        let y = frame(&world, &[(point, 20.0)], &drawn(&mut rng), &mut rng);
        let found = estimator.estimate(&y).unwrap();
        let Some(bound) = joint_bounds(&estimator, &[(point, 20.0)]).unwrap() else {
            continue;
        };
        if let [contact] = &found.contacts[..] {
            n_found += 1;
            let off_m = (contact.position_m - skin.position(&point)).norm();
            ratios.push(off_m / bound[0].position_sd_m);
        }
    }
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    assert!(n_found >= 90, "{n_found} of 100");
    // of a two-dimensional Gaussian between 0.67 (one direction has it all) and 0.83 (both the same)
    assert!((0.5..1.1).contains(&median), "{median}");
}

/// Loads that stay for seconds, jump and go are never contacts to the tracker; one that presses beside
/// them is.
#[test]
fn the_tracker_follows_a_contact_while_loads_come_and_go() {
    let world = World::new(16, 400, 7);
    let skin = world.map.skin();
    let estimator = estimator(&world, LOAD_SD);
    let mut tracker = ContactTracker::new(&estimator, TrackerParams::default()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let point = world.draw_points(1, 0.0, &mut rng)[0];
    let mut amounts = [0.0; 6];
    let (mut n_false, mut n_wrong, mut worst_m) = (0, 0, 0.0_f64);
    for index in 0..6000 {
        if index % 1500 == 200 {
            amounts = drawn(&mut rng);
        }
        let is_pressed = (2000..4000).contains(&index);
        let force_n = 15.0 * (f64::from(index - 2000) / 30.0).min(1.0);
        let contacts = if is_pressed { vec![(point, force_n)] } else { Vec::new() };
        let y = frame(&world, &contacts, &amounts, &mut rng);
        let found = tracker.step(&y, None).unwrap();
        n_false += usize::from(!is_pressed && index % 4000 > 40 && !found.contacts.is_empty());
        if (2200..4000).contains(&index) {
            n_wrong += usize::from(found.contacts.len() != 1);
            let near = found.contacts.iter().map(|c| c.contact.position_m - skin.position(&point));
            worst_m = near.map(|off| off.norm()).fold(worst_m, f64::max);
        }
    }
    assert_eq!((n_false, n_wrong), (0, 0));
    assert!(worst_m < 1e-3, "{worst_m} m");
}

/// What is hidden in the loads' directions takes more force to be seen.
#[test]
fn what_would_be_seen_counts_the_loads() {
    let world = World::new(10, 400, 9);
    let seen = |sd: f64| SeenForces::new(&estimator(&world, sd)).smallest_n(None);
    let (none, some, many) = (seen(0.0), seen(0.1), seen(30.0));
    assert!(none < some && some < many, "{none} {some} {many} N");
}

#[test]
fn loads_of_another_number_of_gauges_are_refused() {
    let world = World::new(10, 400, 9);
    let other = World::new(11, 400, 9);
    let noise = NoiseParams { loads: loads(&other, 1.0), ..NoiseParams::uniform(10, SD) };
    let refused = ContactEstimator::new(
        world.map.clone(),
        world.sites.clone(),
        noise,
        EstimatorParams::default(),
    );
    assert!(matches!(refused, Err(InverseError::Length { expected: 60, found: 66, .. })));
}

/// Six loads show in two thousand untouched frames, and beside what was learned of them others are no contacts.
#[test]
fn learned_loads_are_no_contact() {
    let world = World::new(16, 400, 11);
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let untouched = |rng: &mut ChaCha8Rng| frame(&world, &[], &drawn(rng), rng);
    let frames: Vec<f64> = (0..2000).flat_map(|_| untouched(&mut rng)).collect();
    let learned = OtherLoads::learned(&frames, &[SD; 16], 2.0).unwrap();
    assert_eq!(learned.len(), 6);
    let plain = world.estimator(NoiseParams::uniform(16, SD), EstimatorParams::default());
    let estimator = plain.with_loads(learned).unwrap();
    let mut n = 0;
    for _ in 0..1000 {
        let found = estimator.estimate(&untouched(&mut rng)).unwrap();
        n += usize::from(!found.contacts.is_empty());
    }
    // touch_p of 1000 is 1; more than 4 are so in 0.4 % of the cases (Poisson)
    assert!(n <= 4, "{n} of 1000");
}

#[test]
fn noise_alone_shows_no_load() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    for n_frames in [50, 500, 5000] {
        let mut frames = vec![0.0; 12 * n_frames];
        world::add_noise(&mut frames, 0.7, &mut rng);
        let learned = OtherLoads::learned(&frames, &[0.7; 12], 2.0).unwrap();
        assert!(learned.is_empty(), "{n_frames} frames: {}", learned.len());
    }
    let few = OtherLoads::learned(&[0.0; 24], &[0.7; 12], 2.0);
    assert!(matches!(few, Err(InverseError::Length { .. })), "{few:?}");
}
