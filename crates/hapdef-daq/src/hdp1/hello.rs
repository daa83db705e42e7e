//! HELLO: what a device measures, and in which form it sends it.

use super::wire::{CRC_LEN, HEADER_LEN};
use super::wire::{MAX_BODY_LEN, MAX_CHANNELS, MINOR_VERSION, array_at, crc32c, u16_at, u32_at};

const FIXED_LEN: usize = 32;
const CHANNEL_LEN: usize = 16;
const LINES_UID: &[u8; 16] = b"lines of 12 bits";
const SIMULATED_UID: [u8; 16] = *b"hapdef simulated";

/// Number format of the samples in DATA packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleFormat {
    /// Signed, 16 bits.
    I16,
    /// Unsigned, 16 bits.
    U16,
    /// Signed, 24 bits.
    I24,
    /// Signed, 32 bits.
    I32,
    /// IEEE 754, 32 bits.
    F32,
}

/// What is wired to a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ChannelKind {
    /// A quarter bridge.
    QuarterBridge,
    /// A half bridge.
    HalfBridge,
    /// A full bridge.
    FullBridge,
    /// A temperature.
    Temperature,
    /// A voltage.
    Volt,
    /// An axis of an accelerometer, m/s².
    Acceleration,
    /// An axis of a gyroscope, rad/s.
    AngularRate,
    /// A force, N.
    Force,
    /// A torque, N m.
    Torque,
    /// Nothing.
    Unused,
    /// A kind that a later minor version brought, by its number.
    Other(u8),
}

/// One channel of a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// What is wired to it.
    pub kind: ChannelKind,
    /// Gain of the amplifier as a power of two.
    pub log2_gain: u8,
    /// Delay of its sample instant behind the scan's, in units of 16 ns.
    pub skew_16ns: u16,
    /// Microstrain per count (the kind's unit per count where it is no bridge).
    pub scale: f32,
    /// What is added after scaling, same unit.
    pub offset: f32,
    /// Name, ASCII, filled with zeros.
    pub name: [u8; 4],
}

/// What a device says about itself when it is opened, when asked, and every second.
#[derive(Clone, Debug, PartialEq)]
pub struct Hello {
    /// Minor version of the protocol it speaks.
    pub minor: u8,
    /// Number format of its samples.
    pub format: SampleFormat,
    /// Scans (readings of all channels) in one DATA packet.
    pub n_scans: u8,
    /// Scans per 1000 seconds.
    pub rate_mhz: u32,
    /// The device's own identity.
    pub uid: [u8; 16],
    /// A number that differs from one start of the device to the next.
    pub boot_id: u32,
    /// Firmware version.
    pub firmware: u16,
    /// Its channels, 1 to 64.
    pub channels: Vec<Channel>,
    /// CRC of the schema; its low byte is in every DATA header.
    pub schema_crc: u16,
}

impl SampleFormat {
    /// Bytes of one sample.
    #[must_use]
    pub const fn n_bytes(self) -> usize {
        match self {
            Self::I16 | Self::U16 => 2,
            Self::I24 => 3,
            Self::I32 | Self::F32 => 4,
        }
    }

    /// Its number on the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::I16 => 0,
            Self::U16 => 1,
            Self::I24 => 2,
            Self::I32 => 3,
            Self::F32 => 4,
        }
    }

    /// The format of a number on the wire, if it is one.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::I16,
            1 => Self::U16,
            2 => Self::I24,
            3 => Self::I32,
            4 => Self::F32,
            _ => return None,
        })
    }

    /// A sample's 32 bits: the integer, or the bits of the f32. `bytes` has [`Self::n_bytes`].
    pub(crate) fn bits(self, bytes: &[u8]) -> i32 {
        match self {
            Self::I16 => i32::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            Self::U16 => i32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Self::I24 => i32::from_le_bytes([0, bytes[0], bytes[1], bytes[2]]) >> 8,
            Self::I32 | Self::F32 => i32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        }
    }

    /// Appends a sample's bytes; `None` if the integer is outside the format's range.
    pub(crate) fn put(self, bits: i32, out: &mut Vec<u8>) -> Option<()> {
        match self {
            Self::I16 => out.extend(i16::try_from(bits).ok()?.to_le_bytes()),
            Self::U16 => out.extend(u16::try_from(bits).ok()?.to_le_bytes()),
            Self::I24 => {
                if !(-(1 << 23)..1 << 23).contains(&bits) {
                    return None;
                }
                out.extend(&bits.to_le_bytes()[..3]);
            }
            Self::I32 | Self::F32 => out.extend(bits.to_le_bytes()),
        }
        Some(())
    }
}

