//! What comes: noise, weak contacts, one after another, two at once, one of too much force.

use super::*;

#[test]
fn noise_alone_is_never_a_contact() {
    for relative in [0.0, 0.014] {
        let world = World::new(10, 400, 3);
        let mut tracker = tracker(&world, relative, TrackerParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut n_born, mut n_detecting) = (0, 0);
        for _ in 0..20_000 {
            let y = frame(&world, &[], SD, &mut rng);
            let found = tracker.step(&y, None).unwrap();
            n_born += found.info.n_born;
            n_detecting += usize::from(found.info.is_detecting);
        }
        assert_eq!(n_born, 0, "{n_detecting} frames of detection");
    }
}

/// Beside a press whose noise is twice what was assumed ghosts are born, the fewer the more force a contact
/// must have to be held.
#[test]
fn what_is_too_weak_to_be_held_is_not_born() {
    let world = World::new(10, 400, 3);
    let n_ghosts = |release_force_n: f64| {
        let params = TrackerParams { release_force_n, ..TrackerParams::default() };
        let mut tracker = tracker(&world, 0.1, params);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let point = world.draw_points(1, 0.01, &mut rng)[0];
        let mut n_born = 0;
        for index in 0..6000 {
            let press = (point, ramp(index, 50, 15.0));
            let y = frame(&world, &[press], 2.0 * SD, &mut rng);
            n_born += tracker.step(&y, None).unwrap().info.n_born;
        }
        n_born - 1
    };
    let n = [0.0, 0.3, 3.0].map(n_ghosts);
    assert!(n[1] < n[0] && 3 * n[2] < n[0], "{n:?}");
}

/// Four contacts one after another, at their places within a millimetre, names kept, then released
/// one after another.
#[test]
fn contacts_come_hold_and_go() {
    let n_scenes = 12;
    let mut n_good = 0;
    for seed in 0..n_scenes {
        let world = World::new(10, 600, 20 + seed);
        let mut tracker = tracker(&world, 0.0, TrackerParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let points = world.draw_points(4, 0.02, &mut rng);
        let mut names = Vec::new();
        let mut is_good = true;
        for index in 0..2000 {
            let contacts: Vec<_> = (0..4)
                .map(|i| {
                    let come = ramp(index, 50 + 200 * i, 15.0);
                    (points[i], come - ramp(index, 1000 + 200 * i, 15.0))
                })
                .filter(|c| c.1 > 0.0)
                .collect();
            let y = frame(&world, &contacts, SD, &mut rng);
            let found = tracker.step(&y, None).unwrap();
            if index % 200 == 190 {
                is_good &= worst_m(&world, &contacts, found) < 1e-3;
                let now: Vec<_> = found.contacts.iter().map(|c| c.id).collect();
                if index < 1000 {
                    is_good &= now.starts_with(&names);
                } else {
                    is_good &= now.iter().all(|id| names.contains(id));
                }
                names = now;
            }
        }
        is_good &= tracker.last().contacts.is_empty();
        n_good += u64::from(is_good);
    }
    assert!(n_good + 1 >= n_scenes, "{n_good} of {n_scenes} scenes");
}

/// Two at once, beside two that are held: every frame alarms until the pair is found.
#[test]
fn a_pair_that_comes_beside_held_contacts_is_found() {
    let n_scenes = 40;
    let mut n_good = 0;
    for seed in 0..n_scenes {
        let world = World::new(10, 600, 40 + seed);
        let mut tracker = tracker(&world, 0.0, TrackerParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let points = world.draw_points(4, 0.02, &mut rng);
        let starts = [50, 250, 450, 450];
        let mut contacts = Vec::new();
        for index in 0..700 {
            let press = |i: usize| (points[i], ramp(index, starts[i], 15.0));
            contacts = (0..4).map(press).filter(|c| c.1 > 0.0).collect();
            let y = frame(&world, &contacts, SD, &mut rng);
            tracker.step(&y, None).unwrap();
        }
        n_good += u64::from(worst_m(&world, &contacts, tracker.last()) < 2e-3);
    }
    assert!(n_good + 1 >= n_scenes, "{n_good} of {n_scenes} scenes");
}

/// A press of twice the largest force is reported all the same: nothing else explains it.
#[test]
fn a_force_beyond_the_largest_is_followed_where_nothing_else_explains_it() {
    let world = World::new(10, 600, 5);
    let params = EstimatorParams { max_force_n: 20.0, ..EstimatorParams::default() };
    let estimator = world.estimator(noise(0.014), params);
    let mut tracker = ContactTracker::new(&estimator, TrackerParams::default()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let point = world.draw_points(1, 0.03, &mut rng)[0];
    let press = [(point, 40.0)];
    for index in 0..400 {
        let now = [(point, ramp(index, 50, 40.0))];
        let y = frame(&world, &now, SD, &mut rng);
        tracker.step(&y, None).unwrap();
    }
    assert!(worst_m(&world, &press, tracker.last()) < 1e-3);
    let force_n = tracker.last().contacts[0].contact.force_n;
    assert!((force_n - 40.0).abs() < 1.0, "{force_n} N");
}

#[test]
fn two_at_once_are_two() {
    let mut n_good = 0;
    for seed in 0..10 {
        let world = World::new(10, 600, 60 + seed);
        let mut tracker = tracker(&world, 0.0, TrackerParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let points = world.draw_points(2, 0.025, &mut rng);
        let contacts: Vec<_> = points.iter().map(|p| (*p, 15.0)).collect();
        for index in 0..400 {
            let now: Vec<_> = points.iter().map(|p| (*p, ramp(index, 20, 15.0))).collect();
            let y = frame(&world, &now, SD, &mut rng);
            tracker.step(&y, None).unwrap();
        }
        n_good += usize::from(worst_m(&world, &contacts, tracker.last()) < 1e-3);
    }
    assert!(n_good >= 9, "{n_good} of 10 pairs");
}
