//! The newest frame of the runtime, for the page's thread.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hapdef_live::{AnyError, Health, LiveEvent, LiveFrame, Sink, Wants};
use hapdef_view::ViewPusher;

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
    pub(super) health: Option<Arc<Health>>,
}

impl Newest {
    fn take(&mut self, frame: &LiveFrame) {
        self.n_frames += 1;
        self.frame
            .get_or_insert_with(|| LiveFrame::new(frame.raw_ue.len()))
            .copy_from(frame);
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
            LiveEvent::Restarted if !self.is_recorded => {
                self.pusher.say("The device started anew");
            }
            LiveEvent::Health(health) => {
                lock(&self.shared.newest).health = Some(Arc::clone(health));
            }
            LiveEvent::Link(state) => self.pusher.say(&state.to_string()),
            _ => {}
        }
        Ok(())
    }
}
