//! The device at real ports, end to end.

use crate::live_support;

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use hapdef_daq::source::{
    Link, LinkFault, LinkState, SerialLink, SerialParams, StreamParams, StreamSource, TcpLink,
    memory_link,
};
use hapdef_daq::{AcquireParams, Frame, Message, Receiver, acquire};
use hapdef_rig::live::{
    DevicePort, PtyPort, RigDevice, RigDeviceParams, RunParams, TcpPort, run_rig, spawn_rig,
};
use live_support::{device, script};

fn plain() -> RigDevice {
    device(Some(&script()), RigDeviceParams::default(), 1)
}

/// What the device sends in its first seconds, by number.
fn expected(n: u32) -> BTreeMap<u32, Vec<i32>> {
    let mut twin = plain();
    let mut decoder = hapdef_daq::hdp1::Decoder::new();
    let (mut out, mut frames) = (Vec::new(), BTreeMap::new());
    twin.opened(&mut out);
    for _ in 0..n {
        twin.tick(usize::MAX, &mut out);
    }
    decoder.push(&out, &mut |event| {
        if let hapdef_daq::hdp1::Event::Data(data) = event {
            frames.insert(data.header.seq, data.bits(0).collect());
        }
    });
    frames
}

/// Messages until `seconds` have passed.
fn receive(receiver: &mut Receiver, seconds: f64) -> Vec<Message> {
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let mut all = Vec::new();
    while Instant::now() < end {
        all.extend(receiver.recv(Duration::from_millis(10)));
    }
    all
}

fn frames(messages: &[Message]) -> impl Iterator<Item = &Frame> {
    messages.iter().filter_map(|message| match message {
        Message::Frame(frame) => Some(frame),
        _ => None,
    })
}

/// Numbers rise, what is missing is counted, and every frame is as it was sent.
#[track_caller]
fn check(messages: &[Message], at_least: usize) {
    let expected = expected(4000);
    let mut next = None;
    let mut n = 0;
    for frame in frames(messages) {
        assert_eq!(frame.bits(), expected[&frame.seq], "frame {}", frame.seq);
        let from = next.unwrap_or(frame.seq);
        assert_eq!(frame.seq, from + if n > 0 { frame.n_lost_before } else { 0 });
        next = Some(frame.seq + 1);
        n += 1;
    }
    assert!(n >= at_least, "{n} frames");
}

#[test]
fn a_pseudo_terminal_is_read_unplugged_and_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("limb");
    let port = PtyPort::open(Some(&link)).unwrap();
    assert_eq!(port.name(), link.display().to_string());
    let params =
        RunParams { faults: vec!["unplug=0.5+0.3".parse().unwrap()], ..RunParams::default() };
    let rig = spawn_rig(plain(), port, params, |_| {}).unwrap();
    let serial = SerialLink::new(link.to_str().unwrap(), SerialParams::default());
    let source = StreamSource::new(serial, StreamParams::default());
    let (acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
    let messages = receive(&mut receivers[0], 1.6);
    let info = rig.stop();
    drop(acquisition);
    check(&messages, 300);
    let away =
        |m: &&Message| matches!(m, Message::Link(LinkState::Away(LinkFault::Disconnected { .. })));
    assert_eq!(messages.iter().filter(away).count(), 1);
    let n_lost: u64 = frames(&messages).skip(1).map(|f| u64::from(f.n_lost_before)).sum();
    assert!((250..=1000).contains(&n_lost), "{n_lost} lost while unplugged: {info:?}");
    assert!(!link.exists(), "the link stays behind");
}

#[test]
fn a_host_that_reads_nothing_does_not_hold_the_device_up() {
    let port = PtyPort::open(None).unwrap();
    let mut host = SerialLink::new(&port.name(), SerialParams::default());
    host.open().unwrap();
    let params = RunParams { is_real_time: false, duration_s: Some(20.0), ..RunParams::default() };
    let start = Instant::now();
    let info = run_rig(plain(), port, &params, &AtomicBool::new(false), |_| {});
    assert_eq!(info.n_frames, 20_000);
    assert!((10_000..20_000).contains(&info.n_dropped), "{info:?}");
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
}

#[test]
fn nobody_there_and_everything_is_dropped() {
    let port = PtyPort::open(None).unwrap();
    let params = RunParams { is_real_time: false, duration_s: Some(1.0), ..RunParams::default() };
    let info = run_rig(plain(), port, &params, &AtomicBool::new(false), |_| {});
    assert_eq!((info.n_frames, info.n_dropped), (1000, 1000));
}

#[test]
fn tcp_is_read() {
    let port = TcpPort::listen("127.0.0.1:0").unwrap();
    let link = TcpLink::new(&port.name());
    let rig = spawn_rig(plain(), port, RunParams::default(), |_| {}).unwrap();
    let source = StreamSource::new(link, StreamParams::default());
    let (acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
    let messages = receive(&mut receivers[0], 0.6);
    let info = rig.stop();
    drop(acquisition);
    check(&messages, 200);
    assert!(info.n_frames >= 300, "{info:?}");
}

#[test]
fn memory_is_read() {
    let (link, port) = memory_link();
    let rig = spawn_rig(plain(), port, RunParams::default(), |_| {}).unwrap();
    let source = StreamSource::new(link, StreamParams::default());
    let (acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
    let messages = receive(&mut receivers[0], 0.5);
    drop(rig);
    drop(acquisition);
    check(&messages, 200);
}

#[test]
fn a_file_in_the_links_place_is_kept() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let error = PtyPort::open(Some(file.path())).unwrap_err().to_string();
    assert!(error.contains("choose another one"), "{error}");
    assert!(file.path().exists());
    assert!(TcpPort::listen("192.0.2.1:1").is_err());
}
