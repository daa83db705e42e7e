//! Tares that something presses into: refused, or found out when it lets go.

use crate::support;

use std::time::Duration;

use hapdef_inverse::SkinPoint;
use hapdef_live::estimator::{SearchPlace, TouchEstimator};
use hapdef_live::{
    LiveFrame, Retare, TareFault, TareFaultKind, TareOutcome, Touch, TouchPhase, UnknownReason,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use support::played::{TARE, play};
use support::world::World;
use support::{N_GAUGES, bundle};

fn point(world: &World, seed: u64) -> SkinPoint {
    world.draw_points(1, 0.015, &mut ChaCha8Rng::seed_from_u64(seed))[0]
}

fn distance_m(world: &World, fault: &TareFault, point: &SkinPoint) -> f64 {
    (fault.contacts[0].position_m - world.map.skin().position(point)).norm()
}

/// 0 to 28 N during the tare, held, let go: refused with the contact until it is gone, and then the zero is that of
/// the untouched limb.
#[test]
fn a_press_that_grows_during_the_tare_is_refused() {
    let world = World::new(N_GAUGES, 400, 5);
    let point = point(&world, 1);
    let rise = |i: usize| match i {
        0..2000 => vec![(point, 28.0 * (i as f64 / TARE as f64).min(1.0))],
        _ => Vec::new(),
    };
    let played = play(&world, 4000, Retare::Ask, |i| (rise(i), Vec::new()));
    for fault in &played.faults {
        println!("{fault}");
    }
    let first = &played.faults[0];
    assert!(matches!(first.kind, TareFaultKind::Moved { .. }), "{first}");
    assert_eq!((first.outcome, first.contacts.len()), (TareOutcome::Again, 1), "{first}");
    assert!(distance_m(&world, first, &point) < 0.01, "{first}");
    assert!((first.contacts[0].force_n - 24.5).abs() < 3.0, "{first}");
    let held = &played.faults[1];
    assert_eq!((held.kind, held.outcome), (TareFaultKind::Pressed, TareOutcome::Again));
    assert!((held.contacts[0].force_n - 26.0).abs() < 3.0, "{held}");
    let invalid = TouchPhase::Unknown(UnknownReason::TareInvalid);
    assert!(
        played.frames[TARE..2000].iter().all(|f| f.phase == invalid && f.touch.contacts.is_empty())
    );
    assert_eq!(played.n_tared, 1);
    let end = played.frames.last().unwrap();
    assert_eq!(end.phase, TouchPhase::Untouched, "{}", played.health);
    assert!(end.touch.contacts.is_empty() && played.health.tare_fault.is_none());
}

/// A steady press in the tare, let go later: said with its contact, and put right where that is wanted.
#[test]
fn a_press_that_was_tared_is_found_out_when_it_lets_go() {
    let world = World::new(N_GAUGES, 400, 5);
    for (retare, seed) in
        [(Retare::Ask, 1), (Retare::Auto, 1), (Retare::Auto, 2), (Retare::Auto, 3)]
    {
        let point = point(&world, seed);
        let held = |i: usize| match i {
            0..1000 => vec![(point, 10.0)],
            1000..1040 => vec![(point, 10.0 - (i - 1000) as f64 / 4.0)],
            2500.. => vec![(point, 8.0)],
            _ => Vec::new(),
        };
        let played = play(&world, 3000, retare, |i| (held(i), Vec::new()));
        let [fault] = &played.faults[..] else { panic!("{retare:?} {seed}: {:?}", played.faults) };
        println!("{fault}");
        assert_eq!(fault.kind, TareFaultKind::PressedUnseen);
        assert!(distance_m(&world, fault, &point) < 0.01, "{fault}");
        assert!((fault.contacts[0].force_n - 10.0).abs() < 1.5, "{fault}");
        let (settled, end) = (&played.frames[1400..2500], &played.frames[2999]);
        if retare == Retare::Ask {
            let invalid = TouchPhase::Unknown(UnknownReason::TareInvalid);
            assert!(settled.iter().all(|f| f.phase == invalid && f.touch.contacts.is_empty()));
        } else {
            assert!(settled.iter().all(|f| f.phase == TouchPhase::Untouched));
            assert_eq!(end.phase, TouchPhase::Touched);
            let [contact] = &end.touch.contacts[..] else { panic!("{:?}", end.touch) };
            assert!((contact.force_n - 8.0).abs() < 1.0, "{contact:?}");
        }
    }
}

/// One press and then two are not taken for a release, wherever they are.
#[test]
fn an_honest_press_is_no_release() {
    let world = World::new(N_GAUGES, 400, 5);
    for seed in 0..6 {
        let points = [point(&world, seed), point(&world, 100 + seed)];
        let presses = |i: usize| match i {
            0..800 => Vec::new(),
            800..1600 => vec![(points[0], 15.0)],
            _ => points.map(|point| (point, 12.0)).to_vec(),
        };
        let played = play(&world, 2400, Retare::Ask, |i| (presses(i), Vec::new()));
        assert!(played.faults.is_empty(), "{seed}: {}", played.faults[0]);
        assert!(played.frames[900..].iter().all(|f| f.phase != TouchPhase::Untouched));
    }
}

/// Whatever drifts up to the limit is no contact, before, after and beside a press, which is read as it is.
#[test]
fn drift_is_no_contact() {
    let world = World::new(N_GAUGES, 400, 5);
    for seed in 0..8 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let rates: Vec<f64> = (0..N_GAUGES).map(|_| rng.random_range(-1.0..1.0)).collect();
        let from: usize = rng.random_range(0..5000);
        let point = point(&world, seed);
        let drift = |i: usize| -> Vec<f64> {
            rates.iter().map(|rate| rate * i.saturating_sub(from) as f64 * 1e-3).collect()
        };
        let press = |i: usize| {
            if (10_000..12_000).contains(&i) { vec![(point, 10.0)] } else { Vec::new() }
        };
        let played = play(&world, 14_000, Retare::Ask, |i| (press(i), drift(i)));
        assert!(played.faults.is_empty(), "{seed}: {:?}", played.faults);
        let n_false = |frames: &[LiveFrame]| {
            let is_false = |f: &&LiveFrame| f.touch.contacts.iter().any(|c| c.force_n > 0.3);
            frames.iter().filter(is_false).count()
        };
        let (before, after) = (&played.frames[..10_000], &played.frames[12_500..]);
        assert_eq!([n_false(before), n_false(after)], [0, 0], "{seed}, from {from}: {rates:?}");
        let [contact] = &played.frames[11_500].touch.contacts[..] else { panic!("{seed}") };
        assert!((contact.force_n - 10.0).abs() < 0.6, "{seed}: {contact:?}");
    }
}

