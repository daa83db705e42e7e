//! The whole way: the virtual rig on a pseudo-terminal, `hapdef live` on its other end, contacts and
//! what really touches in one recording that others read.

#[path = "../../../hapdef-ros/tests/it/support/read_back.rs"]
mod read_back;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use hapdef_daq::Message;
use hapdef_daq::record::{Content, Recording};
use hapdef_ros::{from_cdr, msg};
use read_back::{flat, read_back};
use serde_json::json;

/// Frames per second, which a full search in each frame keeps up with.
const RATE_HZ: f64 = 50.0;
/// Frames per second of a robot: what the estimator has no time for, it leaves out.
const FAST_HZ: f64 = 1000.0;
/// Most that the wire may add to the median miss at 1 kHz.
const ADDED_MM: f64 = 0.1;
/// Time of the rig, s.
const FOR_S: f64 = 7.0;
/// Most that half of the contacts may be off the truth: the rig is another limb than the model's.
const MEDIAN_MM: f64 = 6.0;
/// Frames of one contact that the estimator has time for at 1 kHz, however busy the machine is.
const LEAST_FRAMES: usize = 200;
/// What a single contact's place is compared from, N.
const FORCE_N: f64 = 10.0;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn hapdef(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hapdef"));
    command.args(words);
    command
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Nothing for 3 s, so that the tare is of nothing however long the start takes; then one finger that
/// slides, and a second one with it.
fn script(folder: &Path) -> PathBuf {
    let finger = json!({"id": 1, "events": [
        {"kind": "arrive", "at_s": 3.0, "for_s": 0.1, "position_m": [0.033, 0.1, 0.012], "force_n": FORCE_N},
        {"kind": "slide", "at_s": 4.0, "for_s": 0.5, "path_m": [[0.033, 0.12, 0.012]]},
        {"kind": "leave", "at_s": 6.0, "for_s": 0.1},
    ]});
    let thumb = json!({"id": 2, "events": [
        {"kind": "arrive", "at_s": 5.0, "for_s": 0.1, "position_m": [-0.03, 0.1, 0.015], "force_n": 15.0},
        {"kind": "leave", "at_s": 6.0, "for_s": 0.1},
    ]});
    let path = folder.join("script.json");
    let script = json!({"version": 1, "contacts": [finger, thumb]});
    std::fs::write(&path, script.to_string()).unwrap();
    path
}

/// A rig that has said its port.
fn rig(link: &Path, truth: &Path, script: &Path, rate_hz: f64) -> Child {
    let seconds = FOR_S.to_string();
    let mut child = hapdef(&["rig", text(&root().join("fixtures/shin/placed.json"))])
        .args(["--link", text(link), "--truth", text(truth)])
        .args(["--script", text(script), "--seconds", &seconds])
        .args(["--rate-hz", &rate_hz.to_string()])
        .arg("--results")
        .arg(root().join("target/hapdef"))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let port = lines.find_map(|line| line.ok().filter(|line| line.starts_with("port ")));
    assert!(port.is_some(), "the rig has not said its port");
    std::thread::spawn(move || lines.map_while(Result::ok).for_each(drop));
    child
}

/// The bundled limb's bundle.
fn bundled(folder: &Path) -> PathBuf {
    let bundle = folder.join("shin.hapdef");
    let made = hapdef(&["bundle", text(&root().join("fixtures/shin/placed.json"))])
        .args(["-o", text(&bundle)])
        .output()
        .unwrap();
    assert!(made.status.success(), "{made:?}");
    bundle
}

fn live(bundle: &Path, source: &str, words: &[&str]) {
    let output = hapdef(&["live", text(bundle), "--source", source])
        .args(["--estimator", "superposition", "--tare-s", "0.5"])
        .args(words)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    println!("{}", said.lines().last().unwrap_or_default());
}

/// What `hapdef live` found of the rig on a pseudo-terminal in so many seconds: the bundle and the
/// recording, both in `folder`.
fn off_the_wire(folder: &Path, rate_hz: f64, seconds: f64) -> (PathBuf, PathBuf) {
    let path = |name: &str| folder.join(name);
    let bundle = bundled(folder);
    let (link, truth, recording) = (path("limb"), path("truth.jsonl"), path("press.mcap"));
    let mut device = rig(&link, &truth, &script(folder), rate_hz);
    let source = format!("serial:{}", text(&link));
    let mut words = vec!["--record", text(&recording), "--truth", text(&truth)];
    let seconds = seconds.to_string();
    words.extend(["--seconds", &seconds]);
    live(&bundle, &source, &words);
    assert!(device.wait().unwrap().success());
    (bundle, recording)
}

/// What it finds of the same readings with as much time as it wants.
fn without_a_wire(folder: &Path, bundle: &Path, recording: &Path) -> Recorded {
    let again = folder.join("again.mcap");
    let source = format!("replay:{}@max", text(recording));
    live(bundle, &source, &["--record", text(&again)]);
    Recorded::read(&again, true)
}

/// What a recording has, by the number of the reading.
#[derive(Default)]
struct Recorded {
    /// Times, ns.
    raw: BTreeMap<u32, u64>,
    found: BTreeMap<u32, msg::Contacts>,
    truth: BTreeMap<u32, msg::Contacts>,
    /// As scripts/read_back.py prints them: topic, time, values.
    contact_lines: BTreeSet<String>,
    reading_lines: BTreeSet<String>,
}

impl Recorded {
    /// A whole recording, or what is left of one that was killed.
    fn read(path: &Path, is_whole: bool) -> Self {
        let mut all = Self::default();
        let mut recording = Recording::open(path).unwrap();
        while let Some(record) = recording.next_record().unwrap() {
            let (topic, time_ns) = (record.topic(), record.log_time_ns);
            let contacts = || from_cdr::<msg::Contacts>(&record.bytes).unwrap();
            let line = |contacts: &msg::Contacts| {
                let mut line = format!("{topic} {time_ns}");
                flat(&serde_json::to_value(contacts).unwrap(), &mut line);
                line
            };
            match (&record.content, topic) {
                (Content::Message(Message::Frame(frame)), _) => {
                    let samples: Vec<String> = frame.bits().iter().map(i32::to_string).collect();
                    let line = format!("/gauges {time_ns} {}", samples.join(" "));
                    all.reading_lines.insert(line);
                    all.raw.insert(frame.seq, time_ns);
                }
                (_, "/hapdef/contacts") => {
                    let contacts = contacts();
                    all.contact_lines.insert(line(&contacts));
                    all.found.insert(contacts.seq, contacts);
                }
                (_, "/hapdef/truth") => {
                    let contacts = contacts();
                    all.contact_lines.insert(line(&contacts));
                    all.truth.insert(contacts.seq, contacts);
                }
                _ => {}
            }
        }
        assert_eq!(recording.damage().is_finished, is_whole);
        all
    }

    /// Distance of the strongest contact that was found from the true one, mm, where one finger presses
    /// with all its force.
    fn misses_mm(&self) -> Vec<f64> {
        let miss = |(seq, truth): (&u32, &msg::Contacts)| {
            let [truth] = &truth.contacts[..] else {
                return None;
            };
            let found = self.found.get(seq)?.contacts.first()?;
            let is_pressed = (truth.force - FORCE_N).abs() < 1e-6;
            let (a, b) = (&found.position, &truth.position);
            let off = [a.x - b.x, a.y - b.y, a.z - b.z];
            let miss_m = off.iter().map(|d| d * d).sum::<f64>().sqrt();
            is_pressed.then_some(miss_m * 1e3)
        };
        self.truth.iter().filter_map(miss).collect()
    }
}

#[test]
fn contacts_off_the_wire_are_those_of_the_readings_and_near_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    // What waits when the rig has ended is still looked at.
    let (bundle, recording) = off_the_wire(folder.path(), RATE_HZ, FOR_S + 4.0);
    let first = Recorded::read(&recording, true);
    let n = first.raw.len();
    println!("{n} readings, {} found, {} true", first.found.len(), first.truth.len());
    assert!(n as f64 > 0.7 * RATE_HZ * FOR_S);
    assert!(first.found.keys().eq(first.raw.keys()));
    assert!(first.truth.keys().all(|seq| first.raw.contains_key(seq)));
    assert!(first.truth.len() > n - n / 20);

    // The same readings without a wire give the same contacts to the last bit.
    let second = without_a_wire(folder.path(), &bundle, &recording);
    assert!(first.raw.keys().eq(second.raw.keys()));
    for (seq, found) in &first.found {
        let (a, b) = (&found.contacts, &second.found[seq].contacts);
        assert_eq!(a, b, "reading {seq}");
    }

    let (median_mm, n_misses) = median(first.misses_mm());
    println!("median {median_mm:.2} mm of {n_misses}");
    assert!(n_misses as f64 > 1.5 * RATE_HZ, "{n_misses}");
    assert!(median_mm < MEDIAN_MM, "{median_mm} mm");
    others_read_it(&recording, &first);
}

