//! Readings of a few seconds: rate, losses, dead and saturated channels.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;
use hapdef::SourceArg;
use hapdef_daq::hdp1::{ChannelKind, Hello, SampleFormat};
use hapdef_daq::source::{LinkState, SourceStats};
use hapdef_daq::{AcquireParams, Frame, Message, acquire};

use super::super::record::n_refused;
use super::check::Check;

/// Largest difference between the rate announced and the rate measured that is no fault.
const RATE_SLACK: f64 = 0.02;

/// What came in a few seconds.
#[derive(Clone, Debug, Default)]
pub(super) struct Seen {
    pub(super) hello: Option<Arc<Hello>>,
    pub(super) link: Option<LinkState>,
    pub(super) frames: Vec<Frame>,
    pub(super) stats: SourceStats,
}

pub(super) fn checks(
    source: &SourceArg,
    time: Duration,
    gauges: Option<&[String]>,
    stop: &AtomicBool,
) -> Result<Vec<Check>> {
    let seen = watch(source, time, stop)?;
    let mut checks = vec![link(&seen)];
    if seen.frames.is_empty() {
        return Ok(checks);
    }
    checks.extend([rate(&seen), losses(&seen)]);
    if let Some(gauges) = gauges {
        checks.push(layout(&seen, gauges));
    }
    checks.extend(each_channel(&seen));
    Ok(checks)
}

/// Reads a source for a while, from its first reading on.
fn watch(source: &SourceArg, time: Duration, stop: &AtomicBool) -> Result<Seen> {
    let (acquisition, mut receivers) = acquire(source.open()?, AcquireParams::default())?;
    let receiver = &mut receivers[0];
    let mut seen = Seen::default();
    let mut end = Instant::now() + time.max(Duration::from_secs(3));
    while !stop.load(Ordering::Relaxed) {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() || (receiver.has_ended() && acquisition.has_ended()) {
            while let Some(message) = receiver.try_recv() {
                seen.take(message);
            }
            break;
        }
        let Some(message) = receiver.recv(left) else {
            continue;
        };
        seen.take(message);
        if seen.frames.len() == 1 {
            end = Instant::now() + time;
        }
    }
    seen.stats = acquisition.stop().source;
    Ok(seen)
}

