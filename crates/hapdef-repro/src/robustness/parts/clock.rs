//! Device time to host time: drift, jitter, jumps, counters that begin again.

use hapdef_bench::stats::{sorted, upper_quantile};
use hapdef_daq::clock::ClockMap;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::robustness::table::Trials;

/// Frames at 1 kHz, and those after which the map should have settled.
const N_FRAMES: u64 = 40_000;
const SETTLED: u64 = 25_000;

/// Least delay of a frame, ns.
const DELAY_NS: u64 = 200_000;

/// Host and device clocks.
#[derive(Clone, Copy)]
struct World {
    drift_ppm: f64,
    jitter_ns: u64,
    device_0_us: u64,
    /// Frame in which the device's clock jumps by so many µs.
    jump: (u64, i64),
}

const PLAIN: World =
    World { drift_ppm: 0.0, jitter_ns: 1_000_000, device_0_us: 0, jump: (u64::MAX, 0) };

pub(super) fn add(rows: &mut Trials<u64>) {
    let worlds: [(&str, World); 8] = [
        ("the device runs 500 ppm fast", World { drift_ppm: 500.0, ..PLAIN }),
        ("the device runs 500 ppm slow", World { drift_ppm: -500.0, ..PLAIN }),
        ("frames up to 20 ms late", World { jitter_ns: 20_000_000, ..PLAIN }),
        ("no jitter at all", World { jitter_ns: 0, ..PLAIN }),
        ("the device's time begins at 2⁶³ µs", World { device_0_us: 1 << 63, ..PLAIN }),
        ("the device's time passes 2⁶⁴ µs", World { device_0_us: u64::MAX - 9_000_000, ..PLAIN }),
        ("the device's time jumps an hour ahead", World { jump: (5000, 3_600_000_000), ..PLAIN }),
        ("the device's time jumps 3 s back", World { jump: (5000, -3_000_000), ..PLAIN }),
    ];
    for (extreme, world) in worlds {
        let error = ("µs from the true time of a frame, 99 %, once settled", 500.0);
        let order = ("frames whose time goes back", 0.0);
        rows.accurate(extreme, error, move |seed| Ok(world.measured(*seed).0));
        rows.accurate(extreme, order, move |seed| Ok(world.measured(*seed).1));
    }
}

impl World {
    /// 99 % quantile of the error, µs, and frames whose time goes back.
    fn measured(self, seed: u64) -> (f64, f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_add(5));
        let mut clock = ClockMap::new();
        let (mut errors, mut n_back, mut last_ns) = (Vec::new(), 0, 0);
        for i in 0..N_FRAMES {
            let true_ns = 1_000_000_000 + i * 1_000_000;
            let ticks = i as f64 * 1000.0 * (1.0 + self.drift_ppm * 1e-6);
            let mut device_us = self.device_0_us.wrapping_add(ticks.round() as u64);
            if i >= self.jump.0 {
                device_us = device_us.wrapping_add_signed(self.jump.1);
            }
            // most frames come soon, some late
            let late: f64 = rng.random_range(0.0..1.0);
            let arrival_ns = true_ns + DELAY_NS + (self.jitter_ns as f64 * late.powi(4)) as u64;
            let mapped_ns = clock.map(device_us, arrival_ns);
            n_back += u32::from(mapped_ns < last_ns);
            last_ns = mapped_ns;
            if i >= SETTLED {
                errors.push(mapped_ns.abs_diff(true_ns + DELAY_NS) as f64 * 1e-3);
            }
        }
        (upper_quantile(&sorted(errors), 0.99), f64::from(n_back))
    }
}
