//! Recordings: what comes back, and from damaged files.

use crate::support;

use std::time::Duration;

use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::record::{
    Content, RecordParams, Recording, export_csv, export_json_lines, record, recover,
};
use hapdef_daq::source::{
    FrameSource, LinkFault, LinkState, ReplaySource, SourceStatus, StreamParams, StreamSource,
    memory_link,
};
use hapdef_daq::{AcquireParams, DaqError, Message, acquire};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use support::damage::flip_amid_a_chunk;
use support::recorded::{CALIBRATION, check_frames, frames, params, recorded};
use support::{Device, is_right, wait_for};

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
    assert!(rows.next().unwrap().ends_with("dropped_before,G0,G1,G2,G3,G4,G5,G6,G7,G8,G9"));
    let seventh: Vec<_> = rows.nth(7).unwrap().split(',').skip(7).map(str::to_owned).collect();
    let expected: Vec<_> = support::samples(7, 10).map(|v| v.to_string()).collect();
    assert_eq!(seventh, expected);
}

#[test]
fn damage_costs_the_damaged_chunk_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 2000);
    let whole = std::fs::read(&path).unwrap();
    let chunks = chunks(&whole);
    assert_eq!(chunks.last().unwrap().seqs.end, 2000);
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut draw = |n: usize| rng.next_u64() as usize % n;
    let damaged_path = folder.path().join("damaged.mcap");
    let mut n_untouched = 0;
    for round in 0..1000 {
        let mut bytes = whole.clone();
        let at = draw(bytes.len());
        let end = match round % 4 {
            0 => at + 1,
            1 => bytes.len(),
            2 => (at + 1 + draw(5000)).min(bytes.len()),
            _ => (at + 16).min(bytes.len()),
        };
        match round % 4 {
            0 => bytes[at] ^= 1 << draw(8),
            1 => bytes.truncate(at),
            2 => drop(bytes.drain(at..end)),
            _ => bytes[at..end].iter_mut().for_each(|b| *b = draw(256) as u8),
        }
        std::fs::write(&damaged_path, &bytes).unwrap();
        let got = frames(&damaged_path);
        assert!(got.iter().all(|(_, frame)| is_right(frame)), "round {round}");
        assert!(got.is_sorted_by(|a, b| a.1.seq < b.1.seq), "round {round}");
        n_untouched += usize::from(got.len() == 2000);
        let is_hit = |chunk: &Chunk| chunk.at.start < end && at < chunk.at.end;
        for chunk in chunks.iter().filter(|chunk| !is_hit(chunk)) {
            let kept = got.iter().filter(|(_, f)| chunk.seqs.contains(&f.seq));
            assert_eq!(kept.count(), chunk.seqs.len(), "round {round}: {chunk:?}");
        }
    }
    assert!(n_untouched < 400, "{n_untouched}");
}

/// A chunk of a recording: its place in the file, and the frames in it.
#[derive(Debug)]
struct Chunk {
    at: std::ops::Range<usize>,
    seqs: std::ops::Range<u32>,
}

/// The chunks of a whole file, by its own index.
fn chunks(whole: &[u8]) -> Vec<Chunk> {
    let summary = mcap::Summary::read(whole).unwrap().unwrap();
    let mut first = 0;
    let of_index = |chunk: &mcap::records::ChunkIndex| {
        let start = usize::try_from(chunk.chunk_start_offset).unwrap();
        let length = usize::try_from(chunk.chunk_length).unwrap();
        let messages = summary.stream_chunk(whole, chunk).unwrap();
        let gauges = messages.filter(|m| m.as_ref().unwrap().channel.topic == "/gauges");
        let end = first + u32::try_from(gauges.count()).unwrap();
        Chunk { at: start..start + length, seqs: std::mem::replace(&mut first, end)..end }
    };
    summary.chunk_indexes.iter().map(of_index).collect()
}

