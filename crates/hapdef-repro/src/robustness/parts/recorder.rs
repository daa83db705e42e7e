//! Recordings that were cut off, damaged, or are none.

use std::path::Path;
use std::time::Duration;

use hapdef_daq::hdp1::{Encoder, FrameFlags, Hello, SampleFormat};
use hapdef_daq::record::{Content, RecordParams, Recording, record, recover};
use hapdef_daq::source::{FrameSource, ReplaySource, StreamParams, StreamSource, memory_link};
use hapdef_daq::{AcquireParams, Message, acquire};

use crate::error::ReproError;
use crate::robustness::table::Trials;

const N_FRAMES: u32 = 40_000;
const N_CHANNELS: usize = 10;

/// The share of a file that one chunk is, and some more.
const CHUNK_SHARE: f64 = 0.2;

/// What recovery made of a damaged file.
struct Saved {
    n_wrong: u32,
    n_right: u32,
}

pub(super) fn add(rows: &mut Trials<u64>) {
    for left in [0.3, 0.7, 0.999] {
        let extreme = format!("{} % of the file are left", 100.0 * left);
        saved_rows(rows, &extreme, left, move |bytes| {
            bytes.truncate((left * bytes.len() as f64) as usize);
        });
    }
    saved_rows(rows, "one byte flipped", 1.0, |bytes| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0x55;
    });
    saved_rows(rows, "1 MB of zeros in the middle", 1.0, |bytes| {
        let middle = bytes.len() / 2;
        bytes.splice(middle..middle, vec![0; 1 << 20]);
    });
    rows.all_refused([
        ("an empty file", "record", || Ok(f64::from(damaged(Vec::clear)?.n_right))),
        ("a file of another kind", "record", || {
            let other = |bytes: &mut Vec<u8>| *bytes = b"not one of ours".repeat(1000);
            Ok(f64::from(damaged(other)?.n_right))
        }),
    ]);
}

/// Nothing wrong is saved, and no more is lost than a chunk around the damage.
fn saved_rows(
    rows: &mut Trials<u64>,
    extreme: &str,
    left: f64,
    change: impl Fn(&mut Vec<u8>) + Copy + 'static,
) {
    let wrong = ("frames saved that are wrong or out of order", 0.0);
    rows.accurate(extreme, wrong, move |_| Ok(f64::from(damaged(change)?.n_wrong)));
    let lost = ("share of the frames lost that the file still had", CHUNK_SHARE);
    rows.accurate(extreme, lost, move |_| {
        Ok(left - f64::from(damaged(change)?.n_right) / f64::from(N_FRAMES))
    });
}

/// Records, damages the file, recovers it, and looks at what came back.
fn damaged(change: impl Fn(&mut Vec<u8>)) -> Result<Saved, ReproError> {
    let folder = tempfile::tempdir().map_err(ReproError::Folder)?;
    let (from, to) = (folder.path().join("a.mcap"), folder.path().join("b.mcap"));
    recorded(&from)?;
    let mut bytes = std::fs::read(&from).map_err(ReproError::Folder)?;
    change(&mut bytes);
    std::fs::write(&from, &bytes).map_err(ReproError::Folder)?;
    recover(&from, &to)?;
    saved(&to)
}

fn sample(seq: u32, channel: usize) -> i32 {
    i32::from((seq.wrapping_mul(40_503) ^ channel as u32) as i16)
}

/// A recording of [`N_FRAMES`] frames without waiting.
fn recorded(path: &Path) -> Result<(), ReproError> {
    let hello = Hello::plain(N_CHANNELS, SampleFormat::I16, 1000);
    let (link, device) = memory_link();
    let mut source = StreamSource::new(link, StreamParams::default());
    source.poll(Duration::ZERO, &mut |_| {});
    let (mut encoder, mut messages) = (Encoder::new(), Vec::new());
    for seq in 0..N_FRAMES {
        let mut bytes = Vec::new();
        let t_us = u64::from(seq) * 1000;
        if seq % 1000 == 0 {
            bytes.push(0);
            encoder.hello(&hello, t_us, &mut bytes)?;
        }
        let samples: Vec<i32> = (0..N_CHANNELS).map(|c| sample(seq, c)).collect();
        let flags = FrameFlags::from_bits(0);
        encoder.data(&hello, t_us, flags, &samples, &mut bytes)?;
        device.send(&bytes);
        source.poll(Duration::ZERO, &mut |message| messages.push(message));
    }
    let replay = ReplaySource::new("made up", messages.into_iter(), f64::INFINITY);
    let params = AcquireParams { ring_len: N_FRAMES as usize + 100, ..AcquireParams::default() };
    let (_acquisition, mut receivers) = acquire(replay, params)?;
    let params = RecordParams { min_free_bytes: 1 << 20, ..RecordParams::default() };
    let recorder = record(receivers.remove(0), path, params)?;
    while recorder.stats().n_frames < u64::from(N_FRAMES) {
        std::thread::sleep(Duration::from_millis(2));
    }
    recorder.finish()?;
    Ok(())
}

fn saved(path: &Path) -> Result<Saved, ReproError> {
    let mut recording = Recording::open(path)?;
    let (mut saved, mut next) = (Saved { n_wrong: 0, n_right: 0 }, 0);
    while let Some(record) = recording.next_record()? {
        if let Content::Message(Message::Frame(frame)) = record.content {
            let own = (0..N_CHANNELS).map(|c| sample(frame.seq, c));
            let is_right = frame.seq >= next && frame.bits().iter().copied().eq(own);
            *if is_right { &mut saved.n_right } else { &mut saved.n_wrong } += 1;
            next = frame.seq + 1;
        }
    }
    Ok(saved)
}
