//! A recording that is looked at: stopped, sent elsewhere, waiting at its end.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::record::{Player, RecordParams, record};
use hapdef_daq::source::{FrameSource, ReplaySource, SourceStatus};
use hapdef_daq::{AcquireParams, DaqError, Frame, Message, acquire};

/// Host time of the first frame, ns.
const FIRST_NS: u64 = 5_000_000_000;

/// `n` frames of 1 ms whose number is their place.
fn recorded(path: &Path, n: u32) {
    let hello = Message::Hello(Arc::new(Hello::plain(2, SampleFormat::I16, 1000)));
    let frame = |i: u32| {
        let mut frame = Frame::new(i, SampleFormat::I16, [i as i32 % 100, 7]);
        frame.t_host_ns = FIRST_NS + u64::from(i) * 1_000_000;
        Message::Frame(frame)
    };
    let messages: Vec<Message> = std::iter::once(hello).chain((0..n).map(frame)).collect();
    let source = ReplaySource::new("made up", messages.into_iter(), f64::INFINITY);
    let (acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
    let params = RecordParams { min_free_bytes: 1 << 20, ..RecordParams::default() };
    let recorder = record(receivers.remove(0), path, params).unwrap();
    while !acquisition.has_ended() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(recorder.finish().unwrap().n_frames, u64::from(n));
}

/// What a turn hands out: numbers of frames, and how many restarts and descriptions.
fn turn(player: &mut Player) -> (Vec<u32>, usize, usize) {
    let (mut seqs, mut n_restarts, mut n_hellos) = (Vec::new(), 0, 0);
    let status = player.poll(Duration::from_millis(20), &mut |message| match message {
        Message::Frame(frame) => seqs.push(frame.seq),
        Message::Restarted => n_restarts += 1,
        Message::Hello(_) => n_hellos += 1,
        _ => {}
    });
    assert_eq!(status, SourceStatus::Open);
    (seqs, n_restarts, n_hellos)
}

#[test]
fn it_goes_where_it_is_sent_and_stays_while_it_is_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 4000);
    let mut player = Player::open(&path, f64::INFINITY).unwrap();
    let control = player.control();
    assert!((control.duration_s() - 3.999).abs() < 1e-9);
    control.pause(true);
    assert_eq!(turn(&mut player), (Vec::new(), 0, 0));
    for (position_s, expected) in [(2.5, 2200..=2500), (0.0, 0..=0), (1.0004, 701..=1000)] {
        control.seek(3.0);
        control.seek(position_s);
        let (seqs, n_restarts, n_hellos) = turn(&mut player);
        assert_eq!(seqs, expected.collect::<Vec<_>>());
        assert_eq!((n_restarts, n_hellos), (1, 1));
        assert_eq!(turn(&mut player).0, [0; 0]);
    }
    let at_s = control.position_s(FIRST_NS + 1_000_000_000);
    assert!((at_s - 1.0).abs() < 1e-9, "{at_s}");
    control.pause(false);
    assert_eq!(turn(&mut player).0.first(), Some(&1001));
    let mut last = 0;
    while let (seqs, 0, 0) = turn(&mut player)
        && let Some(seq) = seqs.last()
    {
        last = *seq;
    }
    assert_eq!(last, 3999);
    control.seek(1e9);
    assert_eq!(turn(&mut player).0, (3699..=3999).collect::<Vec<_>>());
    control.seek(-1.0);
    assert_eq!(turn(&mut player).0, [0]);
    assert_eq!(turn(&mut player).0.first(), Some(&1));
}

#[test]
fn its_pace_is_that_of_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 400);
    let mut player = Player::open(&path, 2.0).unwrap();
    let start = Instant::now();
    let mut n = 0;
    while n < 400 {
        n += turn(&mut player).0.len();
    }
    let passed = start.elapsed();
    assert!(passed >= Duration::from_millis(199), "{passed:?}");
}

#[test]
fn what_can_not_be_played_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.mcap");
    recorded(&path, 0);
    let found = Player::open(&path, 1.0);
    assert!(matches!(found, Err(DaqError::NoFrames { .. })));
    let found = Player::open(&folder.path().join("none.mcap"), 1.0);
    assert!(matches!(found, Err(DaqError::File { .. })));
}
