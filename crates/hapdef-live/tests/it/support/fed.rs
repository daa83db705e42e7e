//! A device that sends what it is given, and the time that it is.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hapdef_daq::Message;
use hapdef_daq::clock::HostClock;
use hapdef_daq::source::{FrameSource, SourceStats, SourceStatus};

/// Clones are the same clock. It counts how often it was looked at.
#[derive(Clone, Default)]
pub struct SetClock {
    now_ns: Arc<AtomicU64>,
    n_looks: Arc<AtomicU64>,
}

/// Clones are the same device.
#[derive(Clone, Default)]
pub struct Fed {
    messages: Arc<Mutex<VecDeque<Message>>>,
    has_ended: Arc<AtomicBool>,
}

impl SetClock {
    /// Moves it, and waits until the runtime, which looks at it twice each time it waits for a frame, has seen that.
    pub fn pass(&self, time: Duration) {
        self.now_ns.fetch_add(time.as_nanos() as u64, Ordering::AcqRel);
        let seen = self.n_looks.load(Ordering::Acquire) + 6;
        while self.n_looks.load(Ordering::Acquire) < seen {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl HostClock for SetClock {
    fn now_ns(&self) -> u64 {
        self.n_looks.fetch_add(1, Ordering::AcqRel);
        self.now_ns.load(Ordering::Acquire)
    }

    fn wall_ns(&self) -> u64 {
        self.now_ns()
    }
}

impl Fed {
    pub fn send(&self, messages: impl IntoIterator<Item = Message>) {
        self.messages.lock().unwrap().extend(messages);
    }

    pub fn end(&self) {
        self.has_ended.store(true, Ordering::Release);
    }
}

impl FrameSource for Fed {
    fn poll(&mut self, _: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        let has_ended = self.has_ended.load(Ordering::Acquire);
        let messages = std::mem::take(&mut *self.messages.lock().unwrap());
        if messages.is_empty() {
            std::thread::sleep(Duration::from_millis(1));
        }
        messages.into_iter().for_each(sink);
        if has_ended { SourceStatus::Ended } else { SourceStatus::Open }
    }

    fn stats(&self) -> SourceStats {
        SourceStats::default()
    }

    fn name(&self) -> String {
        "fed".to_owned()
    }
}
