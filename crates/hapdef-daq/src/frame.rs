//! A frame: one reading of all channels at a time, and what else a source has to say.

use std::sync::Arc;

use crate::hdp1::{FrameFlags, Hello, MAX_CHANNELS, SampleFormat, Status};
use crate::source::LinkState;

/// One reading of all channels.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Number of its packet.
    pub seq: u32,
    /// Its place in the packet.
    pub scan: u8,
    /// What the device says about its packet.
    pub flags: FrameFlags,
    /// Number format of the samples.
    pub format: SampleFormat,
    /// Packets that are missing directly before it: lost on the link or dropped by the device.
    pub n_lost_before: u32,
    /// Frames directly before it that this program dropped because its queue was full.
    pub n_dropped_before: u32,
    /// Device time of the sample instant, µs.
    pub t_device_us: u64,
    /// Host time of the sample instant, ns, on the host's monotonic clock: later than the truth by
    /// the link's shortest delay, which can't be seen from one end.
    pub t_host_ns: u64,
    n_channels: u8,
    bits: [i32; MAX_CHANNELS],
}

/// What a source says, in order.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all messages are frames, and a box for each would be a heap block per frame"
)]
pub enum Message {
    /// A reading.
    Frame(Frame),
    /// What the device measures; before its first frame and whenever it changes.
    Hello(Arc<Hello>),
    /// The device started anew, or another one took its place: its time and numbers begin again.
    Restarted,
    /// How the device is doing.
    Status(Status),
    /// Round trip of a PING, ns.
    RoundTrip(u64),
    /// A line of text from the device.
    Log(Arc<str>),
    /// What became of the link.
    Link(LinkState),
}

impl Frame {
    /// A frame of at most 64 samples, the rest is left out; times and losses are 0.
    #[must_use]
    pub fn new(seq: u32, format: SampleFormat, samples: impl IntoIterator<Item = i32>) -> Self {
        let mut bits = [0; MAX_CHANNELS];
        let mut n_channels = 0;
        for (to, from) in bits.iter_mut().zip(samples) {
            *to = from;
            n_channels += 1;
        }
        Self {
            seq,
            scan: 0,
            flags: FrameFlags::default(),
            format,
            n_lost_before: 0,
            n_dropped_before: 0,
            t_device_us: 0,
            t_host_ns: 0,
            n_channels,
            bits,
        }
    }

    /// Channels that are saturated in this frame, a bit each: those of the device's last STATUS, where
    /// the frame says that there are any.
    #[must_use]
    pub fn saturated(&self, last: &Status) -> u64 {
        if self.flags.contains(FrameFlags::SATURATED) { last.saturated } else { 0 }
    }

    /// The samples as 32 bits each: integers, or the bits of each f32.
    #[must_use]
    pub fn bits(&self) -> &[i32] {
        &self.bits[..usize::from(self.n_channels)]
    }

    /// The samples as sent, in counts (or in the device's unit if it sends f32); exact.
    pub fn values(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        let is_float = self.format == SampleFormat::F32;
        self.bits().iter().map(move |&bits| {
            if is_float { f64::from(f32::from_bits(bits.cast_unsigned())) } else { f64::from(bits) }
        })
    }

    /// Packets that are missing between that of number `last_seq` and this frame's and that nothing has
    /// counted before: those of a damaged file. None where the numbers go back, as after a restart.
    #[cfg(feature = "record")]
    pub(crate) fn n_missing_since(&self, last_seq: u32) -> u32 {
        let step = self.seq.wrapping_sub(last_seq);
        if step >= 1 << 31 {
            return 0;
        }
        let known = self.n_lost_before.saturating_add(self.n_dropped_before);
        step.saturating_sub(1).saturating_sub(known)
    }

    /// The samples in the channels' units (µε for bridges): value × scale + offset of HELLO, into
    /// `out`; returns how many there are.
    pub fn scaled(&self, hello: &Hello, out: &mut [f64]) -> usize {
        let channels = hello.channels.iter().zip(self.values());
        let mut n = 0;
        for (to, (channel, value)) in out.iter_mut().zip(channels) {
            *to = value * f64::from(channel.scale) + f64::from(channel.offset);
            n += 1;
        }
        n
    }
}

impl PartialEq for Frame {
    /// Equal numbers, times and bits.
    fn eq(&self, other: &Self) -> bool {
        let key = |f: &Self| {
            let counts = (f.n_lost_before, f.n_dropped_before);
            (f.seq, f.scan, f.flags, f.format, counts, f.t_device_us, f.t_host_ns)
        };
        key(self) == key(other) && self.bits() == other.bits()
    }
}
