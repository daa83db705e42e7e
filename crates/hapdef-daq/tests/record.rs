//! Recordings: what comes back, what survives killing, full disks and damage.
//!
//! HAPDEF_SOAK=1 kills 200 times instead of 5.

#![expect(clippy::unwrap_used, reason = "tests and their helpers")]

mod support;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::record::{
    Content, RecordParams, Recorder, Recording, export_csv, export_json_lines, record, recover,
};
use hapdef_daq::source::{
    FrameSource, MemoryDevice, ReplaySource, SourceStatus, StreamParams, StreamSource, memory_link,
};
use hapdef_daq::{AcquireParams, Acquisition, DaqError, Frame, Message, acquire};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use support::{Device, is_right};

const CALIBRATION: &[u8] = b"{\"tare\": [1, 2.5],\n \"date\": \"2026-11-21\"}";

fn params() -> RecordParams {
    RecordParams {
        calibration: Some(CALIBRATION.to_vec()),
        source: "test".to_owned(),
        min_free_bytes: 1 << 20,
        ..RecordParams::default()
    }
}

/// A simulated device in memory that is acquired and recorded.
fn start(path: &Path) -> (MemoryDevice, Device, Acquisition, Recorder) {
    let (link, device) = memory_link();
    let source = StreamSource::new(link, StreamParams::default());
    let (acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
    let recorder = record(receivers.remove(0), path, params()).unwrap();
    while !device.is_open() {
        std::thread::sleep(Duration::from_millis(1));
    }
    (
        device,
        Device::new(10, SampleFormat::I16),
        acquisition,
        recorder,
    )
}

/// A recording of `n` frames without waiting.
fn recorded(path: &Path, n: u32) {
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
    let params_of = AcquireParams {
        ring_len: n as usize + 100,
        ..AcquireParams::default()
    };
    let (_acquisition, mut receivers) = acquire(replay, params_of).unwrap();
    let recorder = record(receivers.remove(0), path, params()).unwrap();
    while recorder.stats().n_frames < u64::from(n) {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(recorder.finish().unwrap().n_frames, u64::from(n));
}

fn frames(path: &Path) -> Vec<(u64, Frame)> {
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
fn check_frames(frames: &[(u64, Frame)], n: usize) {
    assert_eq!(frames.len(), n);
    assert!(frames.iter().all(|(_, frame)| is_right(frame)));
    assert!((0u32..).zip(frames).all(|(i, (_, frame))| frame.seq == i));
}

#[test]
fn a_recording_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 3000);
    assert!(!folder.path().join("press.partial.mcap").exists());
    check_frames(&frames(&path), 3000);
    let mut recording = Recording::open(&path).unwrap();
    let (mut calibration, mut n_hello) = (None, 0);
    while let Some(record) = recording.next_record().unwrap() {
        match record.content {
            Content::Calibration(json) => calibration = Some(json),
            Content::Message(Message::Hello(hello)) => {
                n_hello += 1;
                assert_eq!(*hello, Device::new(10, SampleFormat::I16).hello);
            }
            _ => {}
        }
    }
    assert_eq!((calibration.as_deref(), n_hello), (Some(CALIBRATION), 1));
    let damage = recording.damage();
    assert!(damage.is_finished && damage.n_damaged == 0, "{damage:?}");
    assert_eq!(damage.n_bytes, std::fs::metadata(&path).unwrap().len());
    let messages = Recording::open(&path).unwrap().messages();
    let mut replay = ReplaySource::new("file", messages, f64::INFINITY);
    let mut n = 0;
    while replay.poll(Duration::ZERO, &mut |_| n += 1) == SourceStatus::Open {}
    assert!(n > 3000 && replay.stats().n_frames == 3000);
}

#[test]
fn the_mcap_library_reads_it_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 500);
    let bytes = std::fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let longest = summary.chunk_indexes.iter().map(|c| c.chunk_length).max();
    assert!(longest.unwrap() <= 256 << 10);
    let mut n = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(schema.encoding, "jsonschema");
        n += usize::from(message.channel.topic == "/gauges");
    }
    assert_eq!(n, 500);
}

