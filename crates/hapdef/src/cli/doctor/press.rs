//! A press near each gauge: does its own channel answer?

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use hapdef::SourceArg;
use hapdef_daq::{AcquireParams, Message, Receiver, acquire};

use super::channels::{Seen, bridges};
use super::check::Check;

/// A channel answers when it moves by so many standard deviations of its rest.
const ANSWER_SD: f64 = 12.0;
/// What counts as rest again.
const REST_SD: f64 = 6.0;
/// Rest that is measured first.
const REST: Duration = Duration::from_millis(500);
/// How long a press is followed after it was noticed.
const FOLLOW: Duration = Duration::from_millis(300);

/// Asks for a press near each gauge and says which channel answered.
pub(super) fn checks(
    source: &SourceArg,
    patience: Duration,
    gauges: Option<&[String]>,
    stop: &AtomicBool,
    ask: &dyn Fn(&str),
) -> Result<Vec<Check>> {
    let (_acquisition, mut receivers) = acquire(source.open()?, AcquireParams::default())?;
    let mut limb = Limb::at_rest(&mut receivers[0], patience)?;
    let mut checks = Vec::new();
    for (k, channel) in limb.channels.clone().into_iter().enumerate() {
        let name = match gauges.and_then(|names| names.get(k)) {
            Some(name) => name.clone(),
            None => limb.seen.name(channel),
        };
        if stop.load(Ordering::Relaxed) {
            break;
        }
        ask(&format!("press near gauge {name}, then let go"));
        let answered = limb.answer(patience, stop);
        checks.push(judge(&limb.seen, &name, channel, answered));
    }
    Ok(checks)
}

fn judge(seen: &Seen, gauge: &str, expected: usize, answered: Option<(usize, f64)>) -> Check {
    let name = format!("press near {gauge}");
    match answered {
        None => Check::bad(
            &name,
            "no channel answered",
            "press harder; if still none answers, the gauge is not wired",
        ),
        Some((channel, sd)) if channel == expected => {
            let found = format!("its channel answered, {sd:.0} times its noise");
            Check::ok(&name, found)
        }
        Some((channel, _)) => Check::bad(
            &name,
            format!(
                "channel {channel} ({}) answered, not {expected}",
                seen.name(channel)
            ),
            "swap the two wires or the gauges' order in the scene; press again right at the gauge",
        ),
    }
}

/// Readings by their rest.
struct Limb<'a> {
    receiver: &'a mut Receiver,
    seen: Seen,
    channels: Vec<usize>,
    /// Mean and standard deviation at rest, by channel.
    rest: Vec<[f64; 2]>,
}

impl<'a> Limb<'a> {
    fn at_rest(receiver: &'a mut Receiver, patience: Duration) -> Result<Self> {
        let mut limb = Self {
            receiver,
            seen: Seen::default(),
            channels: Vec::new(),
            rest: Vec::new(),
        };
        let start = Instant::now();
        let mut values: Vec<Vec<f64>> = Vec::new();
        let mut end = None;
        while end.is_none_or(|end| Instant::now() < end) {
            if end.is_none() && start.elapsed() > patience {
                bail!("no readings: hapdef doctor without --press-check says why");
            }
            let Some(frame) = limb.next(Duration::from_millis(50)) else {
                continue;
            };
            end.get_or_insert_with(|| Instant::now() + REST);
            values.push(frame);
        }
        limb.channels = bridges(&limb.seen).collect();
        let n_channels = values.iter().map(Vec::len).min().unwrap_or(0);
        limb.rest = (0..n_channels)
            .map(|i| mean_and_sd(values.iter().map(|frame| frame[i])))
            .collect();
        Ok(limb)
    }

    /// The channel that moved most, by its noise, and how much; waits until the limb rests again.
    fn answer(&mut self, patience: Duration, stop: &AtomicBool) -> Option<(usize, f64)> {
        let start = Instant::now();
        let mut best: Option<(usize, f64)> = None;
        let mut noticed: Option<Instant> = None;
        while start.elapsed() < patience && !stop.load(Ordering::Relaxed) {
            let Some(frame) = self.next(Duration::from_millis(50)) else {
                if self.receiver.has_ended() {
                    break;
                }
                continue;
            };
            let Some((channel, sd)) = self.most_moved(&frame) else {
                continue;
            };
            if sd >= ANSWER_SD {
                noticed.get_or_insert_with(Instant::now);
                if best.is_none_or(|(_, most)| sd > most) {
                    best = Some((channel, sd));
                }
            }
            let is_followed = noticed.is_some_and(|since| since.elapsed() >= FOLLOW);
            if is_followed && sd <= REST_SD {
                break;
            }
        }
        best
    }

    fn most_moved(&self, frame: &[f64]) -> Option<(usize, f64)> {
        let moved = self.channels.iter().filter_map(|&i| {
            let [mean, sd] = *self.rest.get(i)?;
            Some((i, (frame.get(i)? - mean).abs() / sd))
        });
        moved.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn next(&mut self, wait: Duration) -> Option<Vec<f64>> {
        match self.receiver.recv(wait)? {
            Message::Frame(frame) => {
                if self.seen.frames.is_empty() {
                    self.seen.frames.push(frame);
                }
                Some(frame.values().collect())
            }
            Message::Hello(hello) => {
                self.seen.hello = Some(hello);
                None
            }
            _ => None,
        }
    }
}

/// Mean and standard deviation; a channel without noise has one count.
fn mean_and_sd(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    let square: f64 = values.map(|v| (v - mean).powi(2)).sum();
    [mean, (square / n).sqrt().max(1.0)]
}
