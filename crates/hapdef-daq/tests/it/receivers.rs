//! Receivers that are too slow: every loss is counted, what the device is is not forgotten, and a
//! reader that breaks down is no normal end.

use std::sync::Arc;
use std::time::{Duration, Instant};

use hapdef_daq::hdp1::{Hello, SampleFormat, Status};
use hapdef_daq::source::{FrameSource, ReplaySource, SourceStats, SourceStatus};
use hapdef_daq::{AcquireParams, Frame, Message, Receiver, acquire};

fn frame(seq: u32, n_lost_before: u32) -> Message {
    let mut frame = Frame::new(seq, SampleFormat::I16, [1]);
    frame.n_lost_before = n_lost_before;
    Message::Frame(frame)
}

fn params(ring_len: usize) -> AcquireParams {
    AcquireParams { ring_len, ..AcquireParams::default() }
}

/// Everything that comes until the end, slowly at first.
fn everything(receiver: &mut Receiver, pause: Duration) -> Vec<Message> {
    std::thread::sleep(pause);
    std::iter::from_fn(|| receiver.recv(Duration::from_secs(5))).collect()
}

/// Packets lost on the link and frames dropped, as the frames report them.
fn counts(messages: &[Message]) -> (u64, u64, u64) {
    let (mut n, mut n_lost, mut n_dropped) = (0, 0, 0);
    for message in messages {
        if let Message::Frame(frame) = message {
            n += 1;
            n_lost += u64::from(frame.n_lost_before);
            n_dropped += u64::from(frame.n_dropped_before);
        }
    }
    (n, n_lost, n_dropped)
}

/// A source that waits for its receiver before the last frame.
struct Pausing {
    messages: Vec<Message>,
    last: Option<Message>,
}

impl FrameSource for Pausing {
    fn poll(&mut self, _: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        if self.messages.is_empty() {
            std::thread::sleep(Duration::from_millis(400));
            self.last.take().into_iter().for_each(sink);
            return SourceStatus::Ended;
        }
        self.messages.drain(..).for_each(sink);
        SourceStatus::Open
    }

    fn stats(&self) -> SourceStats {
        SourceStats::default()
    }

    fn name(&self) -> String {
        "pausing".to_owned()
    }
}

#[test]
fn what_was_lost_before_a_dropped_frame_is_reported_by_the_next() {
    // Every third packet is lost on the link; the ring has room for 10.
    let source = Pausing {
        messages: (0..100).map(|i| frame(3 * i / 2, u32::from(i % 2 == 0))).collect(),
        last: Some(frame(1000, 7)),
    };
    let (acquisition, mut receivers) = acquire(source, params(10)).unwrap();
    let messages = everything(&mut receivers[0], Duration::from_millis(200));
    let (n, n_lost, n_dropped) = counts(&messages);
    assert_eq!((n, n_dropped, n_lost), (11, 90, 57));
    assert_eq!(receivers[0].n_dropped(), 90);
    assert!(!acquisition.stop().is_panicked);
}

#[test]
fn what_the_device_is_survives_a_receiver_that_stalls() {
    let hello = Arc::new(Hello::plain(1, SampleFormat::I16, 1000));
    let status = || Message::Status(Status::default());
    let messages: Vec<Message> = std::iter::repeat_with(status)
        .take(40)
        .chain([Message::Restarted, Message::Hello(hello)])
        .chain(std::iter::repeat_with(status).take(200))
        .collect();
    let n = messages.len() as u64;
    let source = ReplaySource::new("made up", messages.into_iter(), f64::INFINITY);
    let (_acquisition, mut receivers) = acquire(source, params(4)).unwrap();
    let messages = everything(&mut receivers[0], Duration::from_millis(100));
    let n_hellos = messages.iter().filter(|m| matches!(m, Message::Hello(_)));
    assert_eq!(n_hellos.count(), 1);
    let n_restarts = messages.iter().filter(|m| matches!(m, Message::Restarted));
    assert_eq!(n_restarts.count(), 1);
    assert_eq!(messages.len() as u64 + receivers[0].n_events_dropped(), n);
    assert_eq!(messages.len(), 4 + 64);
}

#[test]
fn a_receiver_that_never_looks_delays_the_end_a_moment_only() {
    let messages = std::iter::repeat_with(|| Message::Restarted).take(50);
    let source = ReplaySource::new("made up", messages, f64::INFINITY);
    let (acquisition, receivers) = acquire(source, params(10)).unwrap();
    let start = Instant::now();
    while !acquisition.has_ended() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(start.elapsed() < Duration::from_secs(3));
    assert_eq!(receivers[0].n_events_dropped(), 40);
}

/// A source with a mistake in it.
struct Broken;

impl FrameSource for Broken {
    fn poll(&mut self, _: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        sink(frame(0, 0));
        panic!("a mistake that this test makes");
    }

    fn stats(&self) -> SourceStats {
        SourceStats::default()
    }

    fn name(&self) -> String {
        "broken".to_owned()
    }
}

#[test]
fn a_reader_that_panics_has_ended_and_says_so() {
    let (acquisition, mut receivers) = acquire(Broken, params(10)).unwrap();
    assert_eq!(everything(&mut receivers[0], Duration::ZERO).len(), 1);
    assert!(acquisition.has_ended());
    assert!(acquisition.stats().is_panicked);
    assert!(acquisition.stop().is_panicked);
}
