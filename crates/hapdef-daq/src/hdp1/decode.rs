//! Bytes to packets.

use super::hello::Hello;
use super::payload::{Command, Pong, Status};
use super::reject::{Rejected, RejectedCounts};
use super::sequence::{LossCounts, Sequence};
use super::wire::{
    CRC_LEN, DATA, GET_HELLO, HEADER_LEN, HELLO, Header, LOG, MAJOR_VERSION, MAX_BODY_LEN,
    MAX_CODE_LEN, PONG, STATUS, STOP, crc32c, u32_at,
};

/// What the bytes said.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<'a> {
    /// Readings.
    Data(Data<'a>),
    /// What the device measures; comes again every second, mostly unchanged.
    Hello {
        /// What it says.
        hello: &'a Hello,
        /// True if it differs from the last one.
        is_new: bool,
        /// True if the device started anew since the last one, or is another one.
        restarted: bool,
    },
    /// The device started anew, seen by the flag of its first DATA packet.
    Restarted,
    /// How the device is doing.
    Status(Status),
    /// Answer to a PING.
    Pong(Pong),
    /// A line of text from the device, UTF-8 if the firmware is right.
    Log(&'a [u8]),
    /// A host's command, where this decoder is the device.
    Command(Command),
    /// A packet that was refused.
    Rejected(Rejected),
}

/// A DATA packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Data<'a> {
    /// Its header.
    pub header: Header,
    /// DATA packets missing directly before it.
    pub n_lost_before: u32,
    /// What describes it.
    pub hello: &'a Hello,
    payload: &'a [u8],
}

/// Decodes a stream of bytes in pieces of any size, in bounded memory; after damage it goes on at
/// the next 0x00.
#[derive(Clone, Debug)]
pub struct Decoder {
    code: Vec<u8>,
    body: Vec<u8>,
    overlong: usize,
    state: State,
}

#[derive(Clone, Debug, Default)]
struct State {
    hello: Option<Hello>,
    /// None after a restart that only a DATA packet reported.
    boot_id: Option<u32>,
    sequence: Sequence,
    rejected: RejectedCounts,
}

impl<'a> Data<'a> {
    /// Device time of a scan, µs.
    #[must_use]
    pub fn t_us(&self, scan: usize) -> u64 {
        let after = (scan as f64 * self.hello.scan_period_us()).round();
        self.header.t_us.wrapping_add(after as u64)
    }

