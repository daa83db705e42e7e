//! Readings of a few seconds: rate, losses, dead and saturated channels.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;
use hapdef::SourceArg;
use hapdef_daq::source::LinkState;
use hapdef_daq::{AcquireParams, acquire};

use super::super::record::n_refused;
use super::check::Check;
use super::seen::Seen;

/// Largest difference between the rate announced and the rate measured that is no fault.
const RATE_SLACK: f64 = 0.02;

/// Where channels move by so many steps of the converter at rest, some may not move at all.
const FEW_STEPS: f64 = 3.0;

pub(super) fn checks(
    source: &SourceArg,
    time: Duration,
    gauges: Option<&[String]>,
    stop: &AtomicBool,
) -> Result<Vec<Check>> {
    let seen = watch(source, time, stop)?;
    let mut checks = vec![link(&seen)];
    if seen.n_frames == 0 {
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
                seen.take(&message);
            }
            break;
        }
        let Some(message) = receiver.recv(left) else {
            continue;
        };
        seen.take(&message);
        if seen.n_frames == 1 {
            end = Instant::now() + time;
        }
    }
    seen.stats = acquisition.stop().source;
    Ok(seen)
}

fn link(seen: &Seen) -> Check {
    let n = seen.n_frames;
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
    let span_ns = seen.span_ns.map_or(0, |(a, b)| b.saturating_sub(a));
    let n_scans = seen.hello.as_ref().map_or(1, |h| u64::from(h.n_scans));
    let n = (seen.n_frames as u64 + seen.n_lost * n_scans).saturating_sub(1);
    let hz = n as f64 / (span_ns as f64 * 1e-9).max(1e-9);
    let announced = seen.hello.as_ref().map_or(0.0, |h| f64::from(h.rate_mhz) * 1e-3);
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
    if share > 0.01 { Check::bad("losses", found, fix) } else { Check::warn("losses", found, fix) }
}

/// Whether the channels are the scene's gauges.
fn layout(seen: &Seen, gauges: &[String]) -> Check {
    let n_bridges = seen.bridges().count();
    if n_bridges != gauges.len() {
        return Check::bad(
            "gauges",
            format!("{n_bridges} bridge channels, the scene has {}", gauges.len()),
            "wire a gauge to each channel in the scene's order, mark the others as unused in the \
             firmware, or correct gauges.sites",
        );
    }
    let channels = seen.gauges(gauges);
    let is_other = |(channel, gauge): &(usize, &String)| {
        let name = seen.name(*channel);
        let short: String = gauge.chars().take(4).collect();
        !name.starts_with("channel ") && !name.eq_ignore_ascii_case(&short)
    };
    let differing = channels.iter().copied().zip(gauges).find(is_other);
    if let Some((channel, gauge)) = differing {
        return Check::warn(
            "gauges",
            format!(
                "channel {channel} is called {}, the scene's is {gauge}: gauges go by order",
                seen.name(channel)
            ),
            "is the order right? hapdef doctor --press-check tells",
        );
    }
    let how = if channels.is_sorted() { "as in the scene" } else { "found by their names" };
    Check::ok("gauges", format!("{n_bridges}, {how}"))
}

/// Channels that say nothing or are at the end of their range.
fn each_channel(seen: &Seen) -> Vec<Check> {
    let mut checks = Vec::new();
    let mut n_good = 0;
    for channel in seen.bridges() {
        let name = format!("channel {channel} ({})", seen.name(channel));
        match fault(seen, channel) {
            Some((found, fix)) => checks.push(Check::bad(&name, found, fix)),
            None if is_still(seen, channel) => checks.push(still(seen, channel, &name)),
            None => n_good += 1,
        }
    }
    if seen.n_flagged > 0 && seen.saturated == 0 {
        let found = format!("{} readings say that one is saturated", seen.n_flagged);
        let fix = "STATUS did not come, or does not say which: look for longer, with --seconds";
        checks.push(Check::warn("saturation", found, fix));
    }
    if n_good > 0 {
        let found = format!("{n_good} move and stay within their range");
        checks.push(Check::ok("channels", found));
    }
    checks
}

fn fault(seen: &Seen, channel: usize) -> Option<(String, &'static str)> {
    const SATURATED: &str =
        "balance the bridge or lower the gain; a broken gauge or wire saturates, too";
    let span = &seen.channels[channel];
    if let Some(bad) = span.not_finite {
        return Some((format!("sends {bad}"), "mend the firmware's scaling"));
    }
    let n = seen.n_frames;
    let range = seen.hello.as_ref().and_then(|hello| hello.count_range());
    let n_ends = range.map_or(0, |range| span.n_at_ends(range));
    if n_ends * 100 >= n {
        return Some((format!("saturated in {n_ends} of {n} readings"), SATURATED));
    }
    if channel < 64 && seen.saturated >> channel & 1 == 1 && seen.n_flagged > 0 {
        let n_most = seen.n_flagged;
        let found = format!("saturated, says the device, in at most {n_most} of {n} readings");
        return Some((found, SATURATED));
    }
    None
}

