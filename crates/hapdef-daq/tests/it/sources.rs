//! Sources without hardware: memory, TCP, CSV lines, replay.

use crate::support;

use std::io::{Read, Write};
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use hapdef_daq::clock::HostClock;
use hapdef_daq::hdp1::{Encoder, FrameFlags, Header, Hello, SampleFormat};
use hapdef_daq::source::{
    FrameSource, LinkFault, LinkState, Protocol, ReplaySource, SourceStatus, StreamParams,
    StreamSource, TcpLink, memory_link,
};
use hapdef_daq::{AcquireParams, Frame, Message, acquire};
use support::{Device, is_right, wait_for};

const SECOND: Duration = Duration::from_secs(1);

/// A clock that tests set.
#[derive(Default)]
struct FakeClock {
    now_ns: AtomicU64,
    wall_step_ns: AtomicI64,
}

impl HostClock for FakeClock {
    fn now_ns(&self) -> u64 {
        self.now_ns.load(Ordering::Relaxed)
    }

    fn wall_ns(&self) -> u64 {
        let step = self.wall_step_ns.load(Ordering::Relaxed);
        (1_800_000_000_000_000_000 + self.now_ns()).saturating_add_signed(step)
    }
}

fn poll(source: &mut impl FrameSource) -> Vec<Message> {
    let mut messages = Vec::new();
    source.poll(Duration::ZERO, &mut |message| messages.push(message));
    messages
}

fn frames(messages: &[Message]) -> Vec<Frame> {
    let frame = |message: &Message| match message {
        Message::Frame(frame) => Some(*frame),
        _ => None,
    };
    messages.iter().filter_map(frame).collect()
}

#[test]
fn a_devices_frames_arrive_scaled_and_timed() {
    let (link, device) = memory_link();
    let clock = Arc::new(FakeClock::default());
    let params = StreamParams { clock: clock.clone(), ..StreamParams::default() };
    let mut source = StreamSource::new(link, params);
    assert!(matches!(poll(&mut source)[..], [Message::Link(LinkState::Open)]));
    assert!(device.receive().len() > 40, "GET_HELLO and START");
    let mut sim = Device::new(3, SampleFormat::I24);
    sim.hello.channels[1].scale = 0.5;
    sim.hello.channels[1].offset = -3.0;
    sim.hello.seal();
    let (mut got, mut bytes) = (Vec::new(), Vec::new());
    for i in 0..5000u64 {
        // An hour back and forth on the wall does nothing to mapped times.
        clock.wall_step_ns.store(3_600_000_000_000 * (i as i64 % 3 - 1), Ordering::Relaxed);
        clock.now_ns.store(1_000_000 * i + 300_000, Ordering::Relaxed);
        bytes.clear();
        sim.tick(&mut bytes);
        device.send(&bytes);
        got.extend(frames(&poll(&mut source)));
    }
    assert_eq!(got.len(), 5000);
    assert!(got.iter().all(is_right));
    assert!(got.is_sorted_by(|a, b| a.t_host_ns < b.t_host_ns));
    assert!(got[4999].t_host_ns.abs_diff(4_999_300_000) < 1000);
    let mut scaled = [0.0; 3];
    assert_eq!(got[7].scaled(&sim.hello, &mut scaled), 3);
    let raw: Vec<f64> = got[7].values().collect();
    assert_eq!(scaled, [raw[0], raw[1] * 0.5 - 3.0, raw[2]]);
    let stats = source.stats();
    assert_eq!((stats.n_frames, stats.losses.n_lost), (5000, 0));
    assert!((stats.rate_hz - 1000.0).abs() < 2.0, "{}", stats.rate_hz);
    let end = source.poll(Duration::ZERO, &mut |_| {});
    assert_eq!(end, SourceStatus::Open);
    device.end();
    assert_eq!(source.poll(Duration::ZERO, &mut |_| {}), SourceStatus::Ended);
}

