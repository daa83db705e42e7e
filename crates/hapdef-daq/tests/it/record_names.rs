//! Recordings that were broken off are in nobody's way, and nobody is in theirs; what is missing in a
//! damaged one is counted when it is played.

use crate::support;

use std::path::Path;

use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::record::{RecordParams, Recording, record, recover};
use hapdef_daq::source::{LinkState, ReplaySource};
use hapdef_daq::{AcquireParams, DaqError, Frame, Message, Receiver, acquire};
use support::recorded::{check_frames, frames, params, recorded};

const N: u32 = 8000;

fn nothing() -> Receiver {
    let nothing = ReplaySource::new("nothing", std::iter::empty(), 1.0);
    let (_, mut receivers) = acquire(nothing, AcquireParams::default()).unwrap();
    receivers.remove(0)
}

/// A recording of more than one read of the recovery, as a killed program leaves it.
fn broken_off(folder: &Path) -> std::path::PathBuf {
    let partial = folder.join("press.partial.mcap");
    recorded(&folder.join("press.mcap"), N);
    std::fs::rename(folder.join("press.mcap"), &partial).unwrap();
    let n_bytes = std::fs::metadata(&partial).unwrap().len();
    assert!(n_bytes > 1 << 20, "{n_bytes} bytes");
    partial
}

