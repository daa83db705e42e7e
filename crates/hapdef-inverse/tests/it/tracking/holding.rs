//! What holds, slides and goes, searches beside it, gauges that drop out, bounded work.

use super::*;

/// With the places known and no noise, forces are what they are, however fast they change.
#[test]
fn forces_of_held_contacts_follow_at_once() {
    let world = World::new(10, 600, 5);
    let params = TrackerParams { force_frames: 1, ..TrackerParams::default() };
    let mut tracker = tracker(&world, 0.0, params);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let points = world.draw_points(2, 0.03, &mut rng);
    let mut worst = 0.0_f64;
    for index in 0..1000 {
        let forces = if index < 600 {
            [ramp(index, 20, 12.0), ramp(index, 250, 20.0)]
        } else {
            [rng.random_range(5.0..34.0), rng.random_range(5.0..34.0)]
        };
        let contacts = [(points[0], forces[0]), (points[1], forces[1])];
        let found = tracker.step(&world.readings(&contacts), None).unwrap();
        if index >= 600 {
            assert_eq!(found.contacts.len(), 2, "frame {index}");
            assert!(found.contacts.iter().all(|c| c.phase == Phase::Held));
            for (contact, force) in found.contacts.iter().zip(forces) {
                worst = worst.max((contact.contact.force_n / force - 1.0).abs());
            }
        }
    }
    assert!(worst < 1e-3, "forces off by {worst:.1e}");
}

