//! A press that is written, and what was written.

#![allow(dead_code, reason = "each test uses its part")]

#[path = "../../../../hapdef-daq/tests/it/support/damage.rs"]
pub mod damage;
pub mod read_back;
#[cfg(feature = "zenoh")]
pub mod zenoh_session;

use std::path::Path;
use std::sync::{Arc, Mutex};

use hapdef_contact::{
    Alternative, Contact, Quality, Touch, TouchPhase, Uncertainty, UnknownReason, Verdict, WhyNot,
};
use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::record::{RecordInfo, RecordParams, record};
use hapdef_daq::source::ReplaySource;
use hapdef_daq::{AcquireParams, Frame, Message, acquire};
use hapdef_ros::{
    Health, Known, Level, McapSink, MessageSink, Readings, RobotBoard, RosEncoder, RosParams,
    Sinks, TopicKind, topics,
};
use nalgebra::{Matrix3, Point3, Vector3};

pub const CALIBRATION: &[u8] = b"{\"tare\": [1, 2.5]}";

/// Every message that was put, in order.
#[derive(Clone, Default)]
pub struct Kept(pub Arc<Mutex<Vec<Put>>>);

/// A message: topic, time, bytes.
pub type Put = (TopicKind, u64, Vec<u8>);

impl MessageSink for Kept {
    fn put(&mut self, topic: TopicKind, stamp_ns: u64, message: &[u8]) {
        let mut kept = self.0.lock().unwrap();
        kept.push((topic, stamp_ns, message.to_vec()));
    }
}

/// Numbers that look drawn, the same in every run: an LCG's high bits as a double in (-1, 1).
pub fn number(seed: u64) -> f64 {
    let mixed = seed
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed >> 11) as f64) / ((1u64 << 52) as f64) - 1.0
}

pub fn contact(id: u32, seed: u64) -> Contact {
    let n = |k: u64| number(seed * 31 + k);
    let sd_2 = 0.01 + 1e-3 * n(6);
    let uncertainty = Uncertainty {
        tangents: [Vector3::y(), Vector3::z()],
        covariance: Matrix3::new(4e-6, 1e-6, 0.0, 1e-6, 9e-6, 0.0, 0.0, 0.0, sd_2),
    };
    Contact {
        id: Some(id.into()),
        direction: Some(-Vector3::x()),
        uncertainty: id.is_multiple_of(2).then_some(uncertainty),
        ..Contact::new(Point3::new(0.1 * n(0), 0.1 * n(1), 0.1 * n(2)), 2.0 + n(3))
    }
}

/// Another explanation, of `k` + 1 contacts.
pub fn alternative(k: u32, seed: u64) -> Alternative {
    let contacts = (0..=u64::from(k)).map(|j| {
        let n = |axis: u64| number(seed * 53 + 7 * j + axis);
        (Point3::new(0.1 * n(0), 0.1 * n(1), 0.1 * n(2)), 3.0 + n(3))
    });
    Alternative::new(f64::from(k) + 0.7 + 0.1 * number(seed), contacts)
}

/// Contacts of reading `i`, with none to two other explanations: one that stays, one that comes and goes.
pub fn contacts(i: u32) -> Touch {
    let mut contacts = vec![contact(4, u64::from(i))];
    if i % 40 < 20 {
        contacts.push(contact(5 + i / 40, u64::from(i) + 1000));
    }
    let is_identified = !i.is_multiple_of(3);
    Touch {
        contacts,
        quality: Some(Quality {
            verdict: match is_identified {
                true => Verdict::Identified,
                false => Verdict::NotIdentifiable(WhyNot::Misfit),
            },
            chi2: 1.0,
            n_dof: 4,
            p_value: 0.5 + 0.4 * number(u64::from(i)),
            n_alternatives: (i % 3) as usize,
        }),
        alternatives: (0..i % 3).map(|k| alternative(k, u64::from(i))).collect(),
        ..Touch::default()
    }
}