impl ChannelKind {
    fn code(self) -> u8 {
        match self {
            Self::QuarterBridge => 0,
            Self::HalfBridge => 1,
            Self::FullBridge => 2,
            Self::Temperature => 3,
            Self::Volt => 4,
            Self::Acceleration => 5,
            Self::AngularRate => 6,
            Self::Force => 7,
            Self::Torque => 8,
            Self::Unused => 255,
            Self::Other(code) => code,
        }
    }

    fn from_code(code: u8) -> Self {
        match code {
            0 => Self::QuarterBridge,
            1 => Self::HalfBridge,
            2 => Self::FullBridge,
            3 => Self::Temperature,
            4 => Self::Volt,
            5 => Self::Acceleration,
            6 => Self::AngularRate,
            7 => Self::Force,
            8 => Self::Torque,
            255 => Self::Unused,
            other => Self::Other(other),
        }
    }
}

impl ChannelKind {
    /// Whether a strain gauge is wired to the channel: a quarter, half or full bridge.
    #[must_use]
    pub fn is_bridge(self) -> bool {
        matches!(self, Self::QuarterBridge | Self::HalfBridge | Self::FullBridge)
    }
}

impl Channel {
    /// A quarter bridge of that name (at most four characters are kept) and scale, µε per count.
    #[must_use]
    pub fn quarter_bridge(name: &str, scale: f32) -> Self {
        let mut four = [0; 4];
        for (to, from) in four.iter_mut().zip(name.bytes()) {
            *to = from;
        }
        Self {
            kind: ChannelKind::QuarterBridge,
            log2_gain: 0,
            skew_16ns: 0,
            scale,
            offset: 0.0,
            name: four,
        }
    }

    /// The name as text; bytes that are no printable ASCII become '?'.
    #[must_use]
    pub fn name_text(&self) -> String {
        let used = self.name.iter().take_while(|b| **b != 0);
        let plain = |b: &u8| {
            if b.is_ascii_graphic() { *b as char } else { '?' }
        };
        used.map(plain).collect()
    }
}

impl Hello {
    /// [`Self::uid`] of the virtual rig.
    pub const RIG_UID: [u8; 16] = *b"hapdef rig (sim)";