    /// A scan's samples as 32 bits each: the integers, or the bits of the f32.
    ///
    /// # Panics
    /// If there is no such scan; there are `hello.n_scans`.
    pub fn bits(&self, scan: usize) -> impl Iterator<Item = i32> + 'a {
        let format = self.hello.format;
        let len = self.hello.channels.len() * format.n_bytes();
        self.payload[scan * len..][..len]
            .chunks_exact(format.n_bytes())
            .map(move |bytes| format.bits(bytes))
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder that knows no device yet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            code: Vec::with_capacity(MAX_CODE_LEN),
            body: vec![0; MAX_CODE_LEN],
            overlong: 0,
            state: State::default(),
        }
    }

    /// Takes bytes and hands out what they said, in order.
    pub fn push(&mut self, mut bytes: &[u8], sink: &mut impl FnMut(Event<'_>)) {
        while let Some(end) = bytes.iter().position(|b| *b == 0) {
            self.append(&bytes[..end]);
            self.end_of_packet(sink);
            bytes = &bytes[end + 1..];
        }
        self.append(bytes);
    }

    /// Forgets a packet that has begun, because the link was closed; what is known of the device
    /// stays, so that packets missing since are counted.
    pub fn link_closed(&mut self) {
        self.code.clear();
        self.overlong = 0;
    }

    /// The last HELLO.
    #[must_use]
    pub fn hello(&self) -> Option<&Hello> {
        self.state.hello.as_ref()
    }

    /// What became of the DATA packets.
    #[must_use]
    pub fn losses(&self) -> LossCounts {
        self.state.sequence.counts()
    }

    /// What was refused.
    #[must_use]
    pub fn rejected(&self) -> RejectedCounts {
        self.state.rejected
    }

    fn append(&mut self, bytes: &[u8]) {
        let room = MAX_CODE_LEN - self.code.len();
        self.code.extend(&bytes[..bytes.len().min(room)]);
        self.overlong += bytes.len().saturating_sub(room);
    }

    fn end_of_packet(&mut self, sink: &mut impl FnMut(Event<'_>)) {
        let len = self.code.len() + self.overlong;
        if len > 0 {
            let state = &mut self.state;
            let refused = if self.overlong > 0 {
                Err(Rejected::TooLong { len })
            } else {
                body_of(&self.code, &mut self.body).map(|n| state.packet(&self.body[..n], sink))
            };
            if let Err(reason) = refused {
                state.refuse(reason, sink);
                state.salvage(&self.code, &mut self.body, sink);
            }
        }
        self.link_closed();
    }
}

impl State {
    /// Looks for the two DATA packets on either side of a 0x00 that was damaged or lost. Their
    /// length is known, and their CRC has to be right.
    fn salvage(&mut self, code: &[u8], body: &mut [u8], sink: &mut impl FnMut(Event<'_>)) {
        let Some(hello) = &self.hello else { return };
        let body_len = HEADER_LEN + hello.data_len() + CRC_LEN;
        let lengths = body_len + 1..=body_len + 1 + body_len / 254;
        let mut try_one = |part: &[u8]| match body_of(part, body) {
            Ok(n) if n == body_len => {
                self.packet(&body[..n], sink);
                true
            }
            _ => false,
        };
        let fitting = || lengths.clone().filter(|len| *len < code.len());
        let _ = fitting().any(|len| try_one(&code[..len]));
        let _ = fitting().any(|len| try_one(&code[code.len() - len..]));
    }

    fn refuse(&mut self, reason: Rejected, sink: &mut impl FnMut(Event<'_>)) {
        self.rejected.count(reason);
        sink(Event::Rejected(reason));
    }

    /// A body with a good CRC.
    fn packet(&mut self, body: &[u8], sink: &mut impl FnMut(Event<'_>)) {
        let header = Header::from_body(body);
        let payload = &body[HEADER_LEN..body.len() - CRC_LEN];
        let done = if header.major == MAJOR_VERSION {
            self.typed(header, payload, sink)
        } else {
            Err(Rejected::Version { found: header.major })
        };
        if let Err(reason) = done {
            self.refuse(reason, sink);
        }
    }

    fn typed(
        &mut self,
        header: Header,
        payload: &[u8],
        sink: &mut impl FnMut(Event<'_>),
    ) -> Result<(), Rejected> {
        let short = |what| move || Rejected::Malformed { what };
        match header.kind {
            DATA => return self.data(header, payload, sink),
            HELLO => return self.hello(payload, sink),
            STATUS => {
                let status = Status::from_payload(payload);
                sink(Event::Status(status.ok_or_else(short("STATUS is shorter than 40 bytes"))?));
            }
            PONG => {
                let pong = Pong::from_payload(payload, header.t_us);
                sink(Event::Pong(pong.ok_or_else(short("PONG is shorter than 16 bytes"))?));
            }
            LOG => sink(Event::Log(payload)),
            kind @ GET_HELLO..=STOP => {
                let command = Command::from_payload(kind, payload);
                sink(Event::Command(command.ok_or_else(short("PING is shorter than 8 bytes"))?));
            }
            kind => return Err(Rejected::UnknownType { kind }),
        }
        Ok(())
    }

    fn hello(&mut self, payload: &[u8], sink: &mut impl FnMut(Event<'_>)) -> Result<(), Rejected> {
        let new = Hello::from_payload(payload).map_err(|what| Rejected::BadHello { what })?;
        let other_device = self.hello.as_ref().is_some_and(|old| old.uid != new.uid);
        let restarted = other_device || self.boot_id.is_some_and(|id| id != new.boot_id);
        if other_device {
            self.sequence.forget();
        } else if restarted {
            self.sequence.restart();
        }
        self.boot_id = Some(new.boot_id);
        let is_new = self.hello.as_ref() != Some(&new);
        let hello = self.hello.insert(new);
        sink(Event::Hello { hello, is_new, restarted });
        Ok(())
    }

    fn data(
        &mut self,
        header: Header,
        payload: &[u8],
        sink: &mut impl FnMut(Event<'_>),
    ) -> Result<(), Rejected> {
        if self.sequence.is_restart(&header) {
            self.sequence.restart();
            self.boot_id = None;
            sink(Event::Restarted);
        }
        let hello = match &self.hello {
            Some(hello) if hello.schema_id() == header.schema => hello,
            other => {
                self.sequence.note(&header);
                return Err(other.as_ref().map_or(Rejected::NoHello, |hello| Rejected::Schema {
                    expected: hello.schema_id(),
                    found: header.schema,
                }));
            }
        };
        let n_channels = usize::from(header.n_channels);
        if n_channels != hello.channels.len() || payload.len() != hello.data_len() {
            self.sequence.note(&header);
            return Err(Rejected::SampleCount {
                channels: header.n_channels,
                len: payload.len(),
                expected_channels: hello.channels.len(),
                expected_len: hello.data_len(),
            });
        }
        let n_lost_before = self.sequence.deliver(&header)?;
        sink(Event::Data(Data { header, n_lost_before, hello, payload }));
        Ok(())
    }
}

/// Decodes COBS into `body` and checks length and CRC: the body's length.
fn body_of(code: &[u8], body: &mut [u8]) -> Result<usize, Rejected> {
    let len = code.len();
    let bad = |_| Rejected::Cobs { len };
    let report = cobs::decode(code, body).map_err(bad)?;
    let n = report.frame_size();
    if n < HEADER_LEN + CRC_LEN {
        return Err(Rejected::TooShort { len });
    }
    if n > MAX_BODY_LEN {
        return Err(Rejected::TooLong { len });
    }
    let expected = crc32c(&body[..n - CRC_LEN]);
    let found = u32_at(body, n - CRC_LEN);
    if expected != found {
        return Err(Rejected::Crc { expected, found });
    }
    Ok(n)
}
