//! Packets to bytes.

use super::hello::Hello;
use super::payload::{Command, Pong, Status};
use super::wire::{
    CRC_LEN, DATA, FrameFlags, HEADER_LEN, HELLO, Header, LOG, MAJOR_VERSION, MAX_BODY_LEN,
    MAX_CODE_LEN, PONG, STATUS, crc32c,
};
use crate::DaqError;

/// Makes packets and keeps count of the DATA among them. Bytes are appended to the caller's buffer.
#[derive(Clone, Debug)]
pub struct Encoder {
    schema: u8,
    seq: u32,
    body: Vec<u8>,
    code: Vec<u8>,
}

impl Default for Encoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Encoder {
    /// An encoder that numbers DATA from 0 and has said no HELLO yet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            schema: 0,
            seq: 0,
            body: Vec::with_capacity(MAX_BODY_LEN),
            code: vec![0; MAX_CODE_LEN],
        }
    }

    /// Number of the next DATA packet.
    #[must_use]
    pub fn seq(&self) -> u32 {
        self.seq
    }

    /// Sets the number of the next DATA packet.
    pub fn set_seq(&mut self, seq: u32) {
        self.seq = seq;
    }

    /// Any packet: header, payload, CRC, in COBS with 0x00 behind.
    ///
    /// # Errors
    /// A body longer than 1536 bytes; nothing is appended then.
    pub fn packet(
        &mut self,
        header: Header,
        payload: &[u8],
        out: &mut Vec<u8>,
    ) -> Result<(), DaqError> {
        let len = HEADER_LEN + payload.len() + CRC_LEN;
        if len > MAX_BODY_LEN {
            return Err(DaqError::PacketTooLong { len });
        }
        self.body.clear();
        self.body.extend(header.to_bytes());
        self.body.extend(payload);
        self.body.extend(crc32c(&self.body).to_le_bytes());
        let n = cobs::encode(&self.body, &mut self.code);
        out.extend(&self.code[..n]);
        out.push(0);
        Ok(())
    }

    /// HELLO; the DATA packets that follow carry its schema.
    ///
    /// # Errors
    /// A HELLO that a decoder would refuse.
    pub fn hello(&mut self, hello: &Hello, t_us: u64, out: &mut Vec<u8>) -> Result<(), DaqError> {
        hello.check().map_err(|what| DaqError::BadHello { what })?;
        self.schema = hello.schema_id();
        let header = self.header(HELLO, t_us);
        self.packet(header, &hello.to_payload(), out)
    }

    /// DATA from samples as integers (for F32 the bits of each), scan after scan; takes the next
    /// number.
    ///
    /// # Errors
    /// A number of samples that is not HELLO's, or one outside the format's range; no number is
    /// taken then.
    pub fn data(
        &mut self,
        hello: &Hello,
        t_us: u64,
        flags: FrameFlags,
        samples: &[i32],
        out: &mut Vec<u8>,
    ) -> Result<(), DaqError> {
        let expected = usize::from(hello.n_scans) * hello.channels.len();
        if samples.len() != expected {
            return Err(DaqError::SampleCount { expected, found: samples.len() });
        }
        let mut payload = Vec::with_capacity(hello.data_len());
        for &found in samples {
            let format = hello.format;
            format.put(found, &mut payload).ok_or(DaqError::SampleRange { found, format })?;
        }
        let header = Header {
            flags,
            n_channels: u8::try_from(hello.channels.len()).unwrap_or(u8::MAX),
            ..self.header(DATA, t_us)
        };
        self.packet(header, &payload, out)?;
        self.seq = self.seq.wrapping_add(1);
        Ok(())
    }

    /// STATUS.
    pub fn status(&mut self, status: Status, t_us: u64, out: &mut Vec<u8>) {
        self.short(self.header(STATUS, t_us), &status.to_payload(), out);
    }

    /// PONG.
    pub fn pong(&mut self, pong: Pong, out: &mut Vec<u8>) {
        self.short(self.header(PONG, pong.t_us), &pong.to_payload(), out);
    }

    /// LOG; text beyond 1500 bytes is cut.
    pub fn log(&mut self, text: &str, t_us: u64, out: &mut Vec<u8>) {
        let mut end = text.len().min(1500);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        self.short(self.header(LOG, t_us), &text.as_bytes()[..end], out);
    }

    /// What a host says to a device.
    pub fn command(&mut self, command: Command, out: &mut Vec<u8>) {
        let host_ns = match command {
            Command::Ping { host_ns } => host_ns.to_le_bytes(),
            _ => [0; 8],
        };
        let len = if matches!(command, Command::Ping { .. }) { 8 } else { 0 };
        self.short(self.header(command.kind(), 0), &host_ns[..len], out);
    }

    fn header(&self, kind: u8, t_us: u64) -> Header {
        Header {
            kind,
            major: MAJOR_VERSION,
            flags: FrameFlags::default(),
            schema: self.schema,
            n_channels: 0,
            seq: self.seq,
            t_us,
        }
    }

    /// A packet that is known to fit.
    fn short(&mut self, header: Header, payload: &[u8], out: &mut Vec<u8>) {
        let made = self.packet(header, payload, out);
        debug_assert!(made.is_ok(), "{made:?}");
    }
}