/// Whether a channel never moved.
fn is_still(seen: &Seen, channel: usize) -> bool {
    let span = &seen.channels[channel];
    seen.n_frames > 1 && span.low.total_cmp(&span.high).is_eq()
}

/// What to say of a channel that never moved: others tell whether noise reaches over a step.
fn still(seen: &Seen, channel: usize, name: &str) -> Check {
    let found = format!("always {}", seen.channels[channel].low);
    let others = seen.bridges().filter(|&i| !is_still(seen, i));
    let mut spans: Vec<f64> =
        others.map(|i| seen.channels[i].high - seen.channels[i].low).collect();
    spans.sort_unstable_by(f64::total_cmp);
    if spans.get(spans.len() / 2).is_some_and(|span| *span <= FEW_STEPS) {
        return Check::warn(
            name,
            found,
            "others move by few steps of the converter, too, so it may be well: --press-check shows \
             whether it answers",
        );
    }
    let fix = "no noise at all: is the gauge wired, the amplifier on, the converter's input the right \
               one?";
    Check::bad(name, found, fix)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use hapdef_daq::hdp1::{Hello, SampleFormat};
    use hapdef_daq::{Frame, Message};

    use super::super::check::State;
    use super::*;

    fn seen(samples: &[[i32; 3]], hz: u32) -> Seen {
        let mut seen = Seen {
            hello: Some(Arc::new(Hello::plain(3, SampleFormat::I16, 1000))),
            ..Seen::default()
        };
        for (values, i) in samples.iter().zip(0u32..) {
            let mut frame = Frame::new(i, SampleFormat::I16, *values);
            frame.t_host_ns = u64::from(i) * 1_000_000_000 / u64::from(hz);
            seen.take(&Message::Frame(frame));
        }
        seen
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
    fn a_channel_whose_noise_is_below_a_step_may_be_well() {
        let samples: Vec<[i32; 3]> = (0..100).map(|i| [i % 2, 0, i % 3 - 1]).collect();
        let checks = each_channel(&seen(&samples, 1000));
        assert_eq!(checks[0].state, State::Warn, "{}", checks[0]);
        assert!(checks[0].to_string().contains("press-check"), "{}", checks[0]);
        assert_eq!(checks[1].state, State::Ok);
    }

    #[test]
    fn a_converter_of_fewer_bits_saturates_where_the_device_says_so() {
        let samples: Vec<[i32; 3]> = (0..200).map(|i| [i % 7, (40 * i).min(2047), i % 5]).collect();
        let mut seen = seen(&samples, 1000);
        assert_eq!(each_channel(&seen).len(), 1);
        seen.n_flagged = 148;
        let words: Vec<String> = each_channel(&seen).iter().map(ToString::to_string).collect();
        assert!(words[0].contains("say that one is saturated"), "{words:?}");
        seen.saturated = 2;
        let checks = each_channel(&seen);
        assert_eq!(checks.len(), 2);
        assert!(checks[0].name.contains("G1"), "{}", checks[0]);
        assert!(checks[0].found.contains("at most 148 of 200"), "{}", checks[0]);
    }

    #[test]
    fn a_line_at_the_top_of_12_bits_is_saturated_not_dead() {
        let mut seen = Seen { hello: Some(Arc::new(Hello::of_lines(2))), ..Seen::default() };
        for i in 0..100 {
            let frame = Frame::new(i, SampleFormat::U16, [4095, (i % 9) as i32 + 1]);
            seen.take(&Message::Frame(frame));
        }
        let checks = each_channel(&seen);
        assert_eq!(checks[0].found, "saturated in 100 of 100 readings");
        assert_eq!((checks.len(), checks[1].state), (2, State::Ok));
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
        let checked = |list: &[&str]| layout(&seen, &names(list));
        assert_eq!(checked(&["g0", "g1", "g2"]).state, State::Ok);
        let turned = checked(&["g0", "g2", "g1"]);
        assert_eq!(turned.state, State::Ok, "{turned}");
        assert!(turned.found.contains("by their names"), "{turned}");
        let others = checked(&["g0", "toe", "g1"]);
        assert_eq!(others.state, State::Warn, "{others}");
        assert!(others.found.contains("channel 1 is called G1"), "{others}");
        assert_eq!(checked(&["g0"]).state, State::Bad);
    }
}