/// Whether contacts can be known at reading `i`: each phase, then each reason why not.
pub fn knowledge(i: u32, stamp_ns: u64) -> Known {
    let phases = [
        TouchPhase::Taring,
        TouchPhase::Untouched,
        TouchPhase::Touched,
        TouchPhase::Unknown(UnknownReason::StreamStalled),
        TouchPhase::Unknown(UnknownReason::Misfit),
        TouchPhase::Unknown(UnknownReason::Drift),
    ];
    Known {
        stamp_ns,
        phase: phases[i as usize / 50 % phases.len()],
        is_stale: i.is_multiple_of(100),
        n_contacts: i as usize % 3,
        smallest_seen_n: Some(2.0 + number(u64::from(i))),
    }
}

/// What is said of reading `i`.
pub fn say(encoder: &mut RosEncoder<impl MessageSink>, i: u32, stamp_ns: u64) {
    let microstrain: Vec<f64> = (0..10).map(|k| 50.0 * number(u64::from(i * 10 + k))).collect();
    let readings = Readings { stamp_ns, seq: i, n_lost_before: i % 2, microstrain: &microstrain };
    encoder.readings(&readings).unwrap();
    let found = contacts(i);
    encoder.contacts(stamp_ns, i, &found).unwrap();
    let known = found.contacts.iter().map(|contact| Contact {
        uncertainty: None,
        force_n: contact.force_n + 0.1,
        ..*contact
    });
    let truth = Touch { contacts: known.collect(), ..Touch::default() };
    encoder.truth(stamp_ns, i, &truth).unwrap();
    if i.is_multiple_of(50) {
        encoder.status(&knowledge(i, stamp_ns)).unwrap();
    }
    if i.is_multiple_of(100) {
        let health = Health {
            stamp_ns,
            name: "hapdef: acquisition".into(),
            level: Level::Warn,
            message: "3 µs \"late\"".into(),
            hardware_id: String::new(),
            values: vec![("rate_hz".into(), "1000".into())],
        };
        encoder.health(&[health]).unwrap();
    }
}

/// How the recorded messages are named: those of a robot's limb.
pub fn params() -> RosParams {
    RosParams { robot: Some("/robot".to_owned()), ..RosParams::default() }
}

/// Records `n` readings with all their messages to one file; returns the messages, too.
pub fn recorded(path: &Path, n: u32) -> (RecordInfo, Kept) {
    let params = params();
    let hello = Hello::plain(10, SampleFormat::I16, 1000);
    let frames = (0..n).map(|i| {
        let samples = (0..10).map(|k| (1000.0 * number(u64::from(i * 10 + k))) as i32);
        let mut frame = Frame::new(i, SampleFormat::I16, samples);
        frame.t_device_us = u64::from(i) * 1000;
        frame.t_host_ns = u64::from(i) * 1_000_000;
        Message::Frame(frame)
    });
    let messages: Vec<Message> =
        std::iter::once(Message::Hello(Arc::new(hello))).chain(frames).collect();
    let source = ReplaySource::new("made up", messages.into_iter(), f64::INFINITY);
    let acquire_params = AcquireParams { ring_len: n as usize + 100, ..AcquireParams::default() };
    let (_acquisition, mut receivers) = acquire(source, acquire_params).unwrap();
    let record_params = RecordParams {
        calibration: Some(CALIBRATION.to_vec()),
        source: "made up".into(),
        min_free_bytes: 1 << 20,
        topics: topics(&params).unwrap(),
        ..RecordParams::default()
    };
    let recorder = record(receivers.remove(0), path, record_params).unwrap();
    let kept = Kept::default();
    let writer = recorder.topics();
    let sinks = Sinks(vec![Box::new(McapSink::new(writer.clone())), Box::new(kept.clone())]);
    let encoder = RosEncoder::new(params, sinks).unwrap();
    let mut encoder = encoder.beside(RobotBoard::default(), 0);
    for i in 0..n {
        say(&mut encoder, i, writer.wall_ns(u64::from(i) * 1_000_000));
        if i % 200 == 199 {
            // A limb says less than this test does in no time.
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
    }
    while recorder.stats().n_frames < u64::from(n) {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    (recorder.finish().unwrap(), kept)
}
