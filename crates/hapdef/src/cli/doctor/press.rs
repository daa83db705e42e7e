//! A press near each gauge: does its own channel answer?

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use hapdef::SourceArg;
use hapdef_daq::{AcquireParams, Message, Receiver, acquire};

use super::check::Check;
use super::seen::Seen;

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
    let asked: Vec<(String, usize)> = match gauges {
        Some(names) => names.iter().cloned().zip(limb.seen.gauges(names)).collect(),
        None => {
            let own = limb.channels.iter();
            own.map(|&channel| (limb.seen.name(channel), channel))
                .collect()
        }
    };
    for (name, channel) in asked {
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
        limb.channels = limb.seen.bridges().collect();
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
        let message = self.receiver.recv(wait)?;
        self.seen.take(&message);
        match message {
            Message::Frame(frame) => Some(frame.values().collect()),
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use hapdef_daq::Frame;
    use hapdef_daq::hdp1::{Hello, SampleFormat};
    use hapdef_daq::record::{RecordParams, record};
    use hapdef_daq::source::ReplaySource;

    use super::super::check::State;
    use super::*;

    /// Readings of three gauges: presses at 1 s, 2 s and 3 s, answered by these channels.
    fn pressed(answers: [usize; 3]) -> impl Iterator<Item = Message> + Send {
        let hello = Message::Hello(Arc::new(Hello::plain(3, SampleFormat::I16, 1000)));
        let frames = (0..4000u32).map(move |i| {
            let noise = |k: u32| ((i.wrapping_mul(2_654_435_761) >> (k + 8)) % 9) as i32 - 4;
            let mut samples = [noise(0), noise(3), noise(6)];
            let (press, at) = (i as usize / 1000, i % 1000);
            if press > 0 && at < 300 {
                samples[answers[press - 1]] += 400;
                // The others feel it, too.
                samples[(answers[press - 1] + 1) % 3] -= 90;
            }
            let mut frame = Frame::new(i, SampleFormat::I16, samples);
            frame.t_host_ns = u64::from(i) * 1_000_000;
            Message::Frame(frame)
        });
        std::iter::once(hello).chain(frames)
    }

    /// What is said and asked when gauges of these names are pressed one after the other, and these
    /// channels answer.
    fn checked(answers: [usize; 3], names: [&str; 3]) -> (Vec<Check>, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("presses.mcap");
        let source = ReplaySource::new("made up", pressed(answers), f64::INFINITY);
        let (_acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
        let recorder = record(receivers.remove(0), &path, RecordParams::default()).unwrap();
        while recorder.stats().n_frames < 4000 {
            std::thread::sleep(Duration::from_millis(5));
        }
        recorder.finish().unwrap();
        let source: SourceArg = format!("replay:{}@1", path.display()).parse().unwrap();
        let asked = std::sync::Mutex::new(Vec::new());
        let ask = |text: &str| asked.lock().unwrap().push(text.to_owned());
        let never = AtomicBool::new(false);
        let patience = Duration::from_secs(5);
        let names = names.map(str::to_owned);
        let checks = checks(&source, patience, Some(&names), &never, &ask).unwrap();
        (checks, asked.into_inner().unwrap())
    }

    fn states(checks: &[Check]) -> Vec<State> {
        checks.iter().map(|check| check.state).collect()
    }

    #[test]
    fn a_channel_that_answers_for_another_is_found() {
        let (checks, asked) = checked([0, 2, 2], ["toe", "shin", "knee"]);
        assert_eq!(
            states(&checks),
            [State::Ok, State::Bad, State::Ok],
            "{checks:?}"
        );
        assert!(checks[1].found.contains("channel 2 (G2)"), "{}", checks[1]);
        assert_eq!(asked.len(), 3);
    }

    #[test]
    fn gauges_in_another_order_answer_on_the_channels_of_their_names() {
        let (checks, asked) = checked([2, 0, 1], ["g2", "g0", "g1"]);
        assert_eq!(states(&checks), [State::Ok; 3], "{checks:?}");
        assert!(asked[0].contains("near gauge g2"), "{asked:?}");
    }
}