/// At a robot's rate the estimator follows contacts, and leaves out frames that it has no time for: it
/// is no less accurate than on the same readings with as much time as it wants.
#[test]
fn a_thousand_frames_a_second_cost_no_accuracy() {
    let folder = tempfile::tempdir().unwrap();
    let (bundle, recording) = off_the_wire(folder.path(), FAST_HZ, FOR_S);
    let on_wire = Recorded::read(&recording, true);
    let n = on_wire.raw.len();
    println!("{n} readings, {} found", on_wire.found.len());
    assert!(n as f64 > 0.7 * FAST_HZ * FOR_S);
    let mut in_peace = without_a_wire(folder.path(), &bundle, &recording);
    assert!(in_peace.found.keys().eq(on_wire.raw.keys()));
    in_peace.truth = on_wire.truth.clone();
    let (wire_mm, n_wire) = median(on_wire.misses_mm());
    let (peace_mm, n_peace) = median(in_peace.misses_mm());
    println!("median {wire_mm:.3} mm of {n_wire}, {peace_mm:.3} of {n_peace}");
    assert!(n_wire >= LEAST_FRAMES && n_peace >= n_wire);
    assert!(wire_mm < peace_mm + ADDED_MM);
}

/// Contacts that were found are as safe in the file as the readings are, whose own loss
/// hapdef-daq's tests bound.
#[test]
fn what_was_found_survives_kill_9() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let bundle = bundled(folder.path());
    let (link, truth, recording) = (path("limb"), path("truth.jsonl"), path("press.mcap"));
    let mut device = rig(&link, &truth, &script(folder.path()), RATE_HZ);
    let source = format!("serial:{}", text(&link));
    let mut program = hapdef(&["live", text(&bundle), "--source", &source])
        .args(["--estimator", "superposition", "--tare-s", "0.5"])
        .args(["--record", text(&recording)])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(5));
    program.kill().unwrap();
    program.wait().unwrap();
    device.kill().unwrap();
    device.wait().unwrap();
    let left = Recorded::read(&recording.with_extension("partial.mcap"), false);
    let read = left.raw.keys().last().copied();
    let found = left.found.keys().last().copied();
    println!("{} readings, {} found", left.raw.len(), left.found.len());
    assert!(left.raw.len() as f64 > 2.0 * RATE_HZ);
    let late_s = (f64::from(read.unwrap()) - f64::from(found.unwrap())) / RATE_HZ;
    assert!(late_s <= 0.15, "{late_s} s");
}

