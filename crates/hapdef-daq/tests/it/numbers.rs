//! Numbers of topics in MCAP files that others wrote.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::record::{NumbersTopic, Player, Recording, is_mcap};
use hapdef_daq::{DaqError, Message};
use mcap::records::MessageHeader;
use proptest::prelude::*;

const ROS2_TYPE: &str = "\
std_msgs/Header header
float32[] strain
string[] names
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// Fields, prefix and all, of a chunk before its compression: two times, length, CRC.
const BEFORE_COMPRESSION: usize = 9 + 28;

/// A file as Python's mcap and rosbag2 write them: a topic of JSON, one of ROS 2, one of text; 100 Hz.
fn written(path: &Path, n: u32) {
    let options = mcap::WriteOptions::new().compression(None).disable_seeking(true);
    let mut writer = options.create(mcap::write::NoSeek::new(File::create(path).unwrap())).unwrap();
    let schema = writer.add_schema("x_msgs/msg/Strain", "ros2msg", ROS2_TYPE.as_bytes()).unwrap();
    let nothing = BTreeMap::new();
    let json = writer.add_channel(0, "/strain", "json", &nothing).unwrap();
    let ros2 = writer.add_channel(schema, "/ros/strain", "cdr", &nothing).unwrap();
    let text = writer.add_channel(0, "/log", "text", &nothing).unwrap();
    for i in 0..n {
        let log_time = 1_000_000_000 + u64::from(i) * 10_000_000;
        let mut put = |channel_id: u16, bytes: &[u8]| {
            let header =
                MessageHeader { channel_id, sequence: i, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, bytes).unwrap();
        };
        put(json, format!(r#"{{"t": {i}, "values": [{i}.5, -2, null]}}"#).as_bytes());
        put(ros2, &cdr(i as f32));
        put(text, b"hello");
    }
    writer.finish().unwrap();
}

/// A message of ROS 2: 2 numbers and their names.
fn cdr(first: f32) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    bytes.extend([7, 0, 0, 0, 8, 0, 0, 0, 2, 0, 0, 0, b'a', 0, 0, 0]);
    bytes.extend(2u32.to_le_bytes());
    bytes.extend([first, -first].into_iter().flat_map(f32::to_le_bytes));
    bytes.extend(2u32.to_le_bytes());
    for name in [b"toe\0", b"tip\0"] {
        bytes.extend(4u32.to_le_bytes());
        bytes.extend(name);
    }
    bytes
}

/// The file with its chunks compressed.
fn compressed(path: &Path, name: &str) -> PathBuf {
    let whole = std::fs::read(path).unwrap();
    let (magic, mut rest) = whole.split_at(8);
    let mut out = magic.to_vec();
    while rest.len() > 8 {
        let len = 9 + u64::from_le_bytes(rest[1..9].try_into().unwrap()) as usize;
        let (record, behind) = rest.split_at(len);
        if record[0] == 6 {
            // no name of a compression, and the length once more
            let packed = packed(&record[BEFORE_COMPRESSION + 4 + 8..], name);
            let len = BEFORE_COMPRESSION - 9 + 4 + name.len() + 8 + packed.len();
            out.push(6);
            out.extend((len as u64).to_le_bytes());
            out.extend(&record[9..BEFORE_COMPRESSION]);
            out.extend((name.len() as u32).to_le_bytes());
            out.extend(name.as_bytes());
            out.extend((packed.len() as u64).to_le_bytes());
            out.extend(packed);
        } else {
            out.extend(record);
        }
        rest = behind;
    }
    out.extend(rest);
    let to = path.with_extension(format!("{name}.mcap"));
    std::fs::write(&to, out).unwrap();
    to
}

fn packed(bytes: &[u8], name: &str) -> Vec<u8> {
    match name {
        "zstd" => {
            ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
        }
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
        }
        _ => bytes.to_vec(),
    }
}

fn rows(path: &Path, topic: &str) -> Result<Vec<(u64, Vec<f64>)>, DaqError> {
    let mut topic = NumbersTopic::open(path, topic)?;
    let mut rows = Vec::new();
    while let Some(row) = topic.next_row()? {
        rows.push((row.log_time_ns, row.values));
    }
    Ok(rows)
}

#[test]
fn topics_of_json_and_of_ros_2_however_they_are_compressed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    written(&path, 300);
    assert!(is_mcap(&path).unwrap());
    for path in [path.clone(), compressed(&path, "zstd"), compressed(&path, "lz4")] {
        let json = rows(&path, "/strain").unwrap();
        assert_eq!((json.len(), json[299].0), (300, 3_990_000_000), "{}", path.display());
        assert_eq!(json[299].1[..2], [299.5, -2.0]);
        assert!(json[299].1[2].is_nan());
        let ros2 = rows(&path, "/ros/strain").unwrap();
        assert_eq!((ros2.len(), ros2[299].1.as_slice()), (300, [299.0, -299.0].as_slice()));
        assert_eq!(rows(&path, "/ros/strain.strain").unwrap(), ros2);
        let names = NumbersTopic::open(&path, "/ros/strain").unwrap();
        assert_eq!(names.names().unwrap(), ["toe", "tip"]);
    }
}

