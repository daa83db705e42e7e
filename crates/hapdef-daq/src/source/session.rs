//! What is said and understood on a link while it is open and after; no bytes are moved here.

use super::reader::Reader;
use super::watch::Watch;
use super::{LinkState, Protocol, SourceStats};
use crate::Message;
use crate::hdp1::{Command, Encoder};

/// Time from one attempt to open a link to the next: frames have to be back within 1 s of a replug,
/// and waiting may take no more than 5 % of a core.
pub(crate) const REOPEN_NS: u64 = 100_000_000;
/// Bytes read at a time.
pub(crate) const READ_LEN: usize = 1 << 14;
const PING_NS: u64 = 1_000_000_000;

/// The host's side of a conversation with a device.
pub(crate) struct Session {
    reader: Reader,
    watch: Watch,
    ping_ns: u64,
    n_bytes: u64,
    n_opened: u64,
}

impl Session {
    pub(crate) fn new(protocol: Protocol) -> Self {
        Self {
            reader: Reader::new(protocol),
            watch: Watch::default(),
            ping_ns: 0,
            n_bytes: 0,
            n_opened: 0,
        }
    }

    /// The link has been opened: what to send.
    pub(crate) fn opened(&mut self, now_ns: u64, sink: &mut dyn FnMut(Message)) -> Vec<u8> {
        self.n_opened += 1;
        self.ping_ns = now_ns + PING_NS;
        self.watch = Watch::from(now_ns);
        sink(Message::Link(LinkState::Open));
        self.said(&[Command::GetHello, Command::Start])
    }

    /// Bytes have come, or none for a while: what to send then, mostly nothing.
    pub(crate) fn took(
        &mut self,
        bytes: &[u8],
        now_ns: u64,
        sink: &mut dyn FnMut(Message),
    ) -> Vec<u8> {
        self.n_bytes += bytes.len() as u64;
        self.reader.take(bytes, now_ns, sink);
        self.watch.look(bytes, now_ns, &mut self.reader, sink);
        if now_ns < self.ping_ns {
            return Vec::new();
        }
        self.ping_ns = now_ns + PING_NS;
        self.said(&[Command::Ping { host_ns: now_ns }])
    }

    /// The link was closed.
    pub(crate) fn closed(&mut self) {
        self.reader.link_closed();
    }

    pub(crate) fn stats(&self) -> SourceStats {
        SourceStats { n_bytes: self.n_bytes, n_opened: self.n_opened, ..self.reader.stats() }
    }

    fn said(&self, commands: &[Command]) -> Vec<u8> {
        if !self.reader.has_commands() {
            return Vec::new();
        }
        let mut bytes = vec![0];
        for &command in commands {
            Encoder::new().command(command, &mut bytes);
        }
        bytes
    }
}