#[test]
fn a_slide_is_followed() {
    let mut n_good = 0;
    for seed in 0..8 {
        let world = World::new(10, 600, 40 + seed);
        let mut tracker = tracker(&world, 0.0, TrackerParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let points = world.draw_points(2, 0.03, &mut rng);
        let skin = world.map.skin();
        let along = skin.tangents(&points[1])[0] * 0.02;
        let mut names = Vec::new();
        let mut contacts = Vec::new();
        for index in 0..1100 {
            // 40 mm/s
            let share = (index as f64 - 500.0).clamp(0.0, 500.0) / 500.0;
            let place = skin.walk(&points[1], &(along * share), AtWall::Slide).point;
            contacts = vec![(points[0], ramp(index, 20, 12.0)), (place, ramp(index, 250, 20.0))];
            contacts.retain(|c| c.1 > 0.0);
            let y = frame(&world, &contacts, SD, &mut rng);
            let found = tracker.step(&y, None).unwrap();
            if index == 450 {
                names = found.contacts.iter().map(|c| c.id).collect();
            }
        }
        let last = tracker.last();
        let is_named = last.contacts.iter().map(|c| c.id).eq(names);
        n_good += usize::from(is_named && worst_m(&world, &contacts, last) < 1e-3);
    }
    assert!(n_good >= 7, "{n_good} of 8 slides");
}

/// A third contact comes while one of two slides: it is found where it is 20 frames after its force has come,
/// and nothing is ever stronger than what presses, but for the first frames' share.
#[test]
fn a_press_beside_a_sliding_contact_is_no_phantom() {
    let mut n_good = 0;
    for seed in 0..8 {
        let world = World::new(10, 600, 40 + seed);
        let mut tracker = tracker(&world, 0.0, TrackerParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let points = world.draw_points(3, 0.03, &mut rng);
        let skin = world.map.skin();
        let along = skin.tangents(&points[1])[0] * 0.02;
        let mut is_good = true;
        for index in 0..900 {
            let share = (index as f64 - 500.0).clamp(0.0, 500.0) / 500.0;
            let place = skin.walk(&points[1], &(along * share), AtWall::Slide).point;
            let forces = [ramp(index, 20, 12.0), ramp(index, 250, 20.0), ramp(index, 700, 14.0)];
            let places = [points[0], place, points[2]];
            let contacts: Vec<_> = places.into_iter().zip(forces).filter(|c| c.1 > 0.0).collect();
            let found = tracker.step(&frame(&world, &contacts, SD, &mut rng), None).unwrap();
            let strongest = found.contacts.iter().map(|c| c.contact.force_n).fold(0.0, f64::max);
            is_good &= strongest < 40.0;
            is_good &= index < 750 || worst_m(&world, &contacts, found) < 5e-3;
        }
        n_good += usize::from(is_good);
    }
    assert!(n_good >= 7, "{n_good} of 8 presses");
}

/// While a force grows by kilonewtons a frame two contacts beside each other may explain it better than
/// one whose place is not exact yet.
#[test]
fn one_place_is_never_surely_two_contacts() {
    for seed in 0..40 {
        let world = World::new(10, 400, 100 + seed);
        let mut tracker = tracker(&world, 0.0, TrackerParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let point = world.draw_points(1, 0.0, &mut rng)[0];
        for index in 0..300 {
            let y = frame(&world, &[(point, ramp(index, 20, 1e5))], SD, &mut rng);
            let found = tracker.step(&y, None).unwrap();
            let is_sure = found.verdict == Verdict::Identified;
            let n = found.contacts.len();
            assert!(!is_sure || n == 1, "seed {seed}, frame {index}: {n} contacts");
        }
    }
}

/// Dead gauges and readings that are not finite are left out, and too few gauges are refused
/// without a trace.
#[test]
fn gauges_come_and_go() {
    let world = World::new(10, 400, 9);
    let mut tracker = tracker(&world, 0.014, TrackerParams::default());
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let point = world.draw_points(1, 0.0, &mut rng)[0];
    let mut live = vec![true; 10];
    for index in 0..600 {
        let contacts = [(point, ramp(index, 50, 18.0))];
        let mut y = frame(&world, &contacts, SD, &mut rng);
        live[4] = index < 200;
        y[7] = if (150..300).contains(&index) { f64::NAN } else { y[7] };
        y[4] = if live[4] { y[4] } else { 1e9 };
        let found = tracker.step(&y, Some(&live)).unwrap();
        assert!(found.residual.iter().all(|r| r.is_finite()));
        assert_eq!(found.residual[4] == 0.0, !live[4]);
        if index > 100 {
            assert!(worst_m(&world, &contacts, found) < 3e-3, "frame {index}");
        }
    }
    let before = tracker.last().clone();
    let refused = tracker.step(&[f64::NAN; 10], None).unwrap_err();
    assert_eq!(refused, InverseError::TooFewGauges { n_live: 0, needed: 3 });
    assert!(tracker.step(&[0.0; 9], None).is_err());
    assert_eq!(&before, tracker.last());
}

/// Whatever the readings, a frame's work stays within its budget and nothing becomes NaN.
#[test]
fn work_is_bounded_whatever_comes() {
    let world = World::new(10, 300, 7);
    let params = TrackerParams::default();
    for relative in [0.0, 0.014] {
        let mut tracker = tracker(&world, relative, params);
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let mut size = 1.0;
        for index in 0..6000 {
            if index % 97 == 0 {
                size = 10_f64.powf(rng.random_range(-3.0..9.0));
            }
            let mut y = vec![0.0; 10];
            world::add_noise(&mut y, size, &mut rng);
            let found = tracker.step(&y, None).unwrap();
            let info = &found.info;
            let steps = info.n_trials + info.n_pair_rows + 8 * info.n_scans;
            assert!(steps <= params.steps_per_frame, "frame {index}: {info:?}");
            for c in &found.contacts {
                let c = &c.contact;
                assert!(c.force_n.is_finite() && c.force_n >= 0.0, "frame {index}: {c:?}");
                assert!(c.position_m.iter().all(|x| x.is_finite()), "frame {index}");
            }
            assert!(found.contacts.len() <= params.max_contacts);
        }
    }
}

/// Three contacts that are there when the tracker starts: a full search is asked for and adopted.
#[test]
fn a_full_search_is_adopted() {
    let world = World::new(12, 600, 12);
    let noise = NoiseParams::uniform(12, SD);
    let estimator = world.estimator(noise, EstimatorParams::default());
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let points = world.draw_points(3, 0.03, &mut rng);
    let contacts: Vec<_> = points.iter().map(|p| (*p, 15.0)).collect();
    let mut tracker = ContactTracker::new(&estimator, TrackerParams::default()).unwrap();
    let searcher = || Searcher::for_tracker(estimator.clone(), TrackerParams::default()).unwrap();
    let mut background = BackgroundSearch::start(searcher()).unwrap();
    let mut here = searcher();
    let mut is_asked = false;
    for _ in 0..600 {
        let y = frame(&world, &contacts, SD, &mut rng);
        tracker.step(&y, None).unwrap();
        let Some(request) = tracker.wanted_search() else {
            continue;
        };
        is_asked = true;
        let mut outcome = SearchOutcome::default();
        here.search(&request, &mut outcome).unwrap();
        assert!(background.submit(&request) && !background.submit(&request));
        let mut same = None;
        while !background.poll(|found| same = Some(found.clone())).unwrap() {
            std::thread::yield_now();
        }
        assert_eq!(same.as_ref(), Some(&outcome));
        let is_adopted = tracker.adopt(&outcome);
        let y = frame(&world, &contacts, SD, &mut rng);
        assert_eq!(tracker.step(&y, None).unwrap().info.is_adopted, is_adopted);
    }
    let found = tracker.last();
    assert!(is_asked && worst_m(&world, &contacts, found) < 1e-3, "{found:?}");
    assert_eq!(found.verdict, Verdict::Identified);
}

/// The same frames give the same answers, in whatever thread.
#[test]
fn trackers_in_two_threads_agree() {
    let world = World::new(10, 400, 14);
    let play = || {
        let mut tracker = tracker(&world, 0.014, TrackerParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let points = world.draw_points(3, 0.02, &mut rng);
        let mut frames = Vec::new();
        for index in 0..700 {
            let contacts: Vec<_> =
                (0..3).map(|i| (points[i], ramp(index, 30 + 180 * i, 14.0))).collect();
            let y = frame(&world, &contacts, SD, &mut rng);
            frames.push(tracker.step(&y, None).unwrap().clone());
        }
        frames
    };
    let alone = play();
    let (first, second) = std::thread::scope(|scope| {
        let both = [scope.spawn(play), scope.spawn(play)];
        let [a, b] = both.map(|thread| thread.join().unwrap());
        (a, b)
    });
    assert_eq!(alone, first);
    assert_eq!(alone, second);
}
