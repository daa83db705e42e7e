//! Messages and raw readings in one file: whole, damaged and recovered.

use crate::support;

use hapdef_contact::Alternative;
use hapdef_daq::Message;
use hapdef_daq::record::{Content, Record, Recording, recover};
use hapdef_ros::{TopicKind, from_cdr, msg, topics};
use nalgebra::Point3;

use support::damage::flip_amid_a_chunk;
use support::{Kept, recorded};

const N: u32 = 600;

fn records(path: &std::path::Path) -> Vec<Record> {
    let mut recording = Recording::open(path).unwrap();
    std::iter::from_fn(|| recording.next_record().unwrap()).collect()
}

/// The messages of further topics among records: name, time, bytes.
fn further(records: &[Record]) -> Vec<(&str, u64, &[u8])> {
    let is_further = |record: &&Record| matches!(record.content, Content::Further(_));
    let found = records.iter().filter(is_further);
    found.map(|r| (r.topic(), r.log_time_ns, r.bytes.as_slice())).collect()
}

fn names_of(kept: &Kept) -> Vec<(String, u64, Vec<u8>)> {
    let params = support::params();
    let kept = kept.0.lock().unwrap();
    kept.iter().map(|(topic, time, bytes)| (topic.name(&params), *time, bytes.clone())).collect()
}

#[test]
fn everything_is_in_one_file_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    let (info, kept) = recorded(&path, N);
    assert_eq!(info.n_frames, u64::from(N));
    assert_eq!(info.n_messages_dropped, 0);
    let records = records(&path);
    let found = further(&records);
    let written = names_of(&kept);
    assert_eq!(info.n_messages, written.len() as u64);
    let same = found.iter().zip(&written);
    assert!(same.clone().all(|(a, b)| a.0 == b.0 && a.1 == b.1 && a.2 == b.2));
    assert_eq!(same.len(), written.len());
    let frames = records.iter().filter_map(|record| match record.content {
        Content::Message(Message::Frame(frame)) => Some((frame.seq, record.log_time_ns)),
        _ => None,
    });
    // Readings as sent and readings as used have the same times.
    let used = found.iter().filter(|(name, ..)| *name == "/hapdef/gauges");
    let used = used.map(|(_, time, bytes)| {
        let gauges: msg::Gauges = from_cdr(bytes).unwrap();
        (gauges.seq, *time)
    });
    assert!(frames.eq(used));
    let calibrations = records.iter().filter(
        |r| matches!(&r.content, Content::Calibration(json) if json == support::CALIBRATION),
    );
    assert_eq!(calibrations.count(), 1);
}

/// Readings with none, one and two other explanations, each as it was said.
#[test]
fn other_explanations_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 90);
    let records = records(&path);
    let found = further(&records);
    let lists = found.iter().filter(|(name, ..)| *name == "/hapdef/contacts");
    let mut counts = [0; 3];
    for (.., bytes) in lists {
        let list: msg::Contacts = from_cdr(bytes).unwrap();
        let said = support::contacts(list.seq).alternatives;
        counts[said.len()] += 1;
        let read = list.alternatives.iter().map(|other| {
            let places = other.positions.iter().map(|p| Point3::new(p.x, p.y, p.z));
            Alternative::new(other.delta_evidence, places.zip(other.forces.iter().copied()))
        });
        assert_eq!(read.collect::<Vec<_>>(), said);
    }
    assert_eq!(counts, [30; 3]);
}

#[test]
fn the_file_says_how_its_messages_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 50);
    let known = topics(&support::params()).unwrap();
    for record in records(&path) {
        if let Content::Further(topic) = record.content {
            assert!(known.contains(&topic), "{topic:?}");
        }
    }
}

#[test]
fn damage_costs_a_chunk_and_recovery_keeps_the_topics() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    let (info, _) = recorded(&path, N);
    let mut bytes = std::fs::read(&path).unwrap();
    flip_amid_a_chunk(&mut bytes);
    // And the definitions' first copy.
    bytes[200] ^= 4;
    let (bad, good) = (folder.path().join("bad.mcap"), folder.path().join("good.mcap"));
    std::fs::write(&bad, &bytes).unwrap();
    let saved = recover(&bad, &good).unwrap();
    assert_eq!(saved.exit_code(), 1);
    assert_eq!(saved.n_undefined, 0);
    let records = records(&good);
    let n_messages = further(&records).len() as u64;
    assert!(n_messages > info.n_messages / 2 && n_messages < info.n_messages);
    let again = recover(&good, &folder.path().join("again.mcap")).unwrap();
    assert_eq!((again.n_undefined, again.damage.n_damaged), (0, 0));
}

#[test]
fn markers_come_less_often_and_go_with_their_contact() {
    let folder = tempfile::tempdir().unwrap();
    let (_, kept) = recorded(&folder.path().join("press.mcap"), N);
    let kept = kept.0.lock().unwrap();
    let arrays: Vec<msg::MarkerArray> = kept
        .iter()
        .filter(|(topic, ..)| *topic == TopicKind::Markers)
        .map(|(.., bytes)| from_cdr(bytes).unwrap())
        .collect();
    // 30 a second, and one more for each contact that goes.
    let n_gone = N as usize / 40;
    assert!(arrays.len() >= 18 && arrays.len() <= 18 + 2 * n_gone, "{}", arrays.len());
    let mut shown = std::collections::BTreeSet::new();
    for marker in arrays.iter().flat_map(|array| &array.markers) {
        let key = (marker.ns.clone(), marker.id);
        if marker.action == 0 {
            shown.insert(key);
        } else {
            shown.remove(&key);
        }
    }
    let left: Vec<_> = shown.iter().map(|(ns, id)| format!("{ns} {id}")).collect();
    assert_eq!(left, ["ellipse 0", "force 0", "newtons 0"]);
}
