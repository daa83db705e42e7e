//! Recordings that are killed, or run out of disk.
//!
//! HAPDEF_SOAK=1 kills 200 times instead of 5.

use crate::support;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::record::{RecordParams, Recorder, record, recover};
use hapdef_daq::source::{MemoryDevice, ReplaySource, StreamParams, StreamSource, memory_link};
use hapdef_daq::{AcquireParams, Acquisition, Frame, acquire};
use support::Device;
use support::recorded::{check_frames, frames, params};

#[test]
fn a_device_that_is_full_is_reported_at_once() {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/full", folder.path().join("x.partial.mcap")).unwrap();
    let nothing = ReplaySource::new("nothing", std::iter::empty(), 1.0);
    let receiver = acquire(nothing, AcquireParams::default()).unwrap().1.remove(0);
    let start = Instant::now();
    let onto_it = RecordParams { overwrites: true, ..params() };
    let refused = record(receiver, &folder.path().join("x.mcap"), onto_it).map(|_| ());
    assert!(refused.unwrap_err().to_string().contains("No space left"));
    assert!(start.elapsed() < Duration::from_secs(1));
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
    (device, Device::new(10, SampleFormat::I16), acquisition, recorder)
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
    println!("acquired {} lost {}", stats.source.n_frames, stats.source.losses.n_lost);
    println!("finished {:?}", recorder.finish().map(|info| info.n_frames));
}

fn child_command(path: &Path, limit_blocks: Option<u32>) -> Command {
    let mut command = Command::new("sh");
    // An ignored SIGXFSZ stays ignored: writing beyond the limit is an error then.
    let limit = limit_blocks.map_or(String::new(), |n| format!("trap '' XFSZ; ulimit -f {n};"));
    command
        .arg("-c")
        .arg(format!(
            "{limit} exec \"$0\" --exact record_survival::child --nocapture --test-threads 1"
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
        assert!(child.try_wait().unwrap().is_none(), "the child has ended by itself");
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
    if path.exists() { frames(path) } else { Vec::new() }
}

#[test]
fn kill_9_loses_nothing_older_than_150_ms() {
    let folder = tempfile::tempdir().unwrap();
    let n_kills = if std::env::var_os("HAPDEF_SOAK").is_some() { 200 } else { 5 };
    let mut worst_ms = 0.0f64;
    for i in 0..n_kills {
        let age_ms = kill_once(folder.path(), 100 + 37 * i % 400);
        worst_ms = worst_ms.max(age_ms);
        assert!(age_ms <= 150.0, "kill {i}: the newest frame was {age_ms} ms old");
    }
    println!("worst of {n_kills}: {worst_ms:.1} ms");
}

#[test]
fn a_full_disk_is_reported_and_the_file_can_be_read() {
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
    // Everything but the last second before the fault was reported.
    assert!(got.len() as u32 + 1000 >= fault_ms, "{} {fault_ms}", got.len());
    let bytes = std::fs::read(&partial).unwrap();
    let read = mcap::MessageStream::new(&bytes).unwrap();
    assert!(read.filter(Result::is_ok).count() >= got.len());
}