/// No frame waits for it, and a replay has it in the same frame as a stream.
#[test]
fn what_explains_readings_comes_in_the_same_frame_wherever_it_is_found() {
    let world = World::new(N_GAUGES, 400, 5);
    let bundle = bundle(&world);
    let points = world.draw_points(2, 0.03, &mut ChaCha8Rng::seed_from_u64(4));
    let readings = world.readings(&[(points[0], 12.0), (points[1], 18.0)]);
    let answer = |place: SearchPlace| {
        let mut tracking = bundle.tracking(place).unwrap();
        tracking.set_frame_period(1e-3).unwrap();
        let mut touch = Touch::default();
        assert_eq!(tracking.begin_to_explain(&readings, None).unwrap(), None);
        let later = (1..=1000).find_map(|n_frames| {
            if place == SearchPlace::Background {
                std::thread::sleep(Duration::from_millis(10));
            }
            tracking.estimate(&readings, &mut touch).unwrap();
            tracking.explained().map(|found| (n_frames, found))
        });
        assert_eq!(tracking.explained(), None);
        let (n_frames, found) = later.unwrap();
        assert_eq!(tracking.explain(&readings, None).unwrap().unwrap(), found);
        n_frames
    };
    assert_eq!([SearchPlace::Here, SearchPlace::Background].map(answer), [80, 80]);
}
