//! `hapdef live robot.json`: several limbs in one program, each with names of its own.

use crate::support::page;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use hapdef_daq::record::{Content, Recording};
use hapdef_ros::{from_cdr, msg};
use page::Program;
use serde_json::{Value, json};

const LIMBS: [&str; 2] = ["left_shin", "right_shin"];

/// A robot of two simulated limbs, changed.
fn robot_with(folder: &Path, change: impl FnOnce(&mut Value)) -> PathBuf {
    page::scene(folder);
    let limb = |(i, name): (usize, &str)| json!({"name": name, "scene": "scene.json", "source": "sim", "seed": i + 1, "frame": format!("{name}_link")});
    let limbs: Vec<Value> = LIMBS.into_iter().enumerate().map(limb).collect();
    let mut robot = json!({"name": "biped", "limbs": limbs});
    change(&mut robot);
    let path = folder.join("robot.json");
    std::fs::write(&path, robot.to_string()).unwrap();
    path
}

fn live(robot: &Path, words: &[&str]) -> Command {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/hapdef");
    let mut command = Command::new(env!("CARGO_BIN_EXE_hapdef"));
    command.arg("live").arg(robot).args(["--tare-s", "0.3", "--results"]).arg(results).args(words);
    command
}

/// Lines of JSON by the limb that they name.
fn by_limb(output: &Output) -> BTreeMap<String, Vec<Value>> {
    let mut lines = BTreeMap::<String, Vec<Value>>::new();
    for line in std::str::from_utf8(&output.stdout).unwrap().lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        lines.entry(line["limb"].as_str().unwrap().to_owned()).or_default().push(line);
    }
    lines
}

fn n_frames(lines: &[Value]) -> usize {
    lines.iter().filter(|line| line.get("seq").is_some()).count()
}

#[test]
fn two_limbs_run_and_no_name_collides() {
    let folder = tempfile::tempdir().unwrap();
    let robot = robot_with(folder.path(), |_| {});
    let recordings = folder.path().join("recordings");
    let words = ["--json", "--seconds", "2", "--record", recordings.to_str().unwrap()];
    let output = live(&robot, &words).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    let lines = by_limb(&output);
    assert_eq!(lines.keys().collect::<Vec<_>>(), LIMBS);
    for (limb, lines) in &lines {
        assert!(n_frames(lines) > 300, "{limb}: {} frames", n_frames(lines));
        assert!(lines.iter().any(|line| line["event"] == "tared"), "{limb} was not tared");
        let begins = |words: &str| said.lines().any(|l| l.starts_with(limb) && l.contains(words));
        assert!(begins(" frames, ") && begins(" readings, "), "{said}");
    }
    let topics = LIMBS.map(|limb| topics_of(&recordings.join(format!("{limb}.mcap")), limb));
    let shared: Vec<&String> = topics[0].intersection(&topics[1]).collect();
    let may_be = ["/tf", "/diagnostics", "/biped/contacts"];
    assert!(shared.iter().all(|topic| may_be.contains(&topic.as_str())), "{shared:?}");
    both_are_in_the_robots_contacts(&recordings);
    let again = live(&robot, &words).output().unwrap();
    let said = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(!again.status.success() && said.contains("left_shin.mcap is there already"), "{said}");
}

/// Topics of messages in a limb's recording, whose contacts are in the limb's frame.
fn topics_of(recording: &Path, limb: &str) -> BTreeSet<String> {
    let mut records = Recording::open(recording).unwrap();
    let (mut topics, mut n_lists) = (BTreeSet::new(), 0);
    while let Some(record) = records.next_record().unwrap() {
        let Content::Further(topic) = &record.content else {
            continue;
        };
        if topic.name == format!("/biped/{limb}/contacts") {
            let contacts = from_cdr::<msg::Contacts>(&record.bytes).unwrap();
            assert_eq!(contacts.header.frame_id, format!("{limb}_link"));
            n_lists += 1;
        }
        topics.insert(topic.name.clone());
    }
    assert!(records.damage().is_finished);
    assert!(n_lists > 300, "{n_lists} lists of contacts");
    topics
}

/// Messages of all limbs have both, in their frames, once both have begun; 100 times a second at most.
fn both_are_in_the_robots_contacts(recordings: &Path) {
    let mut stamps_ns = Vec::new();
    let mut n_both = 0;
    for limb in LIMBS {
        let mut records = Recording::open(&recordings.join(format!("{limb}.mcap"))).unwrap();
        while let Some(record) = records.next_record().unwrap() {
            if record.topic() != "/biped/contacts" {
                continue;
            }
            let robot = from_cdr::<msg::RobotContacts>(&record.bytes).unwrap();
            let frames: Vec<&str> =
                robot.limbs.iter().map(|limb| limb.header.frame_id.as_str()).collect();
            n_both += usize::from(frames == ["left_shin_link", "right_shin_link"]);
            stamps_ns.push(record.log_time_ns);
        }
    }
    stamps_ns.sort_unstable();
    assert!(n_both > 50 && 2 * n_both > stamps_ns.len(), "{n_both} of {}", stamps_ns.len());
    let is_apart = |pair: &[u64]| pair[1] - pair[0] >= 9_900_000;
    assert!(stamps_ns.windows(2).all(is_apart), "more than 100 a second");
}

