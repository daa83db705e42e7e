//! Whatever a device's clock does, the host's times go on.

use hapdef_daq::clock::{ClockFault, ClockMap};
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// How a clock goes on for a while.
#[derive(Clone, Copy, Debug)]
enum Going {
    /// Right but for its drift.
    Well { ppm: f64 },
    /// It stands still.
    Stuck,
    /// So many times the host's time.
    Rate { factor: f64 },
    /// Steps of so many µs.
    Coarse { step_us: u64 },
}

/// What is done to it before.
#[derive(Clone, Copy, Debug)]
enum Leap {
    None,
    By(i64),
    To(u64),
}

#[derive(Clone, Copy, Debug)]
struct Stretch {
    leap: Leap,
    going: Going,
    n_ms: u64,
}

fn stretch() -> impl Strategy<Value = Stretch> {
    let leap = prop_oneof![
        3 => Just(Leap::None),
        1 => prop_oneof![Just(20_000), Just(-20_000), Just(1_000_000), Just(-3_600_000_000)]
            .prop_map(Leap::By),
        1 => prop_oneof![Just(u64::MAX), Just(u64::MAX - 500_000), Just(0), any::<u64>()]
            .prop_map(Leap::To),
    ];
    let going = prop_oneof![
        3 => (-100.0..100.0).prop_map(|ppm| Going::Well { ppm }),
        1 => Just(Going::Stuck),
        1 => prop_oneof![Just(1e-3), Just(0.1), Just(10.0), Just(1e3)]
            .prop_map(|factor| Going::Rate { factor }),
        1 => (2_000..20_000u64).prop_map(|step_us| Going::Coarse { step_us }),
    ];
    (leap, going, 200..4000u64).prop_map(|(leap, going, n_ms)| Stretch { leap, going, n_ms })
}

/// Packets at 1 kHz with delays of 0.15 ms and an exponential part of 1 ms.
fn check(stretches: &[Stretch], seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut map = ClockMap::new();
    let (mut true_us, mut exact, mut last, mut arrival_ns) = (1e6, 5e6, 0, 0u64);
    let mut is_fresh = true;
    for (k, stretch) in stretches.iter().enumerate() {
        match stretch.leap {
            Leap::None => {}
            Leap::By(us) => exact += us as f64,
            Leap::To(us) => exact = us as f64,
        }
        let (mut sum_us, from_us) = (0.0, exact.max(0.0) as u64);
        let mut n_flagged = 0;
        for i in 0..stretch.n_ms {
            true_us += 1e3;
            sum_us += match stretch.going {
                Going::Well { ppm } => 1e3 * (1.0 + ppm * 1e-6),
                Going::Stuck => 0.0,
                Going::Rate { factor } => 1e3 * factor,
                Going::Coarse { .. } => 1e3,
            };
            let passed = match stretch.going {
                Going::Coarse { step_us } => sum_us as u64 / step_us * step_us,
                _ => sum_us as u64,
            };
            let device_us = match stretch.going {
                // A counter that ends at its end.
                Going::Stuck => from_us,
                _ => from_us.wrapping_add(passed),
            };
            let u = ((rng.next_u64() >> 11) as f64 + 0.5) * 0.5f64.powi(53);
            arrival_ns = arrival_ns.max(((true_us + 150.0 - 1e3 * u.ln()) * 1e3) as u64);
            let mapped = map.map(device_us, arrival_ns);
            let at = format!("packet {i} of stretch {k}, {stretch:?}");
            assert!(mapped >= last && mapped <= arrival_ns, "{mapped} ns after {last}: {at}");
            last = mapped;
            let age_ms = (arrival_ns - mapped) as f64 * 1e-6;
            // Up to four stretches of 0.3 s until a rate is not believed.
            assert!(age_ms < 1800.0, "{age_ms} ms old: {at}");
            n_flagged += u64::from(map.fault().is_some());
            match stretch.going {
                Going::Stuck if i > 0 => {
                    assert_eq!(map.fault().unwrap(), ClockFault::Stuck, "{at}");
                    assert_eq!(mapped, arrival_ns, "{at}");
                }
                Going::Well { .. } if i > 1200 => {
                    assert_eq!(map.fault().filter(|f| *f != ClockFault::Jumped), None, "{at}");
                }
                Going::Rate { factor } if i > 1200 && !(0.3..3.0).contains(&factor) => {
                    assert!(map.fault().is_some() && mapped == arrival_ns, "{at}");
                }
                _ => {}
            }
        }
        if is_fresh && matches!((stretch.leap, stretch.going), (_, Going::Well { .. })) {
            assert_eq!(n_flagged, 0, "{stretch:?}");
        }
        is_fresh = false;
        exact = from_us.wrapping_add(sum_us as u64) as f64;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn host_times_go_on_whatever_the_devices_clock_does(
        stretches in prop::collection::vec(stretch(), 1..6), seed in any::<u64>()
    ) {
        check(&stretches, seed);
    }

    #[test]
    fn no_hold_up_is_blamed_on_the_clock(
        turns in prop::collection::vec((0..4000u64, 0..4000u64), 1..12)
    ) {
        check_held_up(&turns);
    }
}

/// The case that was found: a clock that jumps to the end of its range and stays there.
#[test]
fn a_clock_at_the_end_of_its_range_stops_no_time() {
    let stretch = |leap, going, n_ms| Stretch { leap, going, n_ms };
    let well = Going::Well { ppm: 40.0 };
    for at_ms in [500, 5000] {
        check(
            &[
                stretch(Leap::None, well, at_ms),
                stretch(Leap::To(u64::MAX), Going::Stuck, 3000),
                stretch(Leap::To(7), well, 3000),
            ],
            1,
        );
    }
}

/// A program that was held up takes what waited for it at once: nothing is wrong with the clock. Turns of
/// (running, held up), ms.
fn check_held_up(turns: &[(u64, u64)]) {
    let mut map = ClockMap::new();
    let (mut true_ms, mut worst_ms) = (0, 0.0f64);
    for (run_ms, hold_ms) in turns {
        let back_ms = true_ms + run_ms + hold_ms;
        while true_ms < back_ms {
            let is_held = true_ms >= back_ms - hold_ms;
            let arrival_us = if is_held { back_ms * 1000 } else { true_ms * 1000 } + 200;
            let mapped = map.map(1_000_000 + true_ms * 1000, arrival_us * 1000);
            assert_eq!((map.fault(), map.n_jumps()), (None, 0), "at {true_ms} ms of {turns:?}");
            if true_ms > 10_000 {
                worst_ms = worst_ms.max((mapped as f64 * 1e-6 - true_ms as f64).abs());
            }
            true_ms += 1;
        }
    }
    assert!(worst_ms < 0.5, "{worst_ms} ms: {turns:?}");
}

#[test]
fn a_program_that_was_held_up_does_not_blame_the_clock() {
    // From the first packet on, before anything is known of the delays, and then with what is.
    for (run_ms, hold_ms) in [(0, 1500), (500, 1500), (2000, 3000), (5500, 1500), (5100, 1900)] {
        check_held_up(&[[(run_ms, hold_ms)].as_slice(), &[(7000 - 1500, 1500); 8]].concat());
    }
}
