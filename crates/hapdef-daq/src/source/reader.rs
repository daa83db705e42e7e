//! Bytes to messages, by either protocol.

use std::sync::Arc;

use super::pace::{ClockWords, Rate};
use super::{Protocol, SourceStats};
use crate::clock::ClockMap;
use crate::csv_line::{CsvCounts, CsvDecoder};
use crate::hdp1::{Data, Decoder, Event, FrameFlags, Hello, Rejected, SampleFormat};
use crate::{Frame, Message};

pub(crate) struct Reader {
    decoding: Decoding,
    state: State,
}

enum Decoding {
    Hdp1(Decoder),
    Csv { decoder: CsvDecoder, hello: Hello },
}

#[derive(Default)]
struct State {
    map: ClockMap,
    has_hello: bool,
    /// Packets or lines that were understood.
    n_good: u64,
    /// Whole packets that were refused since somebody asked, and the weightiest reason.
    refused: Option<(u64, Rejected)>,
    clock: ClockWords,
    /// Lines refused before the last frame.
    n_refused: u64,
    rate: Rate,
    stats: SourceStats,
}

impl Reader {
    pub(crate) fn new(protocol: Protocol) -> Self {
        Self {
            decoding: match protocol {
                Protocol::Hdp1 => Decoding::Hdp1(Decoder::new()),
                Protocol::Csv { n_channels } => Decoding::Csv {
                    decoder: CsvDecoder::new(n_channels),
                    hello: Hello::of_lines(n_channels),
                },
            },
            state: State::default(),
        }
    }

    /// True if the protocol has commands for the device.
    pub(crate) fn has_commands(&self) -> bool {
        matches!(self.decoding, Decoding::Hdp1(_))
    }

    pub(crate) fn n_good(&self) -> u64 {
        self.state.n_good
    }

    /// Frames so far.
    pub(crate) fn n_frames(&self) -> u64 {
        self.state.stats.n_frames
    }

    /// Whole packets that were refused since this was asked last, and why.
    pub(crate) fn take_refused(&mut self) -> Option<(u64, Rejected)> {
        self.state.refused.take()
    }

    /// How many integers a line has to have and how many the last had, where those differ.
    pub(crate) fn other_channels(&self) -> Option<(usize, usize)> {
        match &self.decoding {
            Decoding::Hdp1(_) => None,
            Decoding::Csv { decoder, .. } => decoder.other_channels(),
        }
    }

    pub(crate) fn link_closed(&mut self) {
        match &mut self.decoding {
            Decoding::Hdp1(decoder) => decoder.link_closed(),
            Decoding::Csv { decoder, .. } => decoder.link_closed(),
        }
    }

    pub(crate) fn take(&mut self, bytes: &[u8], now_ns: u64, sink: &mut dyn FnMut(Message)) {
        let state = &mut self.state;
        match &mut self.decoding {
            Decoding::Hdp1(decoder) => {
                decoder.push(bytes, &mut |event| state.event(event, now_ns, sink));
            }
            Decoding::Csv { decoder, hello } => {
                decoder.push(bytes, &mut |counts, values| {
                    state.line(counts, values, hello, now_ns, sink);
                });
            }
        }
        self.state.count_rate(now_ns);
    }

    pub(crate) fn stats(&self) -> SourceStats {
        let mut stats = self.state.stats;
        stats.drift_ppm = self.state.map.drift_ppm().unwrap_or(0.0);
        match &self.decoding {
            Decoding::Hdp1(decoder) => {
                stats.clock_residual_us = self.state.map.residual_us();
                (stats.losses, stats.rejected) = (decoder.losses(), decoder.rejected());
            }
            Decoding::Csv { decoder, .. } => {
                stats.lines = decoder.counts();
                stats.losses.n_delivered = stats.lines.n_lines;
                stats.losses.n_lost = stats.lines.n_refused;
            }
        }
        stats
    }
}

