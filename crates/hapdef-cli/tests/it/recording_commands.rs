//! `hapdef record`, `replay`, `recover`, `export` and `doctor`, as commands.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::record::{Content, RecordParams, Recording, record};
use hapdef_daq::source::ReplaySource;
use hapdef_daq::{AcquireParams, Frame, Message, acquire};
use rustix::process::Signal;
use serde_json::Value;

use crate::support::damage::flip_amid_a_chunk;

fn hapdef(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hapdef"));
    command.args(arguments);
    command
}

fn run(arguments: &[&str]) -> Output {
    hapdef(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A device of four channels at 1 kHz in two scans a packet: one moves, one is dead, one is at the
/// end of its range, one has a tooth; packets 100 to 104 are lost.
pub(crate) fn made(folder: &Path, n: u32) -> PathBuf {
    let mut hello = Hello::plain(4, SampleFormat::I16, 1000);
    hello.n_scans = 2;
    hello.seal();
    let frames = (0..2 * n).filter(|i| !(100..105).contains(&(i / 2))).map(|i| {
        let seq = i / 2;
        let wave = (1000.0 * (f64::from(i) * 0.1).sin()) as i32;
        let samples = [wave, 5, 32767, (i % 17) as i32 - 8];
        let mut frame = Frame::new(seq, SampleFormat::I16, samples);
        frame.scan = (i % 2) as u8;
        frame.n_lost_before = if i == 210 { 5 } else { 0 };
        frame.t_device_us = 1_000_000 + u64::from(i) * 1000;
        frame.t_host_ns = 5_000_000_000 + u64::from(i) * 1_000_000;
        Message::Frame(frame)
    });
    let messages: Vec<Message> =
        std::iter::once(Message::Hello(Arc::new(hello))).chain(frames).collect();
    let source = ReplaySource::new("made up", messages.into_iter(), f64::INFINITY);
    let params = AcquireParams { ring_len: 1 << 14, ..AcquireParams::default() };
    let (_acquisition, mut receivers) = acquire(source, params).unwrap();
    let path = folder.join("made.mcap");
    let recorder = record(receivers.remove(0), &path, RecordParams::default()).unwrap();
    while recorder.stats().n_frames < u64::from(2 * n - 10) {
        std::thread::sleep(Duration::from_millis(5));
    }
    recorder.finish().unwrap();
    path
}

/// Frames with what a wire carries of them.
fn frames(path: &Path) -> Vec<(u32, u8, u32, u64, Vec<i32>)> {
    let messages = Recording::open(path).unwrap().messages();
    let frames = messages.filter_map(|message| match message {
        Message::Frame(f) => {
            let bits = f.bits().to_vec();
            Some((f.seq, f.scan, f.n_lost_before, f.t_device_us, bits))
        }
        _ => None,
    });
    frames.collect()
}

/// A replay as a device, and what a host opens.
fn device(arguments: &[&str]) -> (Child, String) {
    let mut child = hapdef(arguments).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    let mut stdout = BufReader::new(child.stdout.take().unwrap());
    stdout.read_line(&mut line).unwrap();
    (child, line.trim().to_owned())
}

#[track_caller]
fn check_wire(form: &[&str], ended_by: Signal) {
    let folder = tempfile::tempdir().unwrap();
    let original = made(folder.path(), 600);
    let again = folder.path().join("again.mcap");
    let mut arguments = vec!["replay", text(&original), "--speed", "4"];
    arguments.extend(form);
    let (mut child, source) = device(&arguments);
    let recorded = hapdef(&["record", "--source", &source, "-o", text(&again)])
        .args(["--seconds", "60", "--quiet"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    assert!(child.wait().unwrap().success());
    std::thread::sleep(Duration::from_millis(300));
    let pid = rustix::process::Pid::from_child(&recorded);
    rustix::process::kill_process(pid, ended_by).unwrap();
    let output = recorded.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(frames(&again), frames(&original));
    let mut recording = Recording::open(&again).unwrap();
    while recording.next_record().unwrap().is_some() {}
    assert!(recording.damage().is_finished);
}

#[test]
fn a_second_recorder_of_the_same_name_is_refused_and_the_first_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let original = made(folder.path(), 1500);
    let (mut child, source) = device(&["replay", text(&original), "--tcp", "127.0.0.1:0"]);
    let path = folder.path().join("two.mcap");
    let record = |source: &str| {
        let mut command = hapdef(&["record", "--source", source, "--quiet", "-o", text(&path)]);
        command.stderr(Stdio::piped()).stdout(Stdio::piped());
        command
    };
    let first = record(&source).spawn().unwrap();
    while !folder.path().join("two.partial.mcap").exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    let second = record(&source).arg("--force").output().unwrap();
    let said = String::from_utf8_lossy(&second.stderr);
    assert_eq!(second.status.code(), Some(2), "{said}");
    assert!(said.contains("two.partial.mcap: another program is writing it"), "{said}");
    assert!(child.wait().unwrap().success());
    std::thread::sleep(Duration::from_millis(300));
    let pid = rustix::process::Pid::from_child(&first);
    rustix::process::kill_process(pid, Signal::TERM).unwrap();
    let output = first.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(frames(&path), frames(&original));
}

#[test]
fn devices_listen_beyond_this_machine_only_when_asked_to() {
    let folder = tempfile::tempdir().unwrap();
    let original = made(folder.path(), 100);
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/placed.json");
    for words in [["rig", text(&scene)], ["replay", text(&original)]] {
        for address in ["0.0.0.0:0", "[::]:0"] {
            let refused = run(&[&words[..], &["--tcp", address]].concat());
            let said = String::from_utf8_lossy(&refused.stderr);
            assert_eq!(refused.status.code(), Some(2), "{said}");
            assert!(said.contains("--insecure-bind") && said.contains(address), "{said}");
        }
    }
    let words = ["replay", text(&original), "--tcp", "0.0.0.0:0", "--insecure-bind"];
    let (mut child, address) = device(&words);
    assert!(address.starts_with("tcp:0.0.0.0:"), "{address}");
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn lines_of_another_number_end_a_recording_with_both_numbers() {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    rustix::io::ioctl_fionbio(&master, true).unwrap();
    let path = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let source = format!("csv:{path}@9");
    let out = folder.path().join("x.mcap");
    let child = hapdef(&["record", "--source", &source, "--quiet", "-o", text(&out)])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(4) {
        let _ = rustix::io::write(&master, b"1,2,3,4,5,6,7,8,9,10\r\n");
        std::thread::sleep(Duration::from_millis(5));
    }
    let ended = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(2), "{said}");
    assert!(said.contains("lines of 10 numbers come, 9 are expected"), "{said}");
}

#[test]
fn a_recording_played_over_tcp_and_recorded_again_is_the_same() {
    check_wire(&["--tcp", "127.0.0.1:0"], Signal::TERM);
}

#[test]
fn a_recording_played_on_a_pty_and_recorded_again_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    check_wire(&["--pty", text(&folder.path().join("limb"))], Signal::INT);
}

#[test]
fn a_replay_is_recorded_to_its_end_with_the_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let original = made(folder.path(), 300);
    let calibration = folder.path().join("c.json");
    std::fs::write(&calibration, "{\"tare\": 1}").unwrap();
    let again = folder.path().join("again.mcap");
    let source = format!("replay:{}@max", text(&original));
    let mut arguments = vec!["record", "--source", &source, "-o", text(&again)];
    arguments.extend(["--calibration", text(&calibration)]);
    let output = run(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(frames(&again), frames(&original));
    let mut recording = Recording::open(&again).unwrap();
    let mut n_calibrations = 0;
    while let Some(record) = recording.next_record().unwrap() {
        if let Content::Calibration(json) = record.content {
            assert_eq!(json, b"{\"tare\": 1}");
            n_calibrations += 1;
        }
    }
    assert_eq!(n_calibrations, 1);
    // Nothing is overwritten unasked.
    let refused = run(&arguments);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--force"));
}

#[test]
fn recover_says_by_its_exit_code_what_was_lost() {
    let folder = tempfile::tempdir().unwrap();
    let whole = made(folder.path(), 600);
    let out = |name: &str| folder.path().join(name);
    let recover = |file: &Path, to: &str| {
        let to = out(to);
        run(&["recover", text(file), "-o", text(&to), "--json"])
    };
    let saved = recover(&whole, "a.mcap");
    assert_eq!(saved.status.code(), Some(0));
    let info: Value = serde_json::from_slice(&saved.stdout).unwrap();
    assert_eq!(info["n_frames"], 1190);

    let mut bytes = std::fs::read(&whole).unwrap();
    flip_amid_a_chunk(&mut bytes);
    std::fs::write(out("bad.mcap"), &bytes).unwrap();
    let saved = recover(&out("bad.mcap"), "b.mcap");
    assert_eq!(saved.status.code(), Some(1));
    let info: Value = serde_json::from_slice(&saved.stdout).unwrap();
    assert_eq!(info["n_damaged"], 1, "{info}");
    let n = frames(&out("b.mcap")).len() as u64;
    assert_eq!(info["n_frames"], n);
    assert!(n > 0 && n < 1190, "{info}");

    std::fs::write(out("none.mcap"), vec![7; 10_000]).unwrap();
    assert_eq!(recover(&out("none.mcap"), "c.mcap").status.code(), Some(3));
    assert_eq!(recover(&out("nowhere.mcap"), "c.mcap").status.code(), Some(2));
    assert_eq!(recover(&whole, "a.mcap").status.code(), Some(2));
}

#[test]
fn nothing_is_overwritten_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let whole = made(folder.path(), 600);
    let path = |name: &str| folder.path().join(name);
    let (partial, saved) = (path("press.partial.mcap"), path("press.mcap"));
    std::fs::copy(&whole, &partial).unwrap();
    let before = std::fs::read(&partial).unwrap();
    let source = format!("replay:{}@max", text(&whole));
    let refused = |words: &[&str], expected: &str| {
        let output = run(words);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert!(said.contains(expected), "{expected:?} is not in: {said}");
        assert_eq!(std::fs::read(&partial).unwrap(), before, "{words:?}");
    };
    // What a killed recording left is saved first, by the command that the refusal names.
    let again = ["record", "--source", &source, "-o", text(&saved), "--quiet"];
    refused(&again, "hapdef recover");
    refused(&["recover", text(&partial), "-o", text(&partial)], "is there already");
    let recovered = run(&["recover", text(&partial), "-o", text(&saved)]);
    assert_eq!(recovered.status.code(), Some(0), "{recovered:?}");
    assert_eq!(std::fs::read(&partial).unwrap(), before);
    assert_eq!(frames(&saved), frames(&whole));
    refused(&again, "--force");

    let table = path("press.csv");
    for form in ["--csv", "--jsonl"] {
        let export = ["export", text(&partial), form, "-o"];
        refused(&[&export[..], &[text(&partial)]].concat(), "is there already");
    }
    let export = ["export", text(&whole), "--csv", "-o", text(&table)];
    assert!(run(&export).status.success());
    refused(&export, "press.csv is there already");
    assert!(run(&["export", text(&whole), "--csv", "-o", "/dev/null"]).status.success());

    let forced = run(&[&again[..], &["--force"]].concat());
    assert!(forced.status.success(), "{forced:?}");
    assert_eq!(frames(&saved), frames(&whole));
    assert!(!partial.exists());
}

#[test]
fn text_has_every_reading() {
    let folder = tempfile::tempdir().unwrap();
    let whole = made(folder.path(), 200);
    let csv = run(&["export", text(&whole), "--csv"]).stdout;
    let csv = String::from_utf8(csv).unwrap();
    assert_eq!(csv.lines().count(), 1 + 390);
    assert!(csv.lines().next().unwrap().ends_with("G0,G1,G2,G3"));
    let exported = run(&["export", text(&whole), "--jsonl"]).stdout;
    let replayed = run(&["replay", text(&whole), "--json", "--speed", "max"]).stdout;
    assert_eq!(exported, replayed);
    for line in String::from_utf8(exported).unwrap().lines() {
        let value: Value = serde_json::from_str(line).unwrap();
        assert!(value["topic"].is_string() && value["message"].is_object());
    }
}

#[test]
fn a_replay_has_its_pace() {
    let folder = tempfile::tempdir().unwrap();
    let whole = made(folder.path(), 300);
    let start = Instant::now();
    run(&["replay", text(&whole), "--json", "--speed", "2"]);
    let took = start.elapsed();
    // 0.6 s of readings at twice their pace.
    assert!(took >= Duration::from_millis(290), "{took:?}");
    assert!(took < Duration::from_secs(5), "{took:?}");
}

#[test]
fn doctor_finds_what_is_wrong_with_the_channels() {
    let folder = tempfile::tempdir().unwrap();
    let whole = made(folder.path(), 300);
    let source = format!("replay:{}@max", text(&whole));
    let place = text(folder.path());
    let output = run(&["doctor", "--source", &source, "--folder", place, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let checks: Value = serde_json::from_slice(&output.stdout).unwrap();
    let found = |name: &str| {
        let all = checks.as_array().unwrap().iter();
        let one = all.clone().find(|check| check["check"] == name);
        let one = one.unwrap_or_else(|| panic!("{name}: {checks}"));
        (one["state"].as_str().unwrap(), one["found"].as_str().unwrap())
    };
    assert_eq!(found("channel 1 (G1)"), ("bad", "always 5"));
    assert_eq!(found("channel 2 (G2)").0, "bad");
    assert_eq!(found("channels").0, "ok");
    assert_eq!(found("rate").0, "ok");
    assert_ne!(found("losses").0, "ok");
    assert_ne!(found("disk speed").0, "bad");
    for check in checks.as_array().unwrap() {
        assert_eq!(check["state"] != "ok", check["fix"].is_string(), "{check}");
    }
}

#[test]
fn a_topic_is_recorded_as_a_device() {
    let folder = tempfile::tempdir().unwrap();
    let made = made(folder.path(), 300);
    let out = folder.path().join("topic.mcap");
    let source = format!("replay:{}@max", text(&made));
    let recorded = run(&["record", "--source", &source, "--topic", "/gauges", "-o", text(&out)]);
    assert!(recorded.status.success(), "{recorded:?}");
    let values = |path: &Path| -> Vec<Vec<f64>> {
        let messages = Recording::open(path).unwrap().messages();
        let frames = messages.filter_map(|message| match message {
            Message::Frame(frame) => Some(frame.values().collect()),
            _ => None,
        });
        frames.collect()
    };
    assert_eq!(values(&out), values(&made));

    let refused = |arguments: &[&str], expected: &str| {
        let output = run(arguments);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && error.contains(expected), "{output:?}");
    };
    let new = folder.path().join("new.mcap");
    let record = |source: &str, topic: &str, expected: &str| {
        refused(&["record", "--source", source, "--topic", topic, "-o", text(&new)], expected);
    };
    record(&source, "/strain", "no topic /strain; it has /gauges (hapdef.Gauges, json)");
    record("tcp:127.0.0.1:7000", "/strain", "a topic is read of a file, replay:FILE, or of ROS 2");
    if cfg!(not(feature = "zenoh")) {
        record("ros2:0", "/strain", "ros2:0, topic /strain: this build has no zenoh");
        record("ros2:0", "/strain", "build with --features zenoh");
    }
    let out = text(&new);
    refused(&["record", "--source", "ros2:0", "-o", out], "ros2:0: expected the topic of the");
}
