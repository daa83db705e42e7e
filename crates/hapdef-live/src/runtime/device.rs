//! Which channels of a device are the gauges, and what their counts mean.

use std::sync::Arc;

use hapdef_daq::Frame;
use hapdef_daq::hdp1::{Channel, ChannelKind, Hello, MAX_CHANNELS, SampleFormat, Status};

use super::LiveGauge;
use super::channels::gauge_channels;
use crate::signals::{LoadSignal, SignalReader};

/// A device that the gauges were found on.
#[derive(Clone, Debug)]
pub(super) struct Device {
    pub(super) hello: Arc<Hello>,
    /// Channel of each gauge.
    gauges: Vec<usize>,
    /// Factor of each gauge.
    scales: Vec<f64>,
    temperature: Option<usize>,
    signals: SignalReader,
    /// Time between frames, s.
    pub(super) period_s: f64,
    /// All channels in their units.
    scaled: [f64; MAX_CHANNELS],
    /// What the device said last of itself.
    status: Status,
    /// Channels that it says are saturated in the frame that was read last, a bit each.
    saturated: u64,
}

impl Device {
    /// Finds the gauges among the channels as [`gauge_channels`] does.
    ///
    /// # Errors
    /// What is expected, what was found, what to do.
    pub(super) fn new(
        hello: Arc<Hello>,
        gauges: &[LiveGauge],
        n_gauges: Option<usize>,
        rate_hz: f64,
    ) -> Result<Self, String> {
        let channels = &hello.channels;
        let names = gauges.iter().map(|gauge| gauge.name.as_str());
        let places = gauge_channels(channels, names, n_gauges).map_err(|e| e.to_string())?;
        let is_temperature = |c: &Channel| c.kind == ChannelKind::Temperature;
        let of_gauge = |i: usize| gauges.get(i).map_or(1.0, |gauge| gauge.scale);
        let is_rate_known = hello.rate_mhz > 0;
        Ok(Self {
            temperature: channels.iter().position(is_temperature),
            signals: SignalReader::new(channels),
            scales: (0..places.len()).map(of_gauge).collect(),
            gauges: places,
            period_s: if is_rate_known { hello.scan_period_us() * 1e-6 } else { 1.0 / rate_hz },
            hello,
            scaled: [0.0; MAX_CHANNELS],
            status: Status::default(),
            saturated: 0,
        })
    }

