//! A link and a protocol make a source: opening, reconnecting, decoding, mapping the clock.

use std::sync::Arc;
use std::time::Duration;

use super::session::{READ_LEN, REOPEN_NS, Session};
use super::{FrameSource, Link, LinkFault, LinkState, Protocol, SourceStats, SourceStatus};
use crate::Message;
use crate::clock::{HostClock, SystemClock};

/// How a link is read.
#[derive(Clone)]
pub struct StreamParams {
    /// What the bytes mean.
    pub protocol: Protocol,
    /// The host's clocks.
    pub clock: Arc<dyn HostClock>,
}

/// Frames from a link of bytes. It opens the link, opens it again when it went away, and says what
/// happens.
pub struct StreamSource<L> {
    link: L,
    clock: Arc<dyn HostClock>,
    session: Session,
    buffer: Vec<u8>,
    is_open: bool,
    last_fault: Option<LinkFault>,
    reopen_ns: u64,
}

impl Default for StreamParams {
    fn default() -> Self {
        Self { protocol: Protocol::Hdp1, clock: Arc::new(SystemClock) }
    }
}

impl<L: Link> StreamSource<L> {
    /// A source from a link; the link is opened at the first poll.
    #[must_use]
    pub fn new(link: L, params: StreamParams) -> Self {
        Self {
            link,
            clock: params.clock,
            session: Session::new(params.protocol),
            buffer: vec![0; READ_LEN],
            is_open: false,
            last_fault: None,
            reopen_ns: 0,
        }
    }

    fn try_open(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        let now_ns = self.clock.now_ns();
        if now_ns < self.reopen_ns {
            let wait = Duration::from_nanos(self.reopen_ns - now_ns);
            std::thread::sleep(wait.min(timeout));
            return SourceStatus::Open;
        }
        self.reopen_ns = now_ns + REOPEN_NS;
        match self.link.open() {
            Ok(()) => {
                self.is_open = true;
                self.last_fault = None;
                let words = self.session.opened(now_ns, sink);
                self.say(&words, sink)
            }
            Err(fault) => self.away(fault, sink),
        }
    }

    /// The link is gone, or could not be opened.
    fn away(&mut self, fault: LinkFault, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        if self.is_open {
            self.link.close();
            self.is_open = false;
            self.session.closed();
            self.reopen_ns = self.clock.now_ns() + REOPEN_NS;
        }
        let status = match fault {
            LinkFault::Ended { .. } => SourceStatus::Ended,
            _ => SourceStatus::Open,
        };
        if self.last_fault.as_ref() != Some(&fault) {
            self.last_fault = Some(fault.clone());
            sink(Message::Link(LinkState::Away(fault)));
        }
        status
    }

    fn say(&mut self, bytes: &[u8], sink: &mut dyn FnMut(Message)) -> SourceStatus {
        if bytes.is_empty() {
            return SourceStatus::Open;
        }
        match self.link.write(bytes) {
            Ok(()) => SourceStatus::Open,
            Err(fault) => self.away(fault, sink),
        }
    }
}

impl<L: Link> FrameSource for StreamSource<L> {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        if !self.is_open {
            return self.try_open(timeout, sink);
        }
        match self.link.read(&mut self.buffer, timeout) {
            Ok(n) => {
                let now_ns = self.clock.now_ns();
                let words = self.session.took(&self.buffer[..n], now_ns, sink);
                self.say(&words, sink)
            }
            Err(fault) => self.away(fault, sink),
        }
    }

    fn stats(&self) -> SourceStats {
        self.session.stats()
    }

    fn name(&self) -> String {
        self.link.name()
    }
}
