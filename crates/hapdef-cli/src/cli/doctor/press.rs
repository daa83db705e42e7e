//! A press near each gauge: does its own channel answer?

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use hapdef::SourceArg;
use hapdef_daq::{AcquireParams, Message, Receiver, acquire};

use super::check::Check;
use super::expected::Expected;
use super::seen::Seen;

/// A channel answers when it moves by so many standard deviations of its rest.
const ANSWER_SD: f64 = 12.0;
/// What counts as rest again.
const REST_SD: f64 = 6.0;
/// Rest that is measured first.
const REST: Duration = Duration::from_millis(500);
/// How long a press is followed after it was noticed.
const FOLLOW: Duration = Duration::from_millis(300);

/// The gauges that are asked for.
#[derive(Default)]
pub(super) struct Known {
    /// Their names, if there is a scene or a bundle.
    pub(super) names: Option<Vec<String>>,
    /// What they should read, likewise.
    pub(super) expected: Option<Expected>,
}

/// Asks for a press near each gauge and says which channel answered.
pub(super) fn checks(
    source: &SourceArg,
    patience: Duration,
    known: &Known,
    stop: &AtomicBool,
    ask: &dyn Fn(&str),
) -> Result<Vec<Check>> {
    let (_acquisition, mut receivers) = acquire(source.open()?, AcquireParams::default())?;
    let mut limb = Limb::at_rest(&mut receivers[0], patience)?;
    let mut checks = Vec::new();
    let (names, channels): (Vec<String>, Vec<usize>) = match &known.names {
        Some(names) => (names.clone(), limb.seen.gauges(names)),
        None => {
            let names = limb.channels.iter().map(|&channel| limb.seen.name(channel));
            (names.collect(), limb.channels.clone())
        }
    };
    let expected = known.expected.as_ref();
    let expected = expected.filter(|_| names.len() == channels.len());
    for (gauge, name) in names.iter().enumerate().take(channels.len()) {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        ask(&format!("press near gauge {name}, then let go"));
        let answer = limb.answer(patience, stop);
        checks.push(match (answer, expected) {
            (None, _) => silent(name),
            (Some(answer), Some(expected)) => {
                let readings: Vec<f64> = channels.iter().map(|&c| answer.moved[c]).collect();
                let other = channels[expected.answering(gauge, &readings)];
                by_model(&limb.seen, name, channels[gauge], other)
            }
            (Some(answer), None) => by_size(&limb.seen, name, channels[gauge], &answer),
        });
    }
    Ok(checks)
}

fn silent(gauge: &str) -> Check {
    Check::bad(
        &format!("press near {gauge}"),
        "no channel answered",
        "press harder; if still none answers, the gauge is not wired",
    )
}

/// Whether the readings are those that the limb's model has for this press.
fn by_model(seen: &Seen, gauge: &str, expected: usize, answered: usize) -> Check {
    let name = format!("press near {gauge}");
    if answered == expected {
        return Check::ok(&name, "the channels answered as the model has it");
    }
    Check::bad(
        &name,
        format!("channel {answered} ({}) reads what {expected} should", seen.name(answered)),
        "swap the two wires or the gauges' order in the scene; press again right at the gauge",
    )
}

/// Without a model: the channel that moved most by its noise is mostly the gauge that was pressed.
fn by_size(seen: &Seen, gauge: &str, expected: usize, answer: &Answer) -> Check {
    let name = format!("press near {gauge}");
    let (channel, sd) = (answer.channel, answer.sd);
    if channel == expected {
        let found = format!("its channel answered, {sd:.0} times its noise");
        return Check::ok(&name, found);
    }
    Check::warn(
        &name,
        format!("channel {channel} ({}) answered most, not {expected}", seen.name(channel)),
        "press again right at the gauge; name the scene or the bundle, too, which know what a press there \
         does to each gauge",
    )
}

/// What a press did.
struct Answer {
    /// The channel that moved most by its noise, and how much.
    channel: usize,
    sd: f64,
    /// How far each channel moved then, in its unit.
    moved: Vec<f64>,
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
        let mut limb =
            Self { receiver, seen: Seen::default(), channels: Vec::new(), rest: Vec::new() };
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
        limb.rest =
            (0..n_channels).map(|i| mean_and_sd(values.iter().map(|frame| frame[i]))).collect();
        Ok(limb)
    }

    /// What the next press does at its strongest; waits until the limb rests again.
    fn answer(&mut self, patience: Duration, stop: &AtomicBool) -> Option<Answer> {
        let start = Instant::now();
        let mut best: Option<Answer> = None;
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
                if best.as_ref().is_none_or(|best| sd > best.sd) {
                    let moved = self.moved(&frame);
                    best = Some(Answer { channel, sd, moved });
                }
            }
            let is_followed = noticed.is_some_and(|since| since.elapsed() >= FOLLOW);
            if is_followed && sd <= REST_SD {
                break;
            }
        }
        best
    }

    /// How far each channel is from its rest, in its unit; 0 for those that have none.
    fn moved(&self, frame: &[f64]) -> Vec<f64> {
        let scale = |i: usize| {
            let hello = self.seen.hello.as_ref();
            let channel = hello.and_then(|hello| hello.channels.get(i));
            channel.map_or(1.0, |channel| f64::from(channel.scale))
        };
        let counts = frame.iter().enumerate().map(|(i, value)| {
            let rest = self.rest.get(i).map_or(*value, |[mean, _]| *mean);
            (value - rest) * scale(i)
        });
        counts.collect()
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
        let known = Known { names: Some(names.map(str::to_owned).to_vec()), expected: None };
        let checks = checks(&source, patience, &known, &never, &ask).unwrap();
        (checks, asked.into_inner().unwrap())
    }

    fn states(checks: &[Check]) -> Vec<State> {
        checks.iter().map(|check| check.state).collect()
    }

    #[test]
    fn a_channel_that_answers_most_for_another_is_told() {
        let (checks, asked) = checked([0, 2, 2], ["toe", "shin", "knee"]);
        assert_eq!(states(&checks), [State::Ok, State::Warn, State::Ok], "{checks:?}");
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