#[test]
fn text_has_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 100);
    let (mut lines, mut table) = (Vec::new(), Vec::new());
    let open = || Recording::open(&path).unwrap();
    let n_lines = export_json_lines(&mut open(), &mut lines).unwrap();
    assert_eq!(export_csv(&mut open(), &mut table).unwrap(), 100);
    let lines = String::from_utf8(lines).unwrap();
    assert_eq!(lines.lines().count() as u64, n_lines);
    for line in lines.lines() {
        let value: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(value["message"].is_object(), "{line}");
    }
    let table = String::from_utf8(table).unwrap();
    let mut rows = table.lines();
    assert!(
        rows.next()
            .unwrap()
            .ends_with("dropped_before,G0,G1,G2,G3,G4,G5,G6,G7,G8,G9")
    );
    let seventh: Vec<_> = rows
        .nth(7)
        .unwrap()
        .split(',')
        .skip(7)
        .map(str::to_owned)
        .collect();
    let expected: Vec<_> = support::samples(7, 10).map(|v| v.to_string()).collect();
    assert_eq!(seventh, expected);
}

#[test]
fn damage_costs_the_damaged_chunk_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 2000);
    let whole = std::fs::read(&path).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut draw = |n: usize| rng.next_u64() as usize % n;
    let damaged_path = folder.path().join("damaged.mcap");
    let mut n_untouched = 0;
    for round in 0..1000 {
        let mut bytes = whole.clone();
        let at = draw(bytes.len());
        match round % 4 {
            0 => bytes[at] ^= 1 << draw(8),
            1 => bytes.truncate(at),
            2 => {
                let end = (at + 1 + draw(5000)).min(bytes.len());
                bytes.drain(at..end);
            }
            _ => {
                let end = (at + 16).min(bytes.len());
                bytes[at..end].iter_mut().for_each(|b| *b = draw(256) as u8);
            }
        }
        std::fs::write(&damaged_path, &bytes).unwrap();
        let got = frames(&damaged_path);
        assert!(
            got.iter().all(|(_, frame)| is_right(frame)),
            "round {round}"
        );
        assert!(got.is_sorted_by(|a, b| a.1.seq < b.1.seq), "round {round}");
        n_untouched += usize::from(got.len() == 2000);
        if round % 4 != 1 {
            // A chunk holds at most 192 KiB and a message more: 900 frames here. A hole of 5000
            // bytes can reach into two.
            let most = if round % 4 == 2 { 1800 } else { 900 };
            assert!(got.len() + most >= 2000, "round {round}: {}", got.len());
        }
    }
    assert!(n_untouched < 400, "{n_untouched}");
}

#[test]
fn recovery_says_what_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    let to = folder.path().join("saved.mcap");
    recorded(&path, 4000);
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(&path, &bytes).unwrap();
    let info = recover(&path, &to).unwrap();
    println!("{info}");
    assert_eq!((info.n_frames + info.n_missing, info.n_gaps), (4000, 1));
    assert_eq!((info.damage.n_damaged, info.damage.is_finished), (1, true));
    assert_eq!(frames(&to).len() as u64, info.n_frames);
    let again = recover(&to, &folder.path().join("again.mcap")).unwrap();
    assert_eq!((again.n_frames, again.damage.n_damaged), (info.n_frames, 0));
    std::fs::write(&path, vec![7; 100_000]).unwrap();
    let nothing = recover(&path, &to).unwrap_err();
    assert!(matches!(
        nothing,
        DaqError::NothingToRecover {
            n_bytes: 100_000,
            ..
        }
    ));
}

#[test]
fn bad_beginnings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let receiver = || {
        let nothing = ReplaySource::new("nothing", std::iter::empty(), 1.0);
        acquire(nothing, AcquireParams::default())
            .unwrap()
            .1
            .remove(0)
    };
    let path = folder.path().join("x.mcap");
    let bad = RecordParams {
        calibration: Some(b"[1]".to_vec()),
        ..params()
    };
    let refused = record(receiver(), &path, bad).map(|_| ()).unwrap_err();
    assert!(
        matches!(refused, DaqError::BadCalibration { .. }),
        "{refused}"
    );
    let full = RecordParams {
        min_free_bytes: u64::MAX,
        ..params()
    };
    let refused = record(receiver(), &path, full).map(|_| ()).unwrap_err();
    assert!(matches!(refused, DaqError::DiskFull { .. }), "{refused}");
    let nowhere = record(receiver(), &folder.path().join("no/x.mcap"), params());
    assert!(matches!(nowhere.map(|_| ()), Err(DaqError::File { .. })));
}

#[test]
fn a_device_that_is_full_is_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/full", folder.path().join("x.partial.mcap")).unwrap();
    let nothing = ReplaySource::new("nothing", std::iter::empty(), 1.0);
    let receiver = acquire(nothing, AcquireParams::default())
        .unwrap()
        .1
        .remove(0);
    let start = Instant::now();
    let refused = record(receiver, &folder.path().join("x.mcap"), params()).map(|_| ());
    assert!(refused.unwrap_err().to_string().contains("No space left"));
    assert!(start.elapsed() < Duration::from_secs(1));
}