#[test]
fn recovery_says_what_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    let to = folder.path().join("saved.mcap");
    recorded(&path, 4000);
    let mut bytes = std::fs::read(&path).unwrap();
    flip_amid_a_chunk(&mut bytes);
    std::fs::write(&path, &bytes).unwrap();
    let info = recover(&path, &to).unwrap();
    println!("{info}");
    assert_eq!((info.n_frames + info.n_missing, info.n_gaps), (4000, 1));
    assert_eq!((info.damage.n_damaged, info.damage.is_finished), (1, true));
    assert_eq!(frames(&to).len() as u64, info.n_frames);
    let again = recover(&to, &folder.path().join("again.mcap")).unwrap();
    assert_eq!((again.n_frames, again.damage.n_damaged), (info.n_frames, 0));
    assert_eq!(info.exit_code(), 1);
    std::fs::write(&path, vec![7; 100_000]).unwrap();
    let nothing = recover(&path, &to).unwrap_err();
    assert!(matches!(nothing, DaqError::NothingToRecover { n_bytes: 100_000, .. }));
}

#[test]
fn bad_beginnings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let receiver = || {
        let nothing = ReplaySource::new("nothing", std::iter::empty(), 1.0);
        acquire(nothing, AcquireParams::default()).unwrap().1.remove(0)
    };
    let path = folder.path().join("x.mcap");
    let bad = RecordParams { calibration: Some(b"[1]".to_vec()), ..params() };
    let refused = record(receiver(), &path, bad).map(|_| ()).unwrap_err();
    assert!(matches!(refused, DaqError::BadCalibration { .. }), "{refused}");
    let full = RecordParams { min_free_bytes: u64::MAX, ..params() };
    let refused = record(receiver(), &path, full).map(|_| ()).unwrap_err();
    assert!(matches!(refused, DaqError::DiskFull { .. }), "{refused}");
    let nowhere = record(receiver(), &folder.path().join("no/x.mcap"), params());
    assert!(matches!(nowhere.map(|_| ()), Err(DaqError::File { .. })));
}

/// A cable that is pulled, seven packets that nobody hears, and a reset: the file records both.
#[test]
fn gaps_and_restarts_are_in_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    let (link, device) = memory_link();
    let source = StreamSource::new(link, StreamParams::default());
    let acquire_params = AcquireParams { n_receivers: 2, ..AcquireParams::default() };
    let (acquisition, mut receivers) = acquire(source, acquire_params).unwrap();
    let recorder = record(receivers.remove(1), &path, params()).unwrap();
    let mut sim = Device::new(10, SampleFormat::I16);
    let mut wait = |kind: &str| {
        let is_it = |m: &Message| (said(m) == kind).then_some(());
        wait_for(&mut receivers[0], Duration::from_secs(1), is_it);
    };
    let send = |sim: &mut Device, n: u32| {
        let mut bytes = Vec::new();
        (0..n).for_each(|_| sim.tick(&mut bytes));
        device.send(&bytes);
    };
    wait("open");
    send(&mut sim, 10);
    wait("9 lost 0");
    device.unplug();
    wait("away");
    (0..7).for_each(|_| sim.tick(&mut Vec::new()));
    device.replug();
    wait("open");
    send(&mut sim, 1);
    wait("17 lost 7");
    sim.reset();
    send(&mut sim, 2);
    wait("1 lost 0");
    assert_eq!(acquisition.stop().source.n_opened, 2);
    recorder.finish().unwrap();

    let kept: Vec<String> = Recording::open(&path)
        .unwrap()
        .messages()
        .map(|m| said(&m))
        .filter(|words| words != "other")
        .collect();
    let first = (0..10).map(|seq| format!("{seq} lost 0"));
    let then = ["17 lost 7", "restarted", "0 lost 0", "1 lost 0"];
    let expected: Vec<String> = first.chain(then.map(str::to_owned)).collect();
    assert_eq!(kept, expected);
}

/// A message in a word or two.
fn said(message: &Message) -> String {
    match message {
        Message::Link(LinkState::Open) => "open".to_owned(),
        Message::Link(LinkState::Away(LinkFault::Disconnected { .. })) => "away".to_owned(),
        Message::Restarted => "restarted".to_owned(),
        Message::Frame(frame) => format!("{} lost {}", frame.seq, frame.n_lost_before),
        _ => "other".to_owned(),
    }
}