impl Seen {
    fn take(&mut self, message: Message) {
        match message {
            Message::Frame(frame) => self.frames.push(frame),
            Message::Hello(hello) => self.hello = Some(hello),
            Message::Link(state) => self.link = Some(state),
            _ => {}
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
}

fn link(seen: &Seen) -> Check {
    let n = seen.frames.len();
    if n > 0 {
        return Check::ok("link", format!("open, {n} readings"));
    }
    let state = seen.link.as_ref().map(ToString::to_string);
    let found = match (&seen.link, &seen.hello) {
        (Some(LinkState::Open), Some(_)) => "the device describes itself but sends no readings",
        (Some(LinkState::Open), None) => "open, but nothing comes",
        _ => "no readings",
    };
    let fix = state.filter(|_| !matches!(seen.link, Some(LinkState::Open)));
    let fix = fix.unwrap_or_else(|| "is the device on, does its firmware run (its reset)?".into());
    Check::bad("link", found, fix)
}

fn rate(seen: &Seen) -> Check {
    let times = |f: Option<&Frame>| f.map_or(0, |frame| frame.t_host_ns);
    let span_ns = times(seen.frames.last()).saturating_sub(times(seen.frames.first()));
    let n_lost: u64 = seen.frames.iter().map(|f| u64::from(f.n_lost_before)).sum();
    let n_scans = seen.hello.as_ref().map_or(1, |h| u64::from(h.n_scans));
    let n = (seen.frames.len() as u64 + n_lost * n_scans).saturating_sub(1);
    let hz = n as f64 / (span_ns as f64 * 1e-9).max(1e-9);
    let announced = seen
        .hello
        .as_ref()
        .map_or(0.0, |h| f64::from(h.rate_mhz) * 1e-3);
    if announced <= 0.0 {
        return Check::ok("rate", format!("{hz:.1} Hz; the device announces none"));
    }
    let found = format!("{hz:.1} Hz, the device announces {announced:.1}");
    if (hz / announced - 1.0).abs() <= RATE_SLACK {
        return Check::ok("rate", found);
    }
    Check::warn(
        "rate",
        found,
        "fewer: the link or the converter is too slow for it, lower the rate or raise the baud; \
         more: the device's clock is off",
    )
}

fn losses(seen: &Seen) -> Check {
    let (lost, refused) = (seen.stats.losses.n_lost, n_refused(&seen.stats));
    let found = format!("{lost} packets lost, {refused} refused");
    if lost + refused == 0 {
        return Check::ok("losses", found);
    }
    let of = lost + seen.stats.losses.n_delivered;
    let share = lost as f64 / of.max(1) as f64;
    let fix = "shorter cable, no hub, another USB port; on a serial line check the baud";
    if share > 0.01 {
        Check::bad("losses", found, fix)
    } else {
        Check::warn("losses", found, fix)
    }
}

/// Whether the channels are the scene's gauges.
fn layout(seen: &Seen, gauges: &[String]) -> Check {
    let n_bridges = bridges(seen).count();
    if n_bridges != gauges.len() {
        return Check::bad(
            "gauges",
            format!(
                "{n_bridges} bridge channels, the scene has {}",
                gauges.len()
            ),
            "wire a gauge to each channel in the scene's order, mark the others as unused in the \
             firmware, or correct gauges.sites",
        );
    }
    let differing = bridges(seen).zip(gauges).find(|(channel, gauge)| {
        let name = seen.name(*channel);
        !name.starts_with("channel ") && name != gauge.chars().take(4).collect::<String>()
    });
    match differing {
        None => Check::ok("gauges", format!("{n_bridges}, as in the scene")),
        Some((channel, gauge)) => Check::warn(
            "gauges",
            format!(
                "channel {channel} is called {}, the scene's is {gauge}",
                seen.name(channel)
            ),
            "is the order right? hapdef doctor --press-check tells",
        ),
    }
}

/// Channels with a gauge.
pub(super) fn bridges(seen: &Seen) -> impl Iterator<Item = usize> + '_ {
    use ChannelKind as K;
    let n = seen.frames.first().map_or(0, |frame| frame.bits().len());
    (0..n).filter(|&i| {
        let channel = seen.hello.as_ref().and_then(|h| h.channels.get(i));
        channel.is_none_or(|c| matches!(c.kind, K::QuarterBridge | K::HalfBridge | K::FullBridge))
    })
}

/// Channels that say nothing or are at the end of their range.
fn each_channel(seen: &Seen) -> Vec<Check> {
    let mut checks = Vec::new();
    let mut n_good = 0;
    for channel in bridges(seen) {
        let values: Vec<f64> = seen
            .frames
            .iter()
            .filter_map(|frame| frame.values().nth(channel))
            .collect();
        let name = format!("channel {channel} ({})", seen.name(channel));
        let format = seen.frames[0].format;
        match fault(&values, format) {
            Some((found, fix)) => checks.push(Check::bad(&name, found, fix)),
            None => n_good += 1,
        }
    }
    if n_good > 0 {
        let found = format!("{n_good} move and stay within their range");
        checks.push(Check::ok("channels", found));
    }
    checks
}

fn fault(values: &[f64], format: SampleFormat) -> Option<(String, &'static str)> {
    if let Some(bad) = values.iter().find(|v| !v.is_finite()) {
        return Some((format!("sends {bad}"), "mend the firmware's scaling"));
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let [least, most] = range(format);
    let n_ends = values
        .iter()
        .filter(|v| **v <= least || **v >= most)
        .count();
    if n_ends * 100 >= values.len() {
        let found = format!("saturated in {n_ends} of {} readings", values.len());
        let fix = "balance the bridge or lower the gain; a broken gauge or wire saturates, too";
        return Some((found, fix));
    }
    (values.len() > 1 && low == high).then(|| {
        let fix = "no noise at all: is the gauge wired, the amplifier on, the converter's input \
                   the right one?";
        (format!("always {low}"), fix)
    })
}

/// Ends of a format's range; lines of the sketch have 12 bits.
fn range(format: SampleFormat) -> [f64; 2] {
    match format {
        SampleFormat::I16 => [f64::from(i16::MIN), f64::from(i16::MAX)],
        SampleFormat::U16 => [0.0, 65535.0],
        SampleFormat::I24 => [-8_388_608.0, 8_388_607.0],
        SampleFormat::I32 => [f64::from(i32::MIN), f64::from(i32::MAX)],
        SampleFormat::F32 => [f64::NEG_INFINITY, f64::INFINITY],
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::State;
    use super::*;

    fn seen(samples: &[[i32; 3]], hz: u32) -> Seen {
        let frames = samples.iter().zip(0u32..).map(|(values, i)| {
            let mut frame = Frame::new(i, SampleFormat::I16, *values);
            frame.t_host_ns = u64::from(i) * 1_000_000_000 / u64::from(hz);
            frame
        });
        Seen {
            frames: frames.collect(),
            hello: Some(Arc::new(Hello::plain(3, SampleFormat::I16, 1000))),
            ..Seen::default()
        }
    }

    #[test]
    fn dead_and_saturated_channels_are_told_apart() {
        let samples: Vec<[i32; 3]> = (0..100).map(|i| [i % 7, 42, 32767 - i % 2]).collect();
        let checks = each_channel(&seen(&samples, 1000));
        assert_eq!(checks.len(), 3);
        assert!(checks[0].found.starts_with("always 42"), "{}", checks[0]);
        assert_eq!(checks[1].found, "saturated in 50 of 100 readings");
        assert!(checks[1].name.contains("G2"));
        assert_eq!(checks[2].state, State::Ok);
    }

    #[test]
    fn a_rate_other_than_announced_is_seen() {
        let samples = vec![[1, 2, 3]; 101];
        assert_eq!(rate(&seen(&samples, 1000)).state, State::Ok);
        assert_eq!(rate(&seen(&samples, 800)).state, State::Warn);
    }

    #[test]
    fn channels_are_compared_with_the_scene() {
        let seen = seen(&[[1, 2, 3], [2, 3, 4]], 1000);
        let names = |list: &[&str]| list.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        assert_eq!(layout(&seen, &names(&["G0", "G1", "G2"])).state, State::Ok);
        assert_eq!(
            layout(&seen, &names(&["G0", "G2", "G1"])).state,
            State::Warn
        );
        assert_eq!(layout(&seen, &names(&["G0"])).state, State::Bad);
    }
}