/// What the child processes of the tests below do; without the variable it is no test at all.
#[test]
fn child() {
    let Some(path) = std::env::var_os("HAPDEF_CHILD_RECORDS") else {
        return;
    };
    let (device, mut sim, acquisition, recorder) = start(Path::new(&path));
    let begin = Instant::now();
    let mut fault_at = None;
    for i in 0..20_000u32 {
        let mut bytes = Vec::new();
        sim.tick(&mut bytes);
        device.send(&bytes);
        let due = Duration::from_millis(u64::from(i));
        std::thread::sleep(due.saturating_sub(begin.elapsed()));
        if let Some(fault) = recorder.stats().fault
            && fault_at.is_none()
        {
            fault_at = Some(i);
            println!("fault at {i}: {fault}");
        }
        if fault_at.is_some_and(|at| i > at + 300) {
            break;
        }
    }
    let stats = acquisition.stop();
    println!(
        "acquired {} lost {}",
        stats.source.n_frames, stats.source.losses.n_lost
    );
    println!("finished {:?}", recorder.finish().map(|info| info.n_frames));
}

fn child_command(path: &Path, limit_blocks: Option<u32>) -> Command {
    let mut command = Command::new("sh");
    // An ignored SIGXFSZ stays ignored: writing beyond the limit is an error then.
    let limit = limit_blocks.map_or(String::new(), |n| format!("trap '' XFSZ; ulimit -f {n};"));
    command
        .arg("-c")
        .arg(format!(
            "{limit} exec \"$0\" --exact child --nocapture --test-threads 1"
        ))
        .arg(std::env::current_exe().unwrap())
        .env("HAPDEF_CHILD_RECORDS", path)
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    command
}

fn wall_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    u64::try_from(since.unwrap().as_nanos()).unwrap()
}

/// Kills a recording after about `run_ms`: age of the newest frame that survived, ms.
fn kill_once(folder: &Path, run_ms: u64) -> f64 {
    let path = folder.join("killed.mcap");
    let mut child = child_command(&path, None).spawn().unwrap();
    let partial = folder.join("killed.partial.mcap");
    while frames_if_there(&partial).is_empty() {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(run_ms));
    let killed_ns = wall_ns();
    child.kill().unwrap();
    child.wait().unwrap();
    let got = frames(&partial);
    check_frames(&got, got.len());
    let info = recover(&partial, &folder.join("saved.mcap")).unwrap();
    assert_eq!((info.n_frames, info.n_missing), (got.len() as u64, 0));
    std::fs::remove_file(&partial).unwrap();
    killed_ns.saturating_sub(got[got.len() - 1].0) as f64 * 1e-6
}

fn frames_if_there(path: &Path) -> Vec<(u64, Frame)> {
    if path.exists() {
        frames(path)
    } else {
        Vec::new()
    }
}

#[test]
fn kill_9_loses_nothing_older_than_150_ms() {
    let folder = tempfile::tempdir().unwrap();
    let n_kills = if std::env::var_os("HAPDEF_SOAK").is_some() {
        200
    } else {
        5
    };
    let mut worst_ms = 0.0f64;
    for i in 0..n_kills {
        let age_ms = kill_once(folder.path(), 100 + 37 * i % 400);
        worst_ms = worst_ms.max(age_ms);
        assert!(
            age_ms <= 150.0,
            "kill {i}: the newest frame was {age_ms} ms old"
        );
    }
    println!("worst of {n_kills}: {worst_ms:.1} ms");
}

#[test]
fn a_full_disk_is_told_and_the_file_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("full.mcap");
    // 300 blocks of 512 bytes: about 0.7 s of recording.
    let start = Instant::now();
    let output = child_command(&path, Some(300)).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    println!("{text}");
    let (_, after) = text.split_once("fault at ").unwrap();
    let fault_ms: u32 = after.split(':').next().unwrap().parse().unwrap();
    assert!(text.contains("File too large"), "{text}");
    assert!(text.contains("lost 0"), "{text}");
    assert!(text.contains("finished Err"), "{text}");
    assert!(start.elapsed() < Duration::from_secs(10));
    let partial = folder.path().join("full.partial.mcap");
    let got = frames(&partial);
    check_frames(&got, got.len());
    assert!(!got.is_empty());
    // Everything but the last second before the fault was told.
    assert!(
        got.len() as u32 + 1000 >= fault_ms,
        "{} {fault_ms}",
        got.len()
    );
    let bytes = std::fs::read(&partial).unwrap();
    let read = mcap::MessageStream::new(&bytes).unwrap();
    assert!(read.filter(Result::is_ok).count() >= got.len());
}
