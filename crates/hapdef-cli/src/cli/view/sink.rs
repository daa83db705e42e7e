//! The newest frame of the runtime, for the page's thread.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hapdef_daq::source::LinkState;
use hapdef_live::{AnyError, Health, LiveEvent, LiveFrame, PhaseStatus, Sink, TareOutcome, Wants};
use hapdef_view::{DeviceState, Ranges, ViewPusher};

use super::Shared;

/// Hands over the newest frame and says what happens.
pub(crate) struct ViewSink {
    pub(super) pusher: ViewPusher,
    pub(super) shared: Arc<Shared>,
    pub(super) is_recorded: bool,
}

/// The newest of what came.
#[derive(Default)]
pub(super) struct Newest {
    /// Frames so far.
    pub(super) n_frames: u64,
    pub(super) frame: Option<LiveFrame>,
    /// Of the frames that were not shown yet.
    pub(super) ranges: Ranges,
    /// What is known since no frame came any more.
    pub(super) silence: Option<PhaseStatus>,
    pub(super) health: Option<Arc<Health>>,
    pub(super) device: DeviceState,
    /// Frames may still come of a link that is closed, but they say nothing of the device now.
    is_closed: bool,
}

impl Newest {
    fn take(&mut self, frame: &LiveFrame) {
        if !self.is_closed {
            self.device.fault = None;
        }
        self.n_frames += 1;
        self.silence = None;
        self.ranges.take(&frame.tared_ue, &frame.touch.contacts);
        self.frame.get_or_insert_with(|| LiveFrame::new(frame.raw_ue.len())).copy_from(frame);
    }

    fn take_link(&mut self, state: &LinkState) {
        self.is_closed = matches!(state, LinkState::Away(_));
        // A link that is open again says nothing before its first frame does.
        if !matches!(state, LinkState::Open | LinkState::Damaged { .. } | LinkState::Clock(_)) {
            self.device.fault = Some(state.to_string());
        }
    }

    fn take_health(&mut self, health: &Arc<Health>) {
        if let Some(fault) = health.reader_fault.as_ref().or(health.device_fault.as_ref()) {
            self.device.fault = Some(fault.to_string());
        }
        self.health = Some(Arc::clone(health));
    }
}

pub(super) fn lock(newest: &Mutex<Newest>) -> MutexGuard<'_, Newest> {
    newest.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Sink for ViewSink {
    fn name(&self) -> String {
        "live page".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants::ALL
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        lock(&self.shared.newest).take(frame);
        Ok(())
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        match event {
            LiveEvent::Tared => {
                self.shared.is_tared.store(true, Ordering::Relaxed);
                self.pusher.say("Tared");
            }
            LiveEvent::TareFault(fault) => {
                // a tare that begins again needs the virtual hand away
                let is_over = fault.outcome != TareOutcome::Again;
                self.shared.is_tared.store(is_over, Ordering::Relaxed);
                self.pusher.say(&fault.to_string());
            }
            LiveEvent::Restarted if !self.is_recorded => {
                self.pusher.say("The device started anew");
            }
            LiveEvent::Hello(hello) => {
                lock(&self.shared.newest).device.is_simulated = hello.is_simulated();
            }
            LiveEvent::Phase(status) => lock(&self.shared.newest).silence = Some(*status),
            LiveEvent::Health(health) => lock(&self.shared.newest).take_health(health),
            LiveEvent::Link(state) => {
                lock(&self.shared.newest).take_link(state);
                self.pusher.say(&state.to_string());
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use hapdef_daq::source::LinkFault;

    use super::*;

    fn away() -> LinkState {
        LinkState::Away(LinkFault::Disconnected { name: "/dev/limb".to_owned() })
    }

    #[track_caller]
    fn is_told(newest: &Newest, words: Option<&str>) {
        let fault = newest.device.fault.as_deref();
        let is_as_expected = match (fault, words) {
            (Some(fault), Some(words)) => fault.contains(words),
            (fault, words) => fault == words,
        };
        assert!(is_as_expected, "{fault:?} for {words:?}");
    }

    #[test]
    fn a_device_is_away_until_its_first_frame_after_the_link_is_open() {
        let frame = LiveFrame::new(1);
        let mut newest = Newest::default();
        newest.take_link(&LinkState::Open);
        newest.take(&frame);
        is_told(&newest, None);
        newest.take_link(&away());
        is_told(&newest, Some("/dev/limb"));
        newest.take(&frame);
        is_told(&newest, Some("/dev/limb"));
        newest.take_link(&LinkState::Open);
        is_told(&newest, Some("/dev/limb"));
        newest.take(&frame);
        is_told(&newest, None);
    }

    #[test]
    fn a_device_that_says_nothing_usable_is_told_until_it_does() {
        let frame = LiveFrame::new(1);
        let mut newest = Newest::default();
        newest.take_link(&LinkState::Silent { for_s: 2 });
        is_told(&newest, Some("no bytes for 2 s"));
        newest.take(&frame);
        is_told(&newest, None);
        newest.take_health(&Arc::new(Health {
            device_fault: Some("expected 10 gauges".into()),
            ..Health::default()
        }));
        is_told(&newest, Some("expected 10 gauges"));
        newest.take(&frame);
        is_told(&newest, None);
    }
}