/// Median, and of how many.
fn median(mut values: Vec<f64>) -> (f64, usize) {
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], values.len())
}

/// Other programs read what our reader reads: contacts and truth by mcap-ros2-support, rosbags and rerun
/// to the last bit of every number, readings by mcap.
fn others_read_it(recording: &Path, ours: &Recorded) {
    if let Some(output) = read_back("mcap, mcap_ros2, rosbags", &[recording]) {
        let read = String::from_utf8(output.stdout).unwrap();
        assert_eq!(of_reader(&read, "mcap-ros2"), ours.contact_lines);
        assert_eq!(of_reader(&read, "rosbags"), ours.contact_lines);
        assert_eq!(of_reader(&read, "mcap"), ours.reading_lines);
    }
    if let Some(output) = read_back("rerun.chunk", &[Path::new("--rerun"), recording]) {
        let read = String::from_utf8(output.stdout).unwrap();
        assert_eq!(of_reader(&read, "rerun"), ours.contact_lines);
    }
}

/// What a reader says of contacts, truth and readings: topic, time, values.
fn of_reader(read: &str, reader: &str) -> BTreeSet<String> {
    let is_of = |line: &&str| {
        let topics = ["/hapdef/contacts ", "/hapdef/truth ", "/gauges "];
        topics.iter().any(|topic| line.starts_with(topic))
    };
    let lines = read.lines().filter_map(|line| line.split_once(' '));
    let own = lines.filter(|(name, _)| *name == reader);
    let rest = own.map(|(_, rest)| rest).filter(is_of);
    rest.map(str::to_owned).collect()
}
