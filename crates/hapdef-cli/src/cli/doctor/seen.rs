//! What came in a few seconds, in bounded memory however fast it came.

use std::sync::Arc;

use hapdef_daq::hdp1::{FrameFlags, Hello};
use hapdef_daq::source::{LinkState, SourceStats};
use hapdef_daq::{Frame, Message};
use hapdef_live::gauge_channels;

/// What came in a few seconds.
#[derive(Clone, Debug, Default)]
pub(super) struct Seen {
    pub(super) hello: Option<Arc<Hello>>,
    pub(super) link: Option<LinkState>,
    pub(super) stats: SourceStats,
    pub(super) n_frames: usize,
    /// Packets that are missing, as the frames say.
    pub(super) n_lost: u64,
    /// Host times of the first and the last frame, ns.
    pub(super) span_ns: Option<(u64, u64)>,
    /// Frames that say that a channel is saturated.
    pub(super) n_flagged: usize,
    /// Channels that STATUS says were saturated, a bit each.
    pub(super) saturated: u64,
    pub(super) channels: Vec<Span>,
}

/// The values of a channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Values that are the lowest, and the highest.
    pub(super) n_low: usize,
    pub(super) n_high: usize,
    /// The first that is no finite number.
    pub(super) not_finite: Option<f64>,
}

impl Seen {
    pub(super) fn take(&mut self, message: &Message) {
        match message {
            Message::Frame(frame) => self.frame(frame),
            Message::Hello(hello) => self.hello = Some(Arc::clone(hello)),
            Message::Status(status) => self.saturated |= status.saturated,
            Message::Link(state) => self.link = Some(state.clone()),
            _ => {}
        }
    }

    fn frame(&mut self, frame: &Frame) {
        let t_ns = frame.t_host_ns;
        let (first_ns, _) = self.span_ns.unwrap_or((t_ns, t_ns));
        self.span_ns = Some((first_ns, t_ns));
        self.n_frames += 1;
        self.n_lost += u64::from(frame.n_lost_before);
        self.n_flagged += usize::from(frame.flags.contains(FrameFlags::SATURATED));
        self.channels.resize(frame.bits().len(), Span::default());
        for (span, value) in self.channels.iter_mut().zip(frame.values()) {
            span.take(value);
        }
    }

    /// Name of a channel: what the device calls it, or its number.
    pub(super) fn name(&self, channel: usize) -> String {
        let known = self.hello.as_ref().and_then(|h| h.channels.get(channel));
        let name = known.map(|c| c.name_text()).unwrap_or_default();
        match name.as_str() {
            "" => format!("channel {channel}"),
            name => name.to_owned(),
        }
    }

    /// Channel of each of the gauges called `names`, as the live runtime finds them; the bridges as
    /// they come where their number is another or the device does not describe itself.
    pub(super) fn gauges(&self, names: &[String]) -> Vec<usize> {
        let names_of = names.iter().map(String::as_str);
        let hello = self.hello.as_ref();
        let found = hello.map(|h| gauge_channels(&h.channels, names_of, Some(names.len())));
        let found = found.and_then(Result::ok);
        found.unwrap_or_else(|| self.bridges().collect())
    }

    /// Channels with a gauge.
    pub(super) fn bridges(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.channels.len()).filter(|&i| {
            let channel = self.hello.as_ref().and_then(|h| h.channels.get(i));
            channel.is_none_or(|c| c.kind.is_bridge())
        })
    }
}

impl Default for Span {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY, n_low: 0, n_high: 0, not_finite: None }
    }
}

impl Span {
    fn take(&mut self, value: f64) {
        if !value.is_finite() {
            self.not_finite.get_or_insert(value);
            return;
        }
        if value < self.low {
            (self.low, self.n_low) = (value, 0);
        }
        if value > self.high {
            (self.high, self.n_high) = (value, 0);
        }
        self.n_low += usize::from(value <= self.low);
        self.n_high += usize::from(value >= self.high);
    }

    /// Values at the ends of what can come.
    pub(super) fn n_at_ends(&self, [least, most]: [f64; 2]) -> usize {
        let n_low = if self.low <= least { self.n_low } else { 0 };
        let n_high = if self.high >= most { self.n_high } else { 0 };
        n_low + n_high
    }
}