#[test]
fn a_topic_is_a_device_with_a_channel_a_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    written(&path, 300);
    let mut messages = NumbersTopic::open(&path, "/ros/strain").unwrap().messages().unwrap();
    let Some(Message::Hello(hello)) = messages.next() else { panic!("no HELLO") };
    assert_eq!((hello.format, hello.rate_mhz), (SampleFormat::F32, 100_000));
    let names: Vec<String> = hello.channels.iter().map(|c| c.name_text()).collect();
    assert_eq!(names, ["toe", "tip"]);
    let frames: Vec<_> = messages
        .map(|message| match message {
            Message::Frame(frame) => {
                (frame.seq, frame.t_host_ns, frame.values().collect::<Vec<_>>())
            }
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(frames.len(), 300);
    assert_eq!(frames[7], (7, 70_000_000, vec![7.0, -7.0]));
}

#[test]
fn what_a_file_of_others_lacks_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    written(&path, 2);
    #[track_caller]
    fn refused<T>(found: Result<T, DaqError>, expected: &str) {
        let error = found.err().unwrap().to_string();
        assert!(error.contains(expected), "{error}");
    }
    refused(
        rows(&path, "/gauges"),
        "no topic /gauges; it has /strain (json), /ros/strain (x_msgs/msg/Strain, cdr), /log (text)",
    );
    refused(rows(&path, "/log"), "/log: message 1: written as \"text\"");
    refused(rows(&path, "/strain.t.x"), "/strain.t.x: message 1: no field \"x\"");
    for path in [&path, &compressed(&path, "zstd")] {
        refused(Recording::open(path).unwrap().with_first_chunk(), "no topic /gauges; it has");
        refused(Player::open(path, 1.0), "no topic /gauges; it has");
    }
    refused(rows(&compressed(&path, "rot13"), "/strain"), "compressed as \"rot13\"");
    let mut bytes = std::fs::read(compressed(&path, "zstd")).unwrap();
    let middle = 160;
    bytes[middle] ^= 0x40;
    let damaged = folder.path().join("damaged.mcap");
    std::fs::write(&damaged, &bytes).unwrap();
    refused(rows(&damaged, "/strain"), "a chunk is");
    std::fs::write(&damaged, b"x,y\n1,2\n").unwrap();
    assert!(!is_mcap(&damaged).unwrap());
    refused(rows(&damaged, "/strain"), "no MCAP file");
}

#[test]
fn a_message_unlike_the_first_ends_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let options = mcap::WriteOptions::new().compression(None).disable_seeking(true);
    let file = mcap::write::NoSeek::new(File::create(&path).unwrap());
    let mut writer = options.create(file).unwrap();
    let channel_id = writer.add_channel(0, "/strain", "json", &BTreeMap::new()).unwrap();
    for (sequence, json) in (0u32..).zip(["[1, 2]", "[3, 4]", "[5]"]) {
        let header = MessageHeader { channel_id, sequence, log_time: 0, publish_time: 0 };
        writer.write_to_known_channel(&header, json.as_bytes()).unwrap();
        // each in a chunk of its own
        writer.flush().unwrap();
    }
    writer.finish().unwrap();
    let error = rows(&path, "/strain").unwrap_err().to_string();
    assert!(error.contains("message 3: 1 numbers, the first message has 2"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Damage is an error, or rows as before it, and never a panic.
    #[test]
    fn damage_is_no_panic(at in 0.0..1.0, with in any::<u8>(), len in 0.5..1.0, kind in 0usize..3) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.mcap");
        written(&path, 20);
        let path = match ["", "zstd", "lz4"][kind] {
            "" => path,
            name => compressed(&path, name),
        };
        let mut bytes = std::fs::read(&path).unwrap();
        let n = bytes.len() as f64;
        bytes[(n * at) as usize] = with;
        bytes.truncate((n * len) as usize);
        std::fs::write(&path, bytes).unwrap();
        for topic in ["/strain", "/ros/strain", "/gauges"] {
            if let Ok(rows) = rows(&path, topic) {
                prop_assert!(rows.len() <= 20);
            }
        }
    }
}

/// What Python's mcap and mcap-ros2 wrote.
#[test]
fn files_from_the_field() {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let shared = std::env::var("HAPDEF_SHARED").unwrap_or_else(|_| default.into());
    let folder = Path::new(&shared).join("inputs/field/mcap");
    if !folder.exists() {
        println!("skipped: {} is absent (set HAPDEF_SHARED)", folder.display());
        return;
    }
    for (file, topic, step) in [
        ("json_strain.mcap", "/strain", 0.5),
        ("ros2_float64multiarray.mcap", "/strain_gauges", 1.0),
    ] {
        let path = folder.join(file);
        let found = Recording::open(&path).unwrap().with_first_chunk().err().unwrap();
        let found = found.to_string();
        assert!(found.contains(&format!("no topic /gauges; it has {topic} (")), "{found}");
        let rows = rows(&path, topic).unwrap();
        let wanted: Vec<f64> = (0..10).map(|i| step * f64::from(i)).collect();
        assert_eq!((rows.len(), &rows[0].1), (1000, &wanted), "{file}");
        assert!(rows.iter().flat_map(|(_, values)| values).all(|value| value.is_finite()));
    }
}
