//! A link and a protocol make a source: opening, reconnecting, decoding, mapping the clock.

use std::sync::Arc;
use std::time::Duration;

use super::{FrameSource, Link, LinkFault, LinkState, SourceStats, SourceStatus};
use crate::clock::{ClockMap, HostClock, SystemClock};
use crate::csv_line::CsvDecoder;
use crate::hdp1::{Command, Data, Decoder, Encoder, Event, Hello, Rejected, SampleFormat};
use crate::{Frame, Message};

/// Time from one attempt to open a link to the next.
const REOPEN_NS: u64 = 100_000_000;
const PING_NS: u64 = 1_000_000_000;
/// After that long without anything understood, the source says so.
const PATIENCE_NS: u64 = 2_000_000_000;
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

/// Bytes to messages.
struct Reader {
    decoding: Decoding,
    map: ClockMap,
    hello: Option<Arc<Hello>>,
    version: Option<Rejected>,
    /// Time and count of frames when the rate was last computed.
    rate_since: Option<(u64, u64)>,
    stats: SourceStats,
}

enum Decoding {
    Hdp1(Decoder),
    Csv { decoder: CsvDecoder, hello: Hello },
}

/// Notices that nothing comes, or nothing that is understood.
#[derive(Default)]
struct Watch {
    since_ns: u64,
    n_good: u64,
    n_bytes: u64,
    n_text: u64,
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
        if matches!(self.reader.decoding, Decoding::Csv { .. }) {
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

impl Reader {
    fn new(protocol: Protocol) -> Self {
        Self {
            decoding: match protocol {
                Protocol::Hdp1 => Decoding::Hdp1(Decoder::new()),
                Protocol::Csv { n_channels } => Decoding::Csv {
                    decoder: CsvDecoder::new(n_channels),
                    hello: Hello::plain(n_channels, SampleFormat::U16, 0),
                },
            },
            map: ClockMap::new(),
            hello: None,
            version: None,
            rate_since: None,
            stats: SourceStats::default(),
        }
    }

    fn link_closed(&mut self) {
        match &mut self.decoding {
            Decoding::Hdp1(decoder) => decoder.link_closed(),
            Decoding::Csv { decoder, .. } => decoder.link_closed(),
        }
    }

    fn take(&mut self, bytes: &[u8], now_ns: u64, sink: &mut dyn FnMut(Message)) {
        let (map, stats) = (&mut self.map, &mut self.stats);
        match &mut self.decoding {
            Decoding::Hdp1(decoder) => decoder.push(bytes, &mut |event| match event {
                Event::Data(data) => stats.n_frames += frames(&data, map, now_ns, sink),
                Event::Hello {
                    hello,
                    is_new,
                    restarted,
                } => {
                    if restarted {
                        map.restart();
                        sink(Message::Restarted);
                    }
                    if is_new {
                        let hello = Arc::new(hello.clone());
                        self.hello = Some(Arc::clone(&hello));
                        sink(Message::Hello(hello));
                    }
                }
                Event::Restarted => {
                    map.restart();
                    sink(Message::Restarted);
                }
                Event::Status(status) => sink(Message::Status(status)),
                Event::Pong(pong) => {
                    stats.round_trip_ns = now_ns.saturating_sub(pong.host_ns);
                    sink(Message::RoundTrip(stats.round_trip_ns));
                }
                Event::Log(text) => sink(Message::Log(String::from_utf8_lossy(text).into())),
                Event::Rejected(reason @ Rejected::Version { .. }) => self.version = Some(reason),
                Event::Command(_) | Event::Rejected(_) => {}
            }),
            Decoding::Csv { decoder, hello } => {
                let n_before = decoder.counts();
                let mut seq = (n_before.n_lines + n_before.n_refused) as u32;
                decoder.push(bytes, &mut |values| {
                    if self.hello.is_none() {
                        let hello = Arc::new(hello.clone());
                        self.hello = Some(Arc::clone(&hello));
                        sink(Message::Hello(hello));
                    }
                    let mut frame = Frame::new(seq, SampleFormat::U16, values.iter().copied());
                    (frame.t_device_us, frame.t_host_ns) = (now_ns / 1000, now_ns);
                    seq = seq.wrapping_add(1);
                    stats.n_frames += 1;
                    sink(Message::Frame(frame));
                });
            }
        }
        self.count_rate(now_ns);
    }

    fn count_rate(&mut self, now_ns: u64) {
        let n = self.stats.n_frames;
        let (since_ns, n_before) = *self.rate_since.get_or_insert((now_ns, n));
        let passed_ns = now_ns.saturating_sub(since_ns);
        if passed_ns >= 1_000_000_000 {
            self.stats.rate_hz = (n - n_before) as f64 * 1e9 / passed_ns as f64;
            self.rate_since = Some((now_ns, n));
        }
    }

    fn stats(&self) -> SourceStats {
        let mut stats = self.stats;
        stats.drift_ppm = self.map.drift_ppm().unwrap_or(0.0);
        match &self.decoding {
            Decoding::Hdp1(decoder) => {
                (stats.losses, stats.rejected) = (decoder.losses(), decoder.rejected());
            }
            Decoding::Csv { decoder, .. } => {
                stats.lines = decoder.counts();
                stats.losses.n_delivered = stats.lines.n_lines;
            }
        }
        stats
    }
}

/// Hands out the scans of a packet: how many.
fn frames(data: &Data<'_>, map: &mut ClockMap, now_ns: u64, sink: &mut dyn FnMut(Message)) -> u64 {
    let n_scans = usize::from(data.hello.n_scans);
    for scan in 0..n_scans {
        let mut frame = Frame::new(data.header.seq, data.hello.format, data.bits(scan));
        frame.scan = u8::try_from(scan).unwrap_or(u8::MAX);
        frame.flags = data.header.flags;
        frame.n_lost_before = if scan == 0 { data.n_lost_before } else { 0 };
        frame.t_device_us = data.t_us(scan);
        frame.t_host_ns = map.map(frame.t_device_us, now_ns);
        sink(Message::Frame(frame));
    }
    n_scans as u64
}

impl Watch {
    fn from(now_ns: u64) -> Self {
        Self {
            since_ns: now_ns,
            ..Self::default()
        }
    }

    fn look(&mut self, bytes: &[u8], now_ns: u64, reader: &Reader, sink: &mut dyn FnMut(Message)) {
        let text = |b: &&u8| b.is_ascii_digit() || b",\r\n .-".contains(b);
        self.n_bytes += bytes.len() as u64;
        self.n_text += bytes.iter().filter(text).count() as u64;
        let n_good = reader.stats.n_frames;
        if n_good > self.n_good {
            *self = Self::from(now_ns);
            self.n_good = n_good;
        } else if now_ns.saturating_sub(self.since_ns) >= PATIENCE_NS {
            if let Some(state) = self.complaint(reader) {
                sink(Message::Link(state));
            }
            *self = Self::from(now_ns);
            self.n_good = n_good;
        }
    }

    fn complaint(&self, reader: &Reader) -> Option<LinkState> {
        if self.n_bytes == 0 {
            let for_s = PATIENCE_NS / 1_000_000_000;
            return Some(LinkState::Silent { for_s });
        }
        let is_text = self.n_text * 10 > self.n_bytes * 9;
        let remedy = match (&reader.decoding, reader.version) {
            (_, Some(version)) => version.to_string(),
            (Decoding::Hdp1(_), _) if is_text => {
                "they look like lines of numbers: read them as CSV".to_owned()
            }
            (Decoding::Hdp1(decoder), _) if decoder.hello().is_some() => return None,
            (Decoding::Hdp1(_), _) => "check the baud rate (115200 for a USB-serial chip, any for \
                                       native USB), and that the firmware speaks HDP1"
                .to_owned(),
            (Decoding::Csv { .. }, _) if is_text => {
                "they are lines of another number of integers: set the number of channels"
                    .to_owned()
            }
            (Decoding::Csv { .. }, _) => {
                "they are no text: check the baud rate (115200 for the sketch), or read HDP1"
                    .to_owned()
            }
        };
        Some(LinkState::NotUnderstood {
            n_bytes: self.n_bytes,
            remedy: remedy.into(),
        })
    }
}
