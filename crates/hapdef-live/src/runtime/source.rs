//! A source that may have to wait for whoever computes.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use hapdef_daq::Message;
use hapdef_daq::source::{FrameSource, SourceStats, SourceStatus};

use super::Shared;

/// Messages that a source hands out in one turn at most, roundly.
const A_TURN: usize = 1024;

/// How long a source waits for room.
const WAIT: Duration = Duration::from_micros(200);

/// Any source, which with [`InFlight`] never runs ahead by more than the ring holds.
pub(super) struct LiveSource {
    inner: Box<dyn FrameSource>,
    in_flight: Option<InFlight>,
}

/// Messages handed out and not yet taken.
pub(super) struct InFlight {
    shared: Arc<Shared>,
    n_handed: u64,
    most: u64,
}

impl InFlight {
    pub(super) fn new(shared: &Arc<Shared>, ring_len: usize) -> Self {
        Self {
            shared: Arc::clone(shared),
            n_handed: 0,
            most: (Self::ring_len(true, ring_len) - A_TURN) as u64,
        }
    }

    /// A ring that has room for a turn of the source.
    pub(super) fn ring_len(is_lossless: bool, wanted: usize) -> usize {
        wanted.max(if is_lossless { 2 * A_TURN } else { 1 })
    }

    fn is_full(&self) -> bool {
        let n_taken = self.shared.n_taken.load(Ordering::Acquire);
        self.n_handed.saturating_sub(n_taken) > self.most
    }
}

impl LiveSource {
    pub(super) fn new(inner: Box<dyn FrameSource>, in_flight: Option<InFlight>) -> Self {
        Self { inner, in_flight }
    }
}

impl FrameSource for LiveSource {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        let Some(in_flight) = &mut self.in_flight else {
            return self.inner.poll(timeout, sink);
        };
        if in_flight.is_full() {
            std::thread::sleep(WAIT.min(timeout));
            return SourceStatus::Open;
        }
        self.inner.poll(timeout, &mut |message| {
            in_flight.n_handed += 1;
            sink(message);
        })
    }

    fn stats(&self) -> SourceStats {
        self.inner.stats()
    }

    fn name(&self) -> String {
        self.inner.name()
    }
}