#[test]
fn lines_of_words_begin_with_the_limb() {
    let folder = tempfile::tempdir().unwrap();
    let robot = robot_with(folder.path(), |_| {});
    let output = live(&robot, &["--seconds", "1"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let of =
        |limb: &str| text.lines().filter(|line| line.starts_with(&format!("{limb}: "))).count();
    let n = LIMBS.map(of);
    assert!(n.iter().all(|n| *n > 100), "{n:?}");
    assert_eq!(n.iter().sum::<usize>(), text.lines().count());
}

#[test]
fn clients_get_the_lines_of_both_and_ctrl_c_ends_both() {
    let folder = tempfile::tempdir().unwrap();
    let robot = robot_with(folder.path(), |_| {});
    let recordings = folder.path().join("recordings");
    let record = recordings.to_str().unwrap();
    let mut child = live(&robot, &["--serve", "tcp:127.0.0.1:0", "--record", record])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    let address = said.find_map(|line| Some(line.strip_prefix("JSON lines at tcp:")?.to_owned()));
    let stream = TcpStream::connect(address.unwrap()).unwrap();
    let mut limbs = BTreeSet::new();
    for line in BufReader::new(stream).lines().take(2000) {
        let line: Value = serde_json::from_str(&line.unwrap()).unwrap();
        let limb = line["limb"].as_str().unwrap().to_owned();
        if line.get("seq").is_some() {
            limbs.insert(limb);
        }
        if limbs.len() == LIMBS.len() {
            break;
        }
    }
    assert_eq!(limbs.into_iter().collect::<Vec<_>>(), LIMBS);
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let rest: Vec<String> = said.collect();
    assert!(child.wait().unwrap().success(), "{rest:?}");
    for limb in LIMBS {
        let is_told =
            |line: &String| line.starts_with(&format!("{limb}: ")) && line.contains(" frames, ");
        assert!(rest.iter().any(is_told), "{rest:?}");
        let mut records = Recording::open(&recordings.join(format!("{limb}.mcap"))).unwrap();
        while records.next_record().unwrap().is_some() {}
        assert!(records.damage().is_finished, "{limb}");
    }
}

#[test]
fn a_limb_whose_device_is_away_stops_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let nobody = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let robot = robot_with(folder.path(), |robot| {
        let limb = robot["limbs"][0].as_object_mut().unwrap();
        limb.remove("seed");
        limb.insert("source".to_owned(), json!(format!("tcp:{nobody}")));
    });
    let output = live(&robot, &["--json", "--seconds", "1.5"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("limb left_shin: ") && said.contains("not one reading came"), "{said}");
    assert!(!said.contains("limb right_shin: "), "{said}");
    let lines = by_limb(&output);
    assert!(n_frames(&lines["right_shin"]) > 300, "{} frames", n_frames(&lines["right_shin"]));
}

#[test]
fn options_of_one_limb_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let robot = robot_with(folder.path(), |_| {});
    let file = folder.path().join("a file");
    std::fs::write(&file, "").unwrap();
    let file = file.to_str().unwrap();
    for words in [
        &["--csv", "a.csv"][..],
        &["--loads", "a.json"],
        &["--alert", "udp:127.0.0.1:9"],
        &["--foxglove", "127.0.0.1:8765"],
        &["--prefix", "/arm"],
        &["--frame", "link"],
        &["--sim"],
        &["--source", "tcp:robot:7000"],
        &["--topic", "/strain"],
        &["--record", file],
    ] {
        let output = live(&robot, words).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(words[0]), "{words:?}: {said}");
    }
    let output = live(&folder.path().join("scene.json"), &[]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("--source"), "{said}");
}

/// One port, one token: each limb's page has its own limb, and presses it alone.
#[test]
fn each_limb_has_its_page() {
    let folder = tempfile::tempdir().unwrap();
    let robot = robot_with(folder.path(), |_| {});
    let out = folder.path().join("kept");
    let words = ["--tare-s", "0.5", "--view-out", out.to_str().unwrap()];
    let program = Program::start(&robot, &words, 0);
    let mut pages = LIMBS.map(|limb| program.page_of(limb));
    for (page, limb) in pages.iter_mut().zip(LIMBS) {
        assert_eq!(page.hello["title"], limb);
        page.hear("Tared");
    }
    let (point, normal) = pages[1].node(700);
    pages[1].say(&json!({"cmd": "random", "on": false}));
    pages[0].say(&json!({"cmd": "random", "on": false}));
    pages[1].say(&json!({"cmd": "press", "point_m": point, "normal": normal, "force_n": 15.0}));
    pages[1].until("the press is found", |frame| frame.contacts.len() == 1);
    pages[0].until("nothing presses the other", |frame| frame.contacts.is_empty());
    pages[1].say(&json!({"cmd": "record", "on": true}));
    let said = pages[1].hear("Recording to ");
    assert!(said.contains("right_shin"), "{said}");
}
