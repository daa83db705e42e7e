//! Why a packet was refused, and how often.

use thiserror::Error;

use super::wire::MAJOR_VERSION;

/// Why a packet was refused. Nothing of a refused packet is delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum Rejected {
    #[error("a packet of {len} bytes is no COBS code: bytes were lost or damaged on the link")]
    Cobs { len: usize },
    #[error("a packet of {len} bytes is too short: bytes were lost on the link")]
    TooShort { len: usize },
    #[error("no end of packet within {len} bytes: is the baud rate right, is it an HDP1 device?")]
    TooLong { len: usize },
    #[error("CRC-32C {found:08x} instead of {expected:08x}: bytes were damaged on the link")]
    Crc { expected: u32, found: u32 },
    #[error(
        "the device speaks HDP version {found}, this program version {MAJOR_VERSION}: \
         flash the firmware that came with this program, or use the program of the firmware"
    )]
    Version { found: u8 },
    #[error(
        "DATA of schema {found:02x}, but the last HELLO's is {expected:02x}: HELLO is awaited, which the \
         device has to send where its channels change"
    )]
    Schema { expected: u8, found: u8 },
    #[error(
        "DATA without a HELLO, which says what is in it: HELLO is awaited, which the device has to send \
         when it is asked, and every second"
    )]
    NoHello,
    #[error("{what}: the device's firmware has to send a HELLO that can be used")]
    BadHello { what: &'static str },
    #[error(
        "DATA of {channels} channels in {len} bytes, HELLO says {expected_channels} channels in \
         {expected_len} bytes: the firmware is at fault, flash the one that came with this program"
    )]
    SampleCount { channels: u8, len: usize, expected_channels: usize, expected_len: usize },
    #[error("{what}: the firmware is at fault, flash the one that came with this program")]
    Malformed { what: &'static str },
    #[error("DATA {seq} came twice")]
    Repeat { seq: u32 },
    #[error("DATA {seq} came after its time, {expected} was expected")]
    Backwards { seq: u32, expected: u32 },
    #[error("a packet of unknown type {kind:02x} was skipped: the device's firmware may be newer")]
    UnknownType { kind: u8 },
}

/// How many packets were refused, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RejectedCounts {
    /// Bad COBS code, length or CRC.
    pub n_damaged: u64,
    /// Another major version.
    pub n_version: u64,
    /// DATA that no HELLO describes.
    pub n_schema: u64,
    /// Payloads that contradict themselves or the HELLO.
    pub n_malformed: u64,
    /// DATA that came twice.
    pub n_repeats: u64,
    /// DATA from before the last one.
    pub n_backwards: u64,
    /// Unknown types.
    pub n_unknown: u64,
}

impl Rejected {
    /// Where whole packets come and none can be used, that of the highest rank is why; none where the packet
    /// was not whole.
    pub(crate) fn rank(self) -> Option<u8> {
        Some(match self {
            Self::Cobs { .. } | Self::TooShort { .. } | Self::TooLong { .. } | Self::Crc { .. } => {
                return None;
            }
            Self::UnknownType { .. } => 0,
            Self::Repeat { .. } | Self::Backwards { .. } | Self::Malformed { .. } => 1,
            // What DATA is refused for after a HELLO that was, too.
            Self::Schema { .. } | Self::NoHello => 2,
            Self::Version { .. } | Self::BadHello { .. } | Self::SampleCount { .. } => 3,
        })
    }
}

impl RejectedCounts {
    pub(crate) fn count(&mut self, reason: Rejected) {
        let counter = match reason {
            Rejected::Cobs { .. }
            | Rejected::TooShort { .. }
            | Rejected::TooLong { .. }
            | Rejected::Crc { .. } => &mut self.n_damaged,
            Rejected::Version { .. } => &mut self.n_version,
            Rejected::Schema { .. } | Rejected::NoHello => &mut self.n_schema,
            Rejected::Malformed { .. }
            | Rejected::BadHello { .. }
            | Rejected::SampleCount { .. } => &mut self.n_malformed,
            Rejected::Repeat { .. } => &mut self.n_repeats,
            Rejected::Backwards { .. } => &mut self.n_backwards,
            Rejected::UnknownType { .. } => &mut self.n_unknown,
        };
        *counter += 1;
    }
}
