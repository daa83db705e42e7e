//! What every reader keeps of the time: frames per second, and what was said of a device's clock.

use super::LinkState;
use crate::Message;
use crate::clock::{ClockFault, ClockMap};

/// A clock that is still wrong is named again after so long, and one that jumps all the time as often.
const CLOCK_PAUSE_NS: u64 = 10_000_000_000;

/// Counts frames per second.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rate {
    /// Time, ns, and count of frames when it was last computed.
    since: Option<(u64, u64)>,
}

/// What was said of a device's clock, and when, ns.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ClockWords {
    said: Option<(ClockFault, u64)>,
}

impl Rate {
    /// Frames per second since it was last computed, where that is a second ago; `n` have come so far.
    pub(crate) fn count(&mut self, n: u64, now_ns: u64) -> Option<f64> {
        let (since_ns, n_before) = *self.since.get_or_insert((now_ns, n));
        let passed_ns = now_ns.saturating_sub(since_ns);
        if passed_ns < 1_000_000_000 {
            return None;
        }
        self.since = Some((now_ns, n));
        Some((n - n_before) as f64 * 1e9 / passed_ns as f64)
    }
}

impl ClockWords {
    /// Says what is wrong with the clock of the last packet, now and then.
    pub(crate) fn complain(&mut self, map: &ClockMap, now_ns: u64, sink: &mut dyn FnMut(Message)) {
        let Some(fault) = map.fault().filter(|f| *f != ClockFault::Stuck || map.is_stuck()) else {
            return;
        };
        let is_said = self.said.is_some_and(|(before, at_ns)| {
            let pause_ns = if before == fault { CLOCK_PAUSE_NS } else { CLOCK_PAUSE_NS / 10 };
            now_ns.saturating_sub(at_ns) < pause_ns
        });
        if !is_said {
            self.said = Some((fault, now_ns));
            sink(Message::Link(LinkState::Clock(fault)));
        }
    }
}
