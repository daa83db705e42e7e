//! Recordings to test with.

use std::path::Path;
use std::time::Duration;

use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::record::{Content, RecordParams, Recording, record};
use hapdef_daq::source::{FrameSource, ReplaySource, StreamParams, StreamSource, memory_link};
use hapdef_daq::{AcquireParams, Frame, Message, acquire};

use super::{Device, is_right};

pub const CALIBRATION: &[u8] = b"{\"tare\": [1, 2.5],\n \"date\": \"2026-11-21\"}";

pub fn params() -> RecordParams {
    RecordParams {
        calibration: Some(CALIBRATION.to_vec()),
        source: "test".to_owned(),
        min_free_bytes: 1 << 20,
        ..RecordParams::default()
    }
}

/// A recording of `n` frames without waiting.
pub fn recorded(path: &Path, n: u32) {
    let mut sim = Device::new(10, SampleFormat::I16);
    let (link, device) = memory_link();
    let mut source = StreamSource::new(link, StreamParams::default());
    source.poll(Duration::ZERO, &mut |_| {});
    let mut messages = Vec::new();
    for _ in 0..n {
        let mut bytes = Vec::new();
        sim.tick(&mut bytes);
        device.send(&bytes);
        source.poll(Duration::ZERO, &mut |message| messages.push(message));
    }
    let replay = ReplaySource::new("made up", messages.into_iter(), f64::INFINITY);
    let params_of = AcquireParams { ring_len: n as usize + 100, ..AcquireParams::default() };
    let (_acquisition, mut receivers) = acquire(replay, params_of).unwrap();
    let recorder = record(receivers.remove(0), path, params()).unwrap();
    while recorder.stats().n_frames < u64::from(n) {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(recorder.finish().unwrap().n_frames, u64::from(n));
}

pub fn frames(path: &Path) -> Vec<(u64, Frame)> {
    let mut recording = Recording::open(path).unwrap();
    let mut frames = Vec::new();
    while let Some(record) = recording.next_record().unwrap() {
        if let Content::Message(Message::Frame(frame)) = record.content {
            frames.push((record.log_time_ns, frame));
        }
    }
    frames
}

#[track_caller]
pub fn check_frames(frames: &[(u64, Frame)], n: usize) {
    assert_eq!(frames.len(), n);
    assert!(frames.iter().all(|(_, frame)| is_right(frame)));
    assert!((0u32..).zip(frames).all(|(i, (_, frame))| frame.seq == i));
}
