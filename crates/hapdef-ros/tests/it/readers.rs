//! What Python's mcap, mcap-ros2-support and rosbags, and rerun, read of a recording.
//!
//! Skipped without them. HAPDEF_PYTHON names the interpreter; `pip install mcap mcap-ros2-support
//! rosbags rerun-sdk` makes one that can.

use crate::support;
use crate::support::read_back;

use std::path::Path;

use hapdef_daq::record::Recording;
use hapdef_daq::{Message, record::Content};
use hapdef_ros::{TopicKind, from_cdr, msg};
use serde_json::Value;

use read_back::{flat, read_back};
use support::recorded;

const N: u32 = 300;

/// A message as JSON; names and values are ROS's.
fn value(topic: TopicKind, bytes: &[u8]) -> Value {
    fn json<T: serde::Serialize + serde::de::DeserializeOwned>(bytes: &[u8]) -> Value {
        serde_json::to_value(from_cdr::<T>(bytes).unwrap()).unwrap()
    }
    match topic {
        TopicKind::Gauges => json::<msg::Gauges>(bytes),
        TopicKind::Contacts | TopicKind::Truth => json::<msg::Contacts>(bytes),
        TopicKind::Markers => json::<msg::MarkerArray>(bytes),
        TopicKind::Transforms => json::<msg::TfMessage>(bytes),
        TopicKind::Diagnostics => json::<msg::DiagnosticArray>(bytes),
        TopicKind::Status => json::<msg::Status>(bytes),
        TopicKind::NetWrench | TopicKind::MountWrench | TopicKind::Wrench(_) => {
            json::<msg::WrenchStamped>(bytes)
        }
        TopicKind::RobotContacts(_) => json::<msg::RobotContacts>(bytes),
    }
}

/// The lines that these readers should print of the messages.
fn lines_of(readers: &[&str], kept: &support::Kept) -> Vec<String> {
    let params = support::params();
    let mut lines = Vec::new();
    for (topic, time, bytes) in kept.0.lock().unwrap().iter() {
        let mut values = String::new();
        flat(&value(*topic, bytes), &mut values);
        for reader in readers {
            lines.push(format!("{reader} {} {time}{values}", topic.name(&params)));
        }
    }
    lines
}

/// The lines of the messages and of the raw readings, sorted.
fn expected(path: &Path, kept: &support::Kept) -> Vec<String> {
    let mut lines = lines_of(&["mcap-ros2", "rosbags"], kept);
    let mut recording = Recording::open(path).unwrap();
    while let Some(record) = recording.next_record().unwrap() {
        if let Content::Message(Message::Frame(frame)) = record.content {
            let values: Vec<String> = frame.bits().iter().map(ToString::to_string).collect();
            let time = record.log_time_ns;
            lines.push(format!("mcap /gauges {time} {}", values.join(" ")));
        }
    }
    lines.sort();
    lines
}

#[test]
fn three_readers_read_what_was_written_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    let (_, kept) = recorded(&path, N);
    let Some(output) = read_back("mcap, mcap_ros2, rosbags", &[&path]) else {
        return;
    };
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    lines.sort_unstable();
    let expected = expected(&path, &kept);
    println!("{} lines of {} readings", lines.len(), N);
    let differing = lines.iter().zip(&expected).find(|(a, b)| a != b);
    assert_eq!(differing, None);
    assert_eq!(lines.len(), expected.len());
}

#[test]
fn rerun_converts_it_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    let (_, kept) = recorded(&path, N);
    let flag = Path::new("--rerun");
    let Some(output) = read_back("rerun.chunk", &[flag, &path]) else {
        return;
    };
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    lines.sort_unstable();
    // Transforms become rerun's own, in 32 bits.
    let mut expected = lines_of(&["rerun"], &kept);
    expected.retain(|line| !line.starts_with("rerun /tf "));
    expected.sort();
    println!("{} lines of {N} readings", lines.len());
    let differing = lines.iter().zip(&expected).find(|(a, b)| a != b);
    assert_eq!(differing, None);
    assert_eq!(lines.len(), expected.len());
}

#[test]
fn definitions_are_those_of_ros_and_hashes_theirs() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("msg");
    let flag = Path::new("--hashes");
    let Some(output) = read_back("rosbags", &[flag, &folder]) else {
        return;
    };
    let text = String::from_utf8(output.stdout).unwrap();
    let mut n_hashes = 0;
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        assert_eq!(words[2], "same", "{line}");
        if let Some(hash) = hapdef_ros::type_hash(words[0]) {
            assert_eq!(hash, words[1], "{line}");
            n_hashes += 1;
        }
    }
    assert_eq!((n_hashes, text.lines().count()), (15, 36));
}
