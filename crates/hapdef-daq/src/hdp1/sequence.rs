//! Which DATA packets are missing.

use super::reject::Rejected;
use super::wire::{FrameFlags, Header};

/// What became of the DATA packets that the device numbered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LossCounts {
    /// Packets delivered.
    pub n_delivered: u64,
    /// Packets that were numbered but not delivered.
    pub n_lost: u64,
    /// Restarts of the device.
    pub n_restarts: u64,
}

/// Follows the numbers of the DATA packets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sequence {
    expected: Option<u32>,
    counts: LossCounts,
}

impl Sequence {
    /// Takes a packet that is to be delivered: how many are missing before it.
    pub(crate) fn deliver(&mut self, header: &Header) -> Result<u32, Rejected> {
        let lost = self.gap(header)?;
        self.expected = Some(header.seq.wrapping_add(1));
        self.counts.n_delivered += 1;
        self.counts.n_lost += u64::from(lost);
        Ok(lost)
    }

    /// Notes a packet that exists but is not delivered: it counts as lost with the next that is.
    pub(crate) fn note(&mut self, header: &Header) {
        self.expected.get_or_insert(header.seq);
    }

    /// The device started anew and numbers from 0.
    pub(crate) fn restart(&mut self) {
        self.expected = Some(0);
        self.counts.n_restarts += 1;
    }

    /// Another device: its first packet is the first.
    pub(crate) fn forget(&mut self) {
        self.expected = None;
    }

    pub(crate) fn counts(&self) -> LossCounts {
        self.counts
    }

    /// True if the packet says that the device started anew since the last one.
    pub(crate) fn is_restart(&self, header: &Header) -> bool {
        let first = header.flags.contains(FrameFlags::FIRST_AFTER_BOOT);
        first && self.gap(header).is_err_and(|r| matches!(r, Rejected::Backwards { .. }))
    }

    fn gap(&self, header: &Header) -> Result<u32, Rejected> {
        let seq = header.seq;
        let expected = self.expected.unwrap_or(seq);
        match seq.wrapping_sub(expected) {
            gap if gap < 1 << 31 => Ok(gap),
            u32::MAX => Err(Rejected::Repeat { seq }),
            _ => Err(Rejected::Backwards { seq, expected }),
        }
    }
}
