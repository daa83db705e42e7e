//! What happens to plug and device at given times.

use super::faults::RigFault;

/// Time until something that failed is tried again, s.
const AGAIN_S: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event {
    Unplug,
    Replug,
    Reset,
}

/// Events to come, the next one last.
#[derive(Clone, Debug)]
pub(super) struct Events {
    left: Vec<(f64, Event)>,
}

impl Events {
    pub(super) fn new(faults: &[RigFault]) -> Self {
        let mut left = Vec::new();
        for fault in faults {
            match *fault {
                RigFault::Unplug { at_s, for_s } => {
                    left.push((at_s, Event::Unplug));
                    left.push((at_s + for_s, Event::Replug));
                }
                RigFault::Reset { at_s } => left.push((at_s, Event::Reset)),
                _ => {}
            }
        }
        let mut events = Self { left };
        events.sort();
        events
    }

    /// The next event that is due at `t_s`.
    pub(super) fn due(&mut self, t_s: f64) -> Option<Event> {
        let is_due = self.left.last().is_some_and(|(at_s, _)| *at_s <= t_s);
        is_due.then(|| self.left.pop()).flatten().map(|(_, event)| event)
    }

    /// Puts an event back, a little later than `t_s`.
    pub(super) fn again(&mut self, event: Event, t_s: f64) {
        self.left.push((t_s + AGAIN_S, event));
        self.sort();
    }

    fn sort(&mut self) {
        self.left.sort_by(|a, b| b.0.total_cmp(&a.0));
    }
}