impl State {
    fn event(&mut self, event: Event<'_>, now_ns: u64, sink: &mut dyn FnMut(Message)) {
        self.n_good += u64::from(!matches!(event, Event::Rejected(_)));
        match event {
            Event::Data(data) => self.frames(&data, now_ns, sink),
            Event::Hello { hello, is_new, restarted } => {
                if restarted {
                    self.restarted(sink);
                }
                if is_new {
                    sink(Message::Hello(Arc::new(hello.clone())));
                }
            }
            Event::Restarted => self.restarted(sink),
            Event::Status(status) => sink(Message::Status(status)),
            Event::Pong(pong) => {
                self.stats.round_trip_ns = now_ns.saturating_sub(pong.host_ns);
                sink(Message::RoundTrip(self.stats.round_trip_ns));
            }
            Event::Log(text) => sink(Message::Log(String::from_utf8_lossy(text).into())),
            Event::Rejected(reason) => self.refused(reason),
            Event::Command(_) => {}
        }
    }

    fn refused(&mut self, reason: Rejected) {
        if reason.rank().is_some() {
            let (n, before) = self.refused.unwrap_or((0, reason));
            let weightier = if reason.rank() > before.rank() { reason } else { before };
            self.refused = Some((n + 1, weightier));
        }
    }

    fn restarted(&mut self, sink: &mut dyn FnMut(Message)) {
        self.map.restart();
        sink(Message::Restarted);
    }

    /// The scans of a packet.
    fn frames(&mut self, data: &Data<'_>, now_ns: u64, sink: &mut dyn FnMut(Message)) {
        // The last scan waits least for its packet.
        let last_us = data.t_us(usize::from(data.hello.n_scans.max(1)) - 1);
        let before_ns = self.map.last_ns();
        let last_ns = self.map.map(last_us, now_ns);
        let fault = self.map.fault();
        self.clock.complain(&self.map, now_ns, sink);
        for scan in 0..data.hello.n_scans {
            let at = usize::from(scan);
            let mut frame = Frame::new(data.header.seq, data.hello.format, data.bits(at));
            frame.scan = scan;
            frame.flags = data.header.flags;
            frame.n_lost_before = if scan == 0 { data.n_lost_before } else { 0 };
            frame.t_device_us = data.t_us(at);
            let ago_ns = last_us.wrapping_sub(frame.t_device_us).saturating_mul(1000);
            frame.t_host_ns = last_ns.saturating_sub(ago_ns).max(before_ns);
            if fault.is_some() {
                frame.flags = frame.flags.union(FrameFlags::HOST_TIME);
                self.stats.n_host_time += 1;
            }
            self.stats.n_frames += 1;
            sink(Message::Frame(frame));
        }
    }

    /// A line has no time of its own: its arrival stands for it; and no number: lines are counted,
    /// refused ones as lost.
    fn line(
        &mut self,
        counts: CsvCounts,
        values: &[i32],
        hello: &Hello,
        now_ns: u64,
        sink: &mut dyn FnMut(Message),
    ) {
        if !std::mem::replace(&mut self.has_hello, true) {
            sink(Message::Hello(Arc::new(hello.clone())));
        }
        let seq = (counts.n_lines + counts.n_refused - 1) as u32;
        let mut frame = Frame::new(seq, SampleFormat::U16, values.iter().copied());
        let n_refused = std::mem::replace(&mut self.n_refused, counts.n_refused);
        frame.n_lost_before = (counts.n_refused - n_refused) as u32;
        (frame.t_device_us, frame.t_host_ns) = (now_ns / 1000, now_ns);
        self.n_good += 1;
        self.stats.n_frames += 1;
        sink(Message::Frame(frame));
    }

    fn count_rate(&mut self, now_ns: u64) {
        if let Some(rate_hz) = self.rate.count(self.stats.n_frames, now_ns) {
            self.stats.rate_hz = rate_hz;
        }
    }
}
