//! A link and a protocol make a source: opening, reconnecting, decoding, mapping the clock.

use std::sync::Arc;
use std::time::Duration;

use super::reader::Reader;
use super::watch::Watch;
use super::{FrameSource, Link, LinkFault, LinkState, SourceStats, SourceStatus};
use crate::Message;
use crate::clock::{HostClock, SystemClock};
use crate::hdp1::{Command, Encoder};

/// Time from one attempt to open a link to the next.
const REOPEN_NS: u64 = 100_000_000;
const PING_NS: u64 = 1_000_000_000;
const READ_LEN: usize = 1 << 14;

/// What the bytes of a link mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// HDP1.
    Hdp1,
    /// Lines of that many integers, as the authors' sketch prints them (10).
    Csv {
        /// Integers in a line.
        n_channels: usize,
    },
}

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
    reader: Reader,
    buffer: Vec<u8>,
    is_open: bool,
    last_fault: Option<LinkFault>,
    reopen_ns: u64,
    ping_ns: u64,
    watch: Watch,
    stats: SourceStats,
}

impl Default for StreamParams {
    fn default() -> Self {
        Self {
            protocol: Protocol::Hdp1,
            clock: Arc::new(SystemClock),
        }
    }
}

impl<L: Link> StreamSource<L> {
    /// A source from a link; the link is opened at the first poll.
    #[must_use]
    pub fn new(link: L, params: StreamParams) -> Self {
        Self {
            link,
            clock: params.clock,
            reader: Reader::new(params.protocol),
            buffer: vec![0; READ_LEN],
            is_open: false,
            last_fault: None,
            reopen_ns: 0,
            ping_ns: 0,
            watch: Watch::default(),
            stats: SourceStats::default(),
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
                self.stats.n_opened += 1;
                self.ping_ns = now_ns + PING_NS;
                self.watch = Watch::from(now_ns);
                sink(Message::Link(LinkState::Open));
                self.say(&[Command::GetHello, Command::Start], sink)
            }
            Err(fault) => self.away(fault, sink),
        }
    }

    /// The link is gone, or could not be opened.
    fn away(&mut self, fault: LinkFault, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        if self.is_open {
            self.link.close();
            self.is_open = false;
            self.reader.link_closed();
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

    fn say(&mut self, commands: &[Command], sink: &mut dyn FnMut(Message)) -> SourceStatus {
        if !self.reader.has_commands() {
            return SourceStatus::Open;
        }
        let mut bytes = vec![0];
        for &command in commands {
            Encoder::new().command(command, &mut bytes);
        }
        match self.link.write(&bytes) {
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
                let bytes = &self.buffer[..n];
                self.stats.n_bytes += n as u64;
                self.reader.take(bytes, now_ns, sink);
                self.watch.look(bytes, now_ns, &self.reader, sink);
                if now_ns < self.ping_ns {
                    return SourceStatus::Open;
                }
                self.ping_ns = now_ns + PING_NS;
                self.say(&[Command::Ping { host_ns: now_ns }], sink)
            }
            Err(fault) => self.away(fault, sink),
        }
    }

    fn stats(&self) -> SourceStats {
        SourceStats {
            n_bytes: self.stats.n_bytes,
            n_opened: self.stats.n_opened,
            ..self.reader.stats()
        }
    }

    fn name(&self) -> String {
        self.link.name()
    }
}
