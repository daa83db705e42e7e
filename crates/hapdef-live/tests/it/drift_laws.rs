//! Zeros that drift while it is pressed and let go, again and again.

use crate::support;

use hapdef_inverse::SkinPoint;
use hapdef_live::{LiveFrame, Retare, TouchPhase};
use proptest::prelude::*;
use support::N_GAUGES;
use support::laws::{config, drifted, points, rates};
use support::played::{TARE, play};
use support::world::World;

/// A contact of an untouched limb that is stronger is a false one, N.
const FALSE_N: f64 = 0.3;

/// Frames after which a press that has let go is no longer reported.
const SOON: usize = 200;

/// Frames in which a press comes, and goes.
const RISE: usize = 30;

/// A press: frames before it, frames that it lasts, force.
#[derive(Clone, Debug)]
struct Press {
    from: usize,
    to: usize,
    force_n: f64,
}

/// Up to four presses of up to 5 s, one after the other.
fn presses() -> impl Strategy<Value = Vec<Press>> {
    let one = (1000_usize..4000, 100_usize..5000, 3.0..25.0);
    prop::collection::vec(one, 1..5).prop_map(|all| {
        let mut end = TARE;
        let press = |(pause, lasts, force_n)| {
            let from = end + pause;
            end = from + lasts;
            Press { from, to: end, force_n }
        };
        all.into_iter().map(press).collect()
    })
}

impl Press {
    fn force_n(&self, index: usize) -> f64 {
        let share = |from: usize| (index.saturating_sub(from) as f64 / RISE as f64).min(1.0);
        self.force_n * (share(self.from) - share(self.to))
    }

    fn is_near(&self, index: usize) -> bool {
        (self.from..self.to + RISE + SOON).contains(&index)
    }
}

proptest! {
    #![proptest_config(config(32))]

    /// Whatever drifts by up to 1 µε/s, in any direction, is no contact while nothing touches, and nothing is said to
    /// be untouched while it is pressed.
    #[test]
    fn drift_is_no_contact_after_any_presses(
        rates in rates(1.0),
        from in 0_usize..1000,
        presses in presses(),
        seed in 0_u64..1000,
    ) {
        let world = World::new(N_GAUGES, 400, 5);
        let points = points(&world, presses.len(), seed);
        let n = presses.last().map_or(0, |press| press.to) + 3000;
        let touching = |index: usize| -> Vec<(SkinPoint, f64)> {
            let each = presses.iter().zip(&points);
            each.map(|(press, point)| (*point, press.force_n(index))).filter(|(_, n)| *n > 0.0).collect()
        };
        let signal = |index: usize| (touching(index), drifted(&rates, index.saturating_sub(from)));
        let played = play(&world, n, Retare::Ask, signal);
        prop_assert!(played.faults.is_empty(), "{}", played.faults[0]);
        let strongest_n =
            |frame: &LiveFrame| frame.touch.contacts.iter().map(|c| c.force_n).fold(0.0, f64::max);
        for (index, frame) in played.frames.iter().enumerate() {
            if !presses.iter().any(|press| press.is_near(index)) {
                let found_n = strongest_n(frame);
                prop_assert!(found_n <= FALSE_N, "{found_n} N in frame {index}: {:?}", frame.phase);
            }
            let is_held = presses.iter().any(|p| (p.from + 2 * RISE..p.to).contains(&index));
            prop_assert!(!is_held || frame.phase != TouchPhase::Untouched, "frame {index}");
        }
    }
}
