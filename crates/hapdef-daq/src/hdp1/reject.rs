//! Why a packet was refused, and how often.

use thiserror::Error;

use super::wire::MAJOR_VERSION;

/// Why a packet was refused. Nothing of a refused packet is delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Rejected {
    /// The COBS code does not add up.
    #[error("a packet of {len} bytes is no COBS code: bytes were lost or damaged on the link")]
    Cobs {
        /// Bytes between two 0x00.
        len: usize,
    },
    /// Shorter than header and CRC.
    #[error("a packet of {len} bytes is too short: bytes were lost on the link")]
    TooShort {
        /// Bytes between two 0x00.
        len: usize,
    },
    /// Longer than any packet.
    #[error("no end of packet within {len} bytes: is the baud rate right, is it an HDP1 device?")]
    TooLong {
        /// Bytes without 0x00.
        len: usize,
    },
    /// The CRC does not match.
    #[error("CRC-32C {found:08x} instead of {expected:08x}: bytes were damaged on the link")]
    Crc {
        /// CRC of what arrived.
        expected: u32,
        /// CRC in the packet.
        found: u32,
    },
    /// Another major version.
    #[error(
        "the device speaks HDP version {found}, this program version {MAJOR_VERSION}: \
         flash the firmware that came with this program, or use the program of the firmware"
    )]
    Version {
        /// Major version of the packet.
        found: u8,
    },
    /// DATA that no HELLO describes.
    #[error(
        "DATA of schema {found:02x}, but the last HELLO's is {expected:02x?}: HELLO is awaited"
    )]
    Schema {
        /// Schema of the last HELLO, if there was one.
        expected: Option<u8>,
        /// Schema of the packet.
        found: u8,
    },
    /// A payload that contradicts itself or the HELLO, in a packet with a good CRC.
    #[error("{what}: the firmware is at fault, flash the one that came with this program")]
    Malformed {
        /// What contradicts what.
        what: &'static str,
    },
    /// A DATA packet that was there already.
    #[error("DATA {seq} came twice")]
    Repeat {
        /// Its number.
        seq: u32,
    },
    /// A DATA packet from before the last one.
    #[error("DATA {seq} came after its time, {expected} was expected")]
    Backwards {
        /// Its number.
        seq: u32,
        /// Number that was expected.
        expected: u32,
    },
    /// A type that is not known here.
    #[error("a packet of unknown type {kind:02x} was skipped: the device's firmware may be newer")]
    UnknownType {
        /// Its type.
        kind: u8,
    },
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

impl RejectedCounts {
    pub(crate) fn count(&mut self, reason: Rejected) {
        let counter = match reason {
            Rejected::Cobs { .. }
            | Rejected::TooShort { .. }
            | Rejected::TooLong { .. }
            | Rejected::Crc { .. } => &mut self.n_damaged,
            Rejected::Version { .. } => &mut self.n_version,
            Rejected::Schema { .. } => &mut self.n_schema,
            Rejected::Malformed { .. } => &mut self.n_malformed,
            Rejected::Repeat { .. } => &mut self.n_repeats,
            Rejected::Backwards { .. } => &mut self.n_backwards,
            Rejected::UnknownType { .. } => &mut self.n_unknown,
        };
        *counter += 1;
    }
}