    /// Whether the device says that it is simulated.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        [SIMULATED_UID, Self::RIG_UID].contains(&self.uid)
    }

    /// A device of quarter bridges G0, G1, … with scale 1 and one scan per packet, for tests and
    /// simulated devices.
    #[must_use]
    pub fn plain(n_channels: usize, format: SampleFormat, rate_hz: u32) -> Self {
        let mut hello = Self {
            minor: MINOR_VERSION,
            format,
            n_scans: 1,
            rate_mhz: rate_hz.saturating_mul(1000),
            uid: SIMULATED_UID,
            boot_id: 1,
            firmware: 1,
            channels: (0..n_channels)
                .map(|i| Channel::quarter_bridge(&format!("G{i}"), 1.0))
                .collect(),
            schema_crc: 0,
        };
        hello.seal();
        hello
    }

    /// What stands for a device that sends lines of integers of 12 bits and says nothing of itself.
    #[must_use]
    pub fn of_lines(n_channels: usize) -> Self {
        Self { uid: *LINES_UID, ..Self::plain(n_channels, SampleFormat::U16, 0) }
    }

    /// Lowest and highest count that can come; none of real numbers. A converter of fewer bits than the
    /// format saturates before, which only its own flag and STATUS report.
    #[must_use]
    pub fn count_range(&self) -> Option<[f64; 2]> {
        use SampleFormat as F;
        Some(match self.format {
            F::I16 => [f64::from(i16::MIN), f64::from(i16::MAX)],
            F::U16 if self.uid == *LINES_UID => [0.0, 4095.0],
            F::U16 => [0.0, f64::from(u16::MAX)],
            F::I24 => [-8_388_608.0, 8_388_607.0],
            F::I32 => [f64::from(i32::MIN), f64::from(i32::MAX)],
            F::F32 => return None,
        })
    }

    /// Sets the schema CRC: the low half of the CRC-32C over channel count, format, scans, rate and
    /// the channel table.
    pub fn seal(&mut self) {
        let payload = self.to_payload();
        let mut described = payload[1..8].to_vec();
        described.extend(&payload[FIXED_LEN..]);
        self.schema_crc = (crc32c(&described) & 0xffff) as u16;
    }

    /// Low byte of the schema CRC.
    #[must_use]
    pub fn schema_id(&self) -> u8 {
        self.schema_crc.to_le_bytes()[0]
    }

    /// Bytes of a DATA packet's payload.
    #[must_use]
    pub fn data_len(&self) -> usize {
        usize::from(self.n_scans) * self.channels.len() * self.format.n_bytes()
    }

    /// Time from one scan to the next, µs.
    #[must_use]
    pub fn scan_period_us(&self) -> f64 {
        1e9 / f64::from(self.rate_mhz.max(1))
    }

    pub(crate) fn to_payload(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(FIXED_LEN + CHANNEL_LEN * self.channels.len());
        let n = u8::try_from(self.channels.len()).unwrap_or(u8::MAX);
        out.extend([self.minor, n, self.format.code(), self.n_scans]);
        out.extend(self.rate_mhz.to_le_bytes());
        out.extend(self.uid);
        out.extend(self.boot_id.to_le_bytes());
        out.extend(self.firmware.to_le_bytes());
        out.extend(self.schema_crc.to_le_bytes());
        for channel in &self.channels {
            out.extend([channel.kind.code(), channel.log2_gain]);
            out.extend(channel.skew_16ns.to_le_bytes());
            out.extend(channel.scale.to_le_bytes());
            out.extend(channel.offset.to_le_bytes());
            out.extend(channel.name);
        }
        out
    }

    /// Reads a payload; a larger minor version may trail more than is known here.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub(crate) fn from_payload(payload: &[u8]) -> Result<Self, &'static str> {
        if payload.len() < FIXED_LEN {
            return Err("HELLO is shorter than 32 bytes");
        }
        let (minor, n) = (payload[0], usize::from(payload[1]));
        let len = FIXED_LEN + CHANNEL_LEN * n;
        if payload.len() < len || (minor == MINOR_VERSION && payload.len() != len) {
            return Err("HELLO's length is not 32 + 16 per channel");
        }
        let format = SampleFormat::from_code(payload[2]).ok_or("HELLO has an unknown format")?;
        let hello = Self {
            minor,
            format,
            n_scans: payload[3],
            rate_mhz: u32_at(payload, 4),
            uid: array_at(payload, 8),
            boot_id: u32_at(payload, 24),
            firmware: u16_at(payload, 28),
            schema_crc: u16_at(payload, 30),
            channels: payload[FIXED_LEN..len].chunks_exact(CHANNEL_LEN).map(channel).collect(),
        };
        hello.check().map(|()| hello)
    }

    /// # Errors
    /// What a device must not announce, in words.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        if self.channels.is_empty() || self.channels.len() > MAX_CHANNELS {
            return Err("HELLO has to have 1 to 64 channels");
        }
        if self.n_scans == 0 || self.rate_mhz == 0 {
            return Err("HELLO has no scans per frame or no rate");
        }
        if HEADER_LEN + self.data_len() + CRC_LEN > MAX_BODY_LEN {
            return Err("HELLO announces DATA packets longer than 1536 bytes");
        }
        let finite = |c: &Channel| c.scale.is_finite() && c.offset.is_finite();
        if !self.channels.iter().all(finite) {
            return Err("HELLO has a scale or offset that is not finite");
        }
        Ok(())
    }
}

fn channel(bytes: &[u8]) -> Channel {
    Channel {
        kind: ChannelKind::from_code(bytes[0]),
        log2_gain: bytes[1],
        skew_16ns: u16_at(bytes, 2),
        scale: f32::from_le_bytes(array_at(bytes, 4)),
        offset: f32::from_le_bytes(array_at(bytes, 8)),
        name: array_at(bytes, 12),
    }
}
