//! Where the computing thread puts what it has found.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::error::AnyError;
use crate::frame::LiveFrame;
use crate::health::SinkHealth;
use crate::sink::{LiveEvent, Sink, Wants};

/// A sink, seen from where frames are computed.
pub(super) trait Outlet: Send {
    /// Hands a frame over; waits for nobody unless the runtime is lossless and does not `stop`.
    fn frame(&mut self, frame: &LiveFrame, stop: &AtomicBool);

    /// Hands an event over.
    fn event(&mut self, event: &LiveEvent);

    /// There will be no more.
    fn end(&mut self);

    /// How it is doing.
    fn health(&self) -> SinkHealth;
}

/// A sink that is called where frames are computed, without clocks of the machine.
pub(super) struct CalledSink {
    sink: Box<dyn Sink>,
    wants: Wants,
    health: SinkHealth,
}

impl CalledSink {
    pub(super) fn new(sink: Box<dyn Sink>) -> Self {
        let health = SinkHealth { name: sink.name(), ..SinkHealth::default() };
        Self { wants: sink.wants(), sink, health }
    }

    /// One that failed is not called again.
    fn is_open(&self) -> bool {
        self.health.failure.is_none()
    }

    fn keep(&mut self, done: Result<(), AnyError>) {
        if let Err(error) = done {
            self.health.failure = Some(Arc::from(error.to_string()));
        }
    }
}

impl Outlet for CalledSink {
    fn frame(&mut self, frame: &LiveFrame, _stop: &AtomicBool) {
        if self.is_open() {
            self.health.n_frames += 1;
            let done = self.sink.frame(frame);
            self.keep(done);
        }
    }

    fn event(&mut self, event: &LiveEvent) {
        let is_wanted = self.wants.health || !matches!(event, LiveEvent::Health(_));
        if self.is_open() && is_wanted {
            let done = self.sink.event(event);
            self.keep(done);
        }
    }

    fn end(&mut self) {
        if self.is_open() {
            let done = self.sink.finish();
            self.keep(done);
        }
    }

    fn health(&self) -> SinkHealth {
        self.health.clone()
    }
}
