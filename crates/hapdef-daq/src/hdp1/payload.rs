//! The small packets: STATUS, PONG, and what a host says to a device.

use super::wire::{GET_HELLO, PING, START, STOP, array_at, u16_at, u32_at, u64_at};

const STATUS_LEN: usize = 40;

/// How a device is doing; it sends one every second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// DATA packets sent since boot.
    pub n_sent: u32,
    /// DATA packets dropped because the link didn't take them; they have sequence numbers, too.
    pub n_tx_dropped: u32,
    /// Times the converter was overrun.
    pub n_adc_overruns: u32,
    /// Packets from the host with a bad CRC.
    pub n_rx_crc_errors: u32,
    /// Time since boot, s.
    pub uptime_s: u32,
    /// Temperature of the board, 0.01 °C.
    pub temperature_centi_c: i16,
    /// Supply voltage, mV.
    pub supply_mv: u16,
    /// Bit i is set if channel i is at the end of its range.
    pub saturated: u64,
    /// Longest turn of the firmware's loop, µs.
    pub worst_loop_us: u32,
}

/// A device's answer to a PING.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pong {
    /// The host's time in the PING, ns.
    pub host_ns: u64,
    /// Device time at which the PING arrived, µs.
    pub t_rx_us: u64,
    /// Device time at which the PONG was made, µs.
    pub t_us: u64,
}

/// What a host says to a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Send a HELLO.
    GetHello,
    /// Answer with a PONG.
    Ping {
        /// The host's monotonic time, ns; comes back unchanged.
        host_ns: u64,
    },
    /// Send DATA.
    Start,
    /// Stop sending DATA.
    Stop,
}

impl Status {
    pub(crate) fn to_payload(self) -> [u8; STATUS_LEN] {
        let mut out = [0; STATUS_LEN];
        let words = [
            self.n_sent,
            self.n_tx_dropped,
            self.n_adc_overruns,
            self.n_rx_crc_errors,
            self.uptime_s,
        ];
        for (to, word) in out.chunks_exact_mut(4).zip(words) {
            to.copy_from_slice(&word.to_le_bytes());
        }
        out[20..22].copy_from_slice(&self.temperature_centi_c.to_le_bytes());
        out[22..24].copy_from_slice(&self.supply_mv.to_le_bytes());
        out[24..32].copy_from_slice(&self.saturated.to_le_bytes());
        out[32..36].copy_from_slice(&self.worst_loop_us.to_le_bytes());
        out
    }

    pub(crate) fn from_payload(payload: &[u8]) -> Option<Self> {
        (payload.len() >= STATUS_LEN).then(|| Self {
            n_sent: u32_at(payload, 0),
            n_tx_dropped: u32_at(payload, 4),
            n_adc_overruns: u32_at(payload, 8),
            n_rx_crc_errors: u32_at(payload, 12),
            uptime_s: u32_at(payload, 16),
            temperature_centi_c: i16::from_le_bytes(array_at(payload, 20)),
            supply_mv: u16_at(payload, 22),
            saturated: u64_at(payload, 24),
            worst_loop_us: u32_at(payload, 32),
        })
    }
}

impl Pong {
    pub(crate) fn to_payload(self) -> [u8; 16] {
        let mut out = [0; 16];
        out[..8].copy_from_slice(&self.host_ns.to_le_bytes());
        out[8..].copy_from_slice(&self.t_rx_us.to_le_bytes());
        out
    }

    pub(crate) fn from_payload(payload: &[u8], t_us: u64) -> Option<Self> {
        (payload.len() >= 16).then(|| Self {
            host_ns: u64_at(payload, 0),
            t_rx_us: u64_at(payload, 8),
            t_us,
        })
    }
}

impl Command {
    pub(crate) fn kind(self) -> u8 {
        match self {
            Self::GetHello => GET_HELLO,
            Self::Ping { .. } => PING,
            Self::Start => START,
            Self::Stop => STOP,
        }
    }

    pub(crate) fn from_payload(kind: u8, payload: &[u8]) -> Option<Self> {
        Some(match kind {
            GET_HELLO => Self::GetHello,
            PING if payload.len() >= 8 => Self::Ping { host_ns: u64_at(payload, 0) },
            START => Self::Start,
            STOP => Self::Stop,
            _ => return None,
        })
    }
}