#[test]
fn what_is_missed_while_unplugged_is_counted() {
    let (link, device) = memory_link();
    let source = StreamSource::new(link, StreamParams::default());
    let (acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
    let receiver = &mut receivers[0];
    let mut sim = Device::new(4, SampleFormat::I16);
    let mut bytes = Vec::new();
    let open = |m: &Message| matches!(m, Message::Link(LinkState::Open)).then_some(());
    wait_for(receiver, SECOND, open);
    (0..10).for_each(|_| sim.tick(&mut bytes));
    device.send(&bytes);
    wait_for(receiver, SECOND, |m| matches!(m, Message::Frame(f) if f.seq == 9).then_some(()));
    device.unplug();
    wait_for(receiver, SECOND, |m| {
        matches!(m, Message::Link(LinkState::Away(LinkFault::Disconnected { .. }))).then_some(())
    });
    bytes.clear();
    (0..7).for_each(|_| sim.tick(&mut bytes));
    device.send(&bytes);
    device.replug();
    wait_for(receiver, SECOND, open);
    bytes.clear();
    sim.tick(&mut bytes);
    device.send(&bytes);
    let lost = wait_for(receiver, SECOND, |m| match m {
        Message::Frame(frame) => Some((frame.seq, frame.n_lost_before)),
        _ => None,
    });
    assert_eq!(lost, (17, 7));
    let stats = acquisition.stop();
    let losses = stats.source.losses;
    assert_eq!((losses.n_delivered, losses.n_lost), (11, 7));
    assert_eq!(stats.source.n_opened, 2);
}

#[test]
fn a_reset_is_reported_and_time_goes_on() {
    let (link, device) = memory_link();
    let mut source = StreamSource::new(link, StreamParams::default());
    poll(&mut source);
    let mut sim = Device::new(1, SampleFormat::I16);
    let mut bytes = Vec::new();
    (0..50).for_each(|_| sim.tick(&mut bytes));
    sim.reset();
    (0..5).for_each(|_| sim.tick(&mut bytes));
    device.send(&bytes);
    let messages = poll(&mut source);
    let restarts = messages.iter().filter(|m| matches!(m, Message::Restarted));
    assert_eq!(restarts.count(), 1);
    let got = frames(&messages);
    assert!(got.is_sorted_by(|a, b| a.t_host_ns <= b.t_host_ns));
    let lost: u32 = got.iter().map(|f| f.n_lost_before).sum();
    assert_eq!((got.len(), lost), (55, 0));
}

#[test]
fn a_slow_receiver_loses_and_the_fast_one_does_not() {
    let (link, device) = memory_link();
    let params = AcquireParams { n_receivers: 2, ring_len: 100, realtime_priority: None };
    let source = StreamSource::new(link, StreamParams::default());
    let (acquisition, mut receivers) = acquire(source, params).unwrap();
    let mut sim = Device::new(2, SampleFormat::I16);
    let mut n_fast = 0;
    wait_for(&mut receivers[0], SECOND, |m| matches!(m, Message::Link(_)).then_some(()));
    for _ in 0..500 {
        let mut bytes = Vec::new();
        sim.tick(&mut bytes);
        device.send(&bytes);
        n_fast += wait_for(&mut receivers[0], SECOND, |m| match m {
            Message::Frame(frame) => Some(1 + frame.n_dropped_before + frame.n_lost_before),
            _ => None,
        });
    }
    assert_eq!((n_fast, receivers[0].n_dropped()), (500, 0));
    let slow = &mut receivers[1];
    let mut n_slow = std::iter::from_fn(|| slow.try_recv())
        .filter(|m| matches!(m, Message::Frame(_)))
        .count() as u64;
    let mut bytes = Vec::new();
    sim.tick(&mut bytes);
    device.send(&bytes);
    let last = wait_for(slow, SECOND, |m| match m {
        Message::Frame(frame) => Some(*frame),
        _ => None,
    });
    n_slow += 1;
    assert_eq!(n_slow + u64::from(last.n_dropped_before), 501);
    assert_eq!(slow.n_dropped(), u64::from(last.n_dropped_before));
    device.end();
    assert!(slow.recv(SECOND).is_none_or(|m| matches!(m, Message::Link(_))));
    drop(acquisition);
}

#[test]
fn garbage_and_silence_say_what_to_try() {
    let clock = Arc::new(FakeClock::default());
    let mut words = Vec::new();
    let cases: [(&[u8], Protocol); 5] = [
        (b"", Protocol::Hdp1),
        (b"\x91\x00\xf3\x80\xfe", Protocol::Hdp1),
        (b"12,13,14\r\n", Protocol::Hdp1),
        (b"12,13,14\r\n", Protocol::Csv { n_channels: 10 }),
        (b"\xf3\x80\xfe", Protocol::Csv { n_channels: 10 }),
    ];
    for (bytes, protocol) in cases {
        let (link, device) = memory_link();
        let params = StreamParams { protocol, clock: clock.clone() };
        let mut source = StreamSource::new(link, params);
        poll(&mut source);
        let mut said = None;
        for ms in 0..3000 {
            clock.now_ns.fetch_add(1_000_000, Ordering::Relaxed);
            device.send(bytes);
            for message in poll(&mut source) {
                if let Message::Link(state) = message {
                    said.get_or_insert((ms, state.to_string()));
                }
            }
        }
        let (ms, text) = said.unwrap();
        assert!(ms < 3000);
        words.push(text);
    }
    for (text, word) in
        words.iter().zip(["no bytes", "baud", "as CSV", "lines of 3 numbers come, 10", "baud"])
    {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn the_sketchs_lines_become_frames() {
    let (link, device) = memory_link();
    let clock = Arc::new(FakeClock::default());
    let params = StreamParams { protocol: Protocol::Csv { n_channels: 10 }, clock: clock.clone() };
    let mut source = StreamSource::new(link, params);
    poll(&mut source);
    let mut got = Vec::new();
    let mut hello: Option<Arc<Hello>> = None;
    for i in 0..450u32 {
        // 41 characters at 115200 baud: 3.56 ms.
        clock.now_ns.fetch_add(3_560_000, Ordering::Relaxed);
        device.send(format!("{i},1,2,3,4,5,6,7,8,9\r\n").as_bytes());
        let messages = poll(&mut source);
        for message in &messages {
            if let Message::Hello(new) = message {
                hello = Some(new.clone());
            }
        }
        got.extend(frames(&messages));
    }
    assert_eq!(hello.unwrap().channels.len(), 10);
    assert_eq!(got.len(), 449);
    assert_eq!(got[3].bits(), [4, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
    assert_eq!((got[448].seq, source.stats().losses.n_lost), (448, 0));
    // Lines that can't be read are counted as lost, in one piece with the next or not.
    device.send(b"450,1,2\n");
    assert_eq!(frames(&poll(&mut source)).len(), 0);
    device.send(b"451,1,2,x,4,5,6,7,8,9\n452,1,2,3,4,5,6,7,8,9\n453,1,2,3,4,5,6,7,8,9\n");
    let after = frames(&poll(&mut source));
    let lost: Vec<_> = after.iter().map(|f| (f.seq, f.n_lost_before)).collect();
    assert_eq!(lost, [(451, 2), (452, 0)]);
    assert_eq!(source.stats().losses.n_lost, 2);
    assert!((source.stats().rate_hz - 280.9).abs() < 1.0, "{}", source.stats().rate_hz);
}

#[test]
fn tcp_comes_back() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let link = TcpLink::new(&listener.local_addr().unwrap().to_string());
    let source = StreamSource::new(link, StreamParams::default());
    let (_acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
    let mut sim = Device::new(10, SampleFormat::I16);
    for round in 0..2 {
        let (mut stream, _) = listener.accept().unwrap();
        let mut asked = [0; 16];
        stream.read_exact(&mut asked).unwrap();
        let mut bytes = Vec::new();
        sim.say_hello(&mut bytes);
        (0..100).for_each(|_| sim.tick(&mut bytes));
        stream.write_all(&bytes).unwrap();
        let last = 100 * round + 99;
        wait_for(&mut receivers[0], SECOND, |m| match m {
            Message::Frame(frame) => {
                assert!(is_right(frame));
                (frame.seq == last).then_some(())
            }
            _ => None,
        });
        drop(stream);
        wait_for(&mut receivers[0], SECOND, |m| {
            matches!(m, Message::Link(LinkState::Away(_))).then_some(())
        });
    }
}

#[test]
fn a_replay_keeps_its_pace() {
    let message = |i: u64| {
        let mut frame = Frame::new(i as u32, SampleFormat::I16, [1, 2]);
        frame.t_host_ns = 7_000_000_000 + i * 1_000_000;
        Message::Frame(frame)
    };
    for (speed, least_ms) in [(1.0, 300), (4.0, 75), (f64::INFINITY, 0)] {
        let replay = ReplaySource::new("made up", (0..301).map(message), speed);
        let start = Instant::now();
        let (acquisition, mut receivers) = acquire(replay, AcquireParams::default()).unwrap();
        let n = std::iter::from_fn(|| receivers[0].recv(SECOND)).count();
        let took_ms = start.elapsed().as_millis();
        assert_eq!((n, acquisition.has_ended()), (301, true));
        // Never early; how late depends on what else the machine does.
        let is_on_time = (least_ms..least_ms + 1000).contains(&took_ms);
        assert!(is_on_time, "× {speed}: {took_ms} ms");
    }
}

#[test]
fn another_version_is_named_with_the_remedy() {
    let (link, device) = memory_link();
    let clock = Arc::new(FakeClock::default());
    let params = StreamParams { clock: clock.clone(), ..StreamParams::default() };
    let mut source = StreamSource::new(link, params);
    poll(&mut source);
    let header = Header {
        kind: 1,
        major: 2,
        flags: FrameFlags::default(),
        schema: 0,
        n_channels: 1,
        seq: 0,
        t_us: 0,
    };
    let mut packet = Vec::new();
    Encoder::new().packet(header, &[0; 4], &mut packet).unwrap();
    let mut said = Vec::new();
    for _ in 0..2100 {
        clock.now_ns.fetch_add(1_000_000, Ordering::Relaxed);
        device.send(&packet);
        said.extend(poll(&mut source));
    }
    let [Message::Link(state)] = &said[..] else {
        panic!("{said:?}");
    };
    assert!(state.to_string().contains("HDP version 2"), "{state}");
}

#[test]
fn a_clock_that_is_not_believed_is_told_once_and_frames_are_flagged() {
    use hapdef_daq::clock::ClockFault;
    let (link, device) = memory_link();
    let clock = Arc::new(FakeClock::default());
    let params = StreamParams { clock: clock.clone(), ..StreamParams::default() };
    let mut source = StreamSource::new(link, params);
    poll(&mut source);
    let mut hello = Hello::plain(2, SampleFormat::I16, 2000);
    hello.n_scans = 2;
    hello.seal();
    let mut encoder = Encoder::new();
    let (mut said, mut flagged, mut times) = (Vec::new(), Vec::new(), Vec::new());
    let mut bytes = Vec::new();
    encoder.hello(&hello, 0, &mut bytes).unwrap();
    // Two scans a packet, a packet each ms; after a second it stays at the end of its range.
    for i in 0..3000u64 {
        clock.now_ns.fetch_add(1_000_000, Ordering::Relaxed);
        let t_us = if i < 1000 { i * 1000 } else { u64::MAX - 500 };
        encoder.data(&hello, t_us, FrameFlags::default(), &[1, 2, 3, 4], &mut bytes).unwrap();
        device.send(&std::mem::take(&mut bytes));
        for message in poll(&mut source) {
            match message {
                Message::Link(LinkState::Clock(fault)) => said.push((i, fault)),
                Message::Frame(frame) => {
                    flagged.push(frame.flags.contains(FrameFlags::HOST_TIME));
                    times.push(frame.t_host_ns);
                }
                _ => {}
            }
        }
    }
    let [(1000, ClockFault::Jumped), (stuck_at, ClockFault::Stuck)] = said[..] else {
        panic!("{said:?}");
    };
    assert!((2000..2300).contains(&stuck_at), "{stuck_at}");
    assert_eq!(flagged.iter().filter(|is_flagged| **is_flagged).count(), 4000);
    assert!(!flagged[..2000].contains(&true));
    // Each scan has a time of its own, half a ms after the last.
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] <= 1_000_000 && pair[0] < pair[1]));
    assert_eq!(source.stats().n_host_time, 4000);
}
