//! Recordings of a process that is killed.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::record::{Content, RecordParams, Recording, record};
use hapdef_daq::source::{StreamParams, StreamSource, memory_link};
use hapdef_daq::{AcquireParams, Message, acquire};

use crate::support::{Device, is_right};

/// First argument of the process that records.
pub const CHILD: &str = "--record-until-killed";

/// What survived.
#[derive(Debug, Default)]
#[allow(dead_code, reason = "it is printed as a whole")]
pub struct Kill {
    /// Age of the newest frame that survived, at worst, ms.
    pub worst_ms: f64,
    /// Frames with wrong values, or missing between others.
    pub n_wrong: u64,
    pub n_frames: u64,
}

pub fn run(n_kills: u32) -> Kill {
    let folder = tempfile::tempdir().unwrap();
    let mut all = Kill::default();
    for i in 0..n_kills {
        let partial = folder.path().join(format!("{i}.partial.mcap"));
        let path = folder.path().join(format!("{i}.mcap"));
        let own = std::env::current_exe().unwrap();
        let mut child = Command::new(own).arg(CHILD).arg(&path).spawn().unwrap();
        while !partial.exists() || survivors(&partial).n_frames == 0 {
            assert!(child.try_wait().unwrap().is_none(), "the child has ended by itself");
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(u64::from(100 + 37 * i % 400)));
        let killed_ms = wall_ms();
        child.kill().unwrap();
        child.wait().unwrap();
        let left = survivors(&partial);
        all.worst_ms = all.worst_ms.max(killed_ms - left.worst_ms);
        all.n_wrong += left.n_wrong;
        all.n_frames += left.n_frames;
        std::fs::remove_file(&partial).unwrap();
    }
    all
}

/// Records a device in memory at 1 kHz until it is killed, or for 20 s.
pub fn child(path: &Path) {
    let (link, device) = memory_link();
    let source = StreamSource::new(link, StreamParams::default());
    let (_acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
    let _recorder = record(receivers.remove(0), path, RecordParams::default()).unwrap();
    let mut sim = Device::new(10, SampleFormat::I16);
    while !device.is_open() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let start = Instant::now();
    for i in 0..20_000 {
        let mut bytes = Vec::new();
        sim.tick(&mut bytes);
        device.send(&bytes);
        std::thread::sleep(Duration::from_millis(i).saturating_sub(start.elapsed()));
    }
}

/// The frames in a file; `worst_ms` is the wall-clock time of the newest.
fn survivors(path: &Path) -> Kill {
    let mut recording = Recording::open(path).unwrap();
    let mut left = Kill::default();
    while let Some(record) = recording.next_record().unwrap() {
        if let Content::Message(Message::Frame(frame)) = record.content {
            let is_next = u64::from(frame.seq) == left.n_frames;
            left.n_wrong += u64::from(!(is_next && is_right(&frame)));
            left.n_frames += 1;
            left.worst_ms = record.log_time_ns as f64 * 1e-6;
        }
    }
    left
}

fn wall_ms() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    since.as_nanos() as f64 * 1e-6
}