    /// Whether it is the same device with the same channels.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let key = |hello: &Hello| (hello.uid, hello.schema_crc);
        key(&self.hello) == key(&other.hello)
    }

    /// Time from a scan to the last one of its packet, ns: it can't be here before.
    pub(super) fn rest_of_packet_ns(&self, scan: u8) -> u64 {
        let n_later = self.hello.n_scans.saturating_sub(1).saturating_sub(scan);
        (f64::from(n_later) * self.period_s * 1e9) as u64
    }

    pub(super) fn n_gauges(&self) -> usize {
        self.gauges.len()
    }

    /// The gauges' readings, µε, into `raw` `[n_gauges]`, and the temperature if there is one; none
    /// where the frame has other channels than the HELLO.
    pub(super) fn read(&mut self, frame: &Frame, raw: &mut [f64]) -> Option<Option<f64>> {
        if frame.bits().len() != self.hello.channels.len() {
            return None;
        }
        frame.scaled(&self.hello, &mut self.scaled);
        self.saturated = frame.saturated(&self.status);
        let channels = self.gauges.iter().zip(&self.scales);
        for (raw, (&channel, scale)) in raw.iter_mut().zip(channels) {
            *raw = self.scaled[channel] * scale;
        }
        Some(self.temperature.map(|channel| self.scaled[channel]))
    }

    /// The signals of the frame that was read last, into `signals`.
    pub(super) fn read_signals(&mut self, t_us: u64, signals: &mut Vec<(LoadSignal, f64)>) {
        self.signals.read(&self.scaled, t_us, signals);
    }

    /// The signals it has, in their order.
    pub(super) fn signals(&self) -> Vec<LoadSignal> {
        let mut signals = Vec::new();
        self.signals.clone().read(&self.scaled, 0, &mut signals);
        signals.into_iter().map(|(signal, _)| signal).collect()
    }

    pub(super) fn take_status(&mut self, status: Status) {
        self.status = status;
    }

    /// Gauges that the device says are saturated in the frame that was read last: its converter may
    /// have fewer bits than its numbers.
    pub(super) fn saturated(&self) -> impl Iterator<Item = usize> + '_ {
        let gauges = self.gauges.iter().enumerate();
        let gauges = gauges.filter(|(_, channel)| self.saturated >> **channel & 1 == 1);
        gauges.map(|(gauge, _)| gauge)
    }

    /// Step of each gauge's converter, µε; 0 where it sends real numbers.
    pub(super) fn steps_ue(&self) -> impl Iterator<Item = f64> + '_ {
        let is_counting = self.hello.format != SampleFormat::F32;
        self.units().map(move |(scale, _)| if is_counting { scale.abs() } else { 0.0 })
    }

    /// Lowest and highest reading that each gauge's numbers can have, µε; empty for real numbers.
    pub(super) fn rails_ue(&self) -> Vec<(f64, f64)> {
        let Some([low, high]) = self.hello.count_range() else {
            return Vec::new();
        };
        let ends = |(scale, offset): (f64, f64)| {
            let (a, b) = (low * scale + offset, high * scale + offset);
            (a.min(b), a.max(b))
        };
        self.units().map(ends).collect()
    }

    /// µε per count and offset of each gauge.
    fn units(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let gauges = self.gauges.iter().zip(&self.scales);
        gauges.map(|(&channel, scale)| {
            let channel = &self.hello.channels[channel];
            let of = |value: f32| f64::from(value) * scale;
            (of(channel.scale), of(channel.offset))
        })
    }
}

#[cfg(test)]
mod tests {
    use hapdef_daq::hdp1::FrameFlags;

    use super::*;

    fn gauges(names: &[&str]) -> Vec<LiveGauge> {
        let gauge = |name: &&str| LiveGauge { name: (*name).to_owned(), scale: 2.0 };
        names.iter().map(gauge).collect()
    }

    #[test]
    fn gauges_are_found_by_name_wherever_they_are() {
        let hello = Arc::new(Hello::plain(12, SampleFormat::I16, 500));
        let mut device =
            Device::new(hello, &gauges(&["g7", "g0", "g11"]), Some(3), 1000.0).unwrap();
        let frame = Frame::new(0, SampleFormat::I16, 0..12);
        let mut raw = [0.0; 3];
        assert_eq!(device.read(&frame, &mut raw), Some(None));
        assert_eq!(raw, [14.0, 0.0, 22.0]);
        assert_eq!(device.period_s, 2e-3);
        assert_eq!(device.rails_ue()[0], (-65536.0, 65534.0));
        let short = Frame::new(0, SampleFormat::I16, 0..11);
        assert_eq!(device.read(&short, &mut raw), None);
    }

    #[test]
    fn saturated_gauges_are_those_of_the_last_status_where_the_frame_says_so() {
        let hello = Arc::new(Hello::plain(12, SampleFormat::I16, 500));
        let mut device = Device::new(hello, &gauges(&["g7", "g0"]), Some(2), 1000.0).unwrap();
        device.take_status(Status { saturated: 1 << 7 | 1 << 3, ..Status::default() });
        let mut frame = Frame::new(0, SampleFormat::I16, 0..12);
        for (flags, expected) in [(FrameFlags::default(), 0), (FrameFlags::SATURATED, 1)] {
            frame.flags = flags;
            device.read(&frame, &mut [0.0; 2]).unwrap();
            assert_eq!(device.saturated().collect::<Vec<_>>(), vec![0; expected]);
        }
    }

    #[test]
    fn another_number_of_bridges_is_refused_in_words() {
        let hello = Arc::new(Hello::plain(12, SampleFormat::I16, 500));
        let fault = Device::new(hello, &gauges(&["a", "b"]), Some(2), 1000.0).unwrap_err();
        assert!(fault.contains("expected 2") && fault.contains("12"), "{fault}");
    }
}