#[test]
fn what_was_broken_off_is_saved_under_its_own_name() {
    let folder = tempfile::tempdir().unwrap();
    let partial = broken_off(folder.path());
    let before = std::fs::read(&partial).unwrap();
    let saved = folder.path().join("press.mcap");
    let info = recover(&partial, &saved).unwrap();
    assert_eq!((info.n_frames, info.exit_code()), (u64::from(N), 0));
    check_frames(&frames(&saved), N as usize);
    assert_eq!(std::fs::read(&partial).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn a_recovery_never_writes_to_what_it_reads() {
    let folder = tempfile::tempdir().unwrap();
    let partial = broken_off(folder.path());
    let before = std::fs::read(&partial).unwrap();
    let linked = folder.path().join("linked.mcap");
    std::fs::hard_link(&partial, &linked).unwrap();
    let under_way = folder.path().join("x.recovering.mcap");
    std::fs::write(&under_way, "another's").unwrap();
    for to in [&partial, &linked, &folder.path().join("x.mcap")] {
        let refused = recover(&partial, to).unwrap_err();
        assert!(matches!(refused, DaqError::AlreadyThere { .. }), "{refused}");
    }
    // One that is being recovered already may be the file to read, too.
    assert!(recover(&under_way, &folder.path().join("x.mcap")).is_err());
    assert_eq!(std::fs::read_to_string(&under_way).unwrap(), "another's");
    assert_eq!(std::fs::read(&partial).unwrap(), before);
}

#[test]
fn recording_again_does_not_wipe_what_a_killed_one_left() {
    let folder = tempfile::tempdir().unwrap();
    let partial = broken_off(folder.path());
    let before = std::fs::read(&partial).unwrap();
    let path = folder.path().join("press.mcap");
    let refused = record(nothing(), &path, params()).map(|_| ()).unwrap_err();
    let words = refused.to_string();
    assert!(words.contains("press.partial.mcap") && words.contains("hapdef recover"));
    assert_eq!(std::fs::read(&partial).unwrap(), before);
    let forced = RecordParams { overwrites: true, ..params() };
    let recorder = record(nothing(), &path, forced).unwrap();
    assert_eq!(recorder.finish().unwrap().n_frames, 0);
    assert!(!partial.exists() && frames(&path).is_empty());
}

/// Frames played, packets that they say are lost, and what is said of the file.
fn played(path: &Path) -> (u64, u64, Vec<LinkState>) {
    let (mut n_frames, mut n_lost, mut said) = (0, 0, Vec::new());
    for message in Recording::open(path).unwrap().messages() {
        match message {
            Message::Frame(frame) => {
                n_frames += 1;
                n_lost += u64::from(frame.n_lost_before);
            }
            Message::Link(state) => said.push(state),
            _ => {}
        }
    }
    (n_frames, n_lost, said)
}

fn damage(path: &Path, at: usize) {
    let mut bytes = std::fs::read(path).unwrap();
    bytes[at] ^= 4;
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn a_replay_counts_what_damage_has_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = broken_off(folder.path());
    assert_eq!(played(&path), (u64::from(N), 0, Vec::new()));
    damage(&path, std::fs::metadata(&path).unwrap().len() as usize / 2);
    let (n_frames, n_lost, said) = played(&path);
    assert_eq!(n_frames + n_lost, u64::from(N));
    assert!(n_lost > 0);
    let [LinkState::Damaged { n_damaged: 1, .. }] = said[..] else {
        panic!("{said:?}");
    };
    std::fs::write(&path, "not an MCAP file at all").unwrap();
    let (n_frames, _, said) = played(&path);
    assert_eq!((n_frames, said.len()), (0, 1));
    assert!(said[0].to_string().contains("is it a recording"));
}

#[test]
fn what_is_gone_before_the_first_frame_is_reported_as_unknown() {
    let folder = tempfile::tempdir().unwrap();
    let path = broken_off(folder.path());
    let first = std::fs::read(&path).unwrap();
    let first = first.windows(7).position(|w| w == b"\"seq\":0").unwrap();
    damage(&path, first);
    let info = recover(&path, &folder.path().join("saved.mcap")).unwrap();
    assert_eq!((info.n_missing, info.n_uncounted), (0, 1));
    assert!(info.n_frames < u64::from(N) && info.exit_code() == 1);
    let words = info.to_string();
    assert!(words.contains("unknown number before"), "{words}");
}

#[test]
fn what_is_being_written_is_nobody_elses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.mcap");
    let forced = || RecordParams { overwrites: true, ..params() };
    let first = record(nothing(), &path, params()).unwrap();
    let partial = folder.path().join("two.partial.mcap");
    let is_refused = |refused: Result<(), DaqError>| {
        let refused = refused.unwrap_err();
        assert!(matches!(refused, DaqError::BeingWritten { .. }), "{refused}");
        let words = refused.to_string();
        assert!(words.contains("two.partial.mcap: another program is writing it"), "{words}");
    };
    for params in [params(), forced()] {
        is_refused(record(nothing(), &path, params).map(|_| ()));
        // By the name that it has now, too.
        is_refused(record(nothing(), &partial, forced()).map(|_| ()));
    }
    let other = folder.path().join("other.mcap");
    recorded(&other, 100);
    is_refused(recover(&other, &path).map(|_| ()));
    is_refused(recover(&other, &partial).map(|_| ()));
    first.finish().unwrap();
    let mut recording = Recording::open(&path).unwrap();
    while recording.next_record().unwrap().is_some() {}
    assert!(recording.damage().is_finished && recording.damage().n_damaged == 0);
    record(nothing(), &path, forced()).unwrap().finish().unwrap();
}

/// A flipped bit costs no more readings in what was saved than in what a recorder wrote.
#[test]
fn what_was_saved_has_chunks_as_small_as_the_recorders() {
    let frame = |i: u32| {
        let mut frame = Frame::new(i, SampleFormat::I16, (0..10).map(|k| (i % 97) as i32 - k));
        frame.t_host_ns = 1_000_000 * u64::from(i);
        Message::Frame(frame)
    };
    let folder = tempfile::tempdir().unwrap();
    let [path, saved] = ["whole", "saved"].map(|name| folder.path().join(format!("{name}.mcap")));
    let source = ReplaySource::new("made up", (0..4000).map(frame), f64::INFINITY);
    let params = AcquireParams { ring_len: 8000, ..AcquireParams::default() };
    let (acquisition, mut receivers) = acquire(source, params).unwrap();
    let recorder = record(receivers.remove(0), &path, support::recorded::params()).unwrap();
    while !acquisition.has_ended() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert_eq!(recorder.finish().unwrap().n_frames, 4000);
    assert_eq!(recover(&path, &saved).unwrap().n_frames, 4000);
    let bytes = std::fs::read(&saved).unwrap();
    for at in (1..20).map(|k| k * bytes.len() / 20) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 4;
        std::fs::write(&path, damaged).unwrap();
        let n_lost = 4000 - frames(&path).len();
        assert!(n_lost <= 81, "{n_lost} readings by a bit of byte {at}");
    }
}
