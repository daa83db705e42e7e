//! Recordings that were broken off are in nobody's way, and nobody is in theirs; what is missing in a
//! damaged one is counted when it is played.

use crate::support;

use std::path::Path;

use hapdef_daq::record::{RecordParams, Recording, record, recover};
use hapdef_daq::source::{LinkState, ReplaySource};
use hapdef_daq::{AcquireParams, DaqError, Message, Receiver, acquire};
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
