//! `hapdef bundle` and `hapdef live` as a person uses them: a recording, played into contacts.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::record::{Content, RecordParams, Recording, record};
use hapdef_daq::source::ReplaySource;
use hapdef_daq::{AcquireParams, Frame, Message, acquire};
use hapdef_inverse::SkinPoint;
use hapdef_live::Bundle;
use hapdef_ros::{from_cdr, msg};
use serde_json::Value;

use crate::support::damage::flip_amid_a_chunk;

/// µε per count.
const SCALE: f32 = 1.0 / 64.0;

fn hapdef(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hapdef")).args(words).output().unwrap()
}

fn placed() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/placed.json")
}

/// 300 frames of nothing, then 15 N that come in 40 ms and stay for 460; counts wobble by one.
fn messages(bundle: &Bundle) -> Vec<Message> {
    let point = SkinPoint::new(bundle.skin(), 700, [0.5, 0.3, 0.2]).unwrap();
    let unit = bundle.map().normal(&point);
    let mut hello = Hello::plain(unit.len(), SampleFormat::I32, 1000);
    hello.channels.iter_mut().for_each(|c| c.scale = SCALE);
    hello.seal();
    let frame = |i: usize| {
        let force_n = 15.0 * (i.saturating_sub(300) as f64 / 40.0).min(1.0);
        let wobble =
            |g: usize| 0.5 * ((12.9 * i as f64 + 78.2 * g as f64).sin() * 43_758.5).fract();
        let counts = unit
            .iter()
            .enumerate()
            .map(|(g, unit)| ((unit * force_n + wobble(g)) / f64::from(SCALE)).round() as i32);
        let mut frame = Frame::new(i as u32, SampleFormat::I32, counts);
        frame.t_device_us = 1000 * i as u64;
        frame.t_host_ns = 1_000_000 * i as u64;
        Message::Frame(frame)
    };
    let hello = Message::Hello(Arc::new(hello));
    std::iter::once(hello).chain((0..800).map(frame)).collect()
}

fn record_to(path: &Path, messages: Vec<Message>) {
    // At its own pace, so that it has a chunk every 80 ms.
    let source = ReplaySource::new("test", messages.into_iter(), 1.0);
    let (acquisition, mut receivers) = acquire(source, AcquireParams::default()).unwrap();
    let params = RecordParams { min_free_bytes: 1 << 20, ..RecordParams::default() };
    let recorder = record(receivers.remove(0), path, params).unwrap();
    while !acquisition.has_ended() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(recorder.finish().unwrap().n_frames, 800);
}

#[test]
fn a_recording_is_played_into_contacts() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (file, recording) = (path("shin.hapdef"), path("press.mcap"));
    let table = path("press.csv");
    let made = hapdef(&["bundle", placed().to_str().unwrap(), "-o", &file, "--json"]);
    assert!(made.status.success(), "{made:?}");
    let bundle = Bundle::read(file.as_ref()).unwrap();
    record_to(recording.as_ref(), messages(&bundle));
    the_doctor_looks_at_it(&file, &recording);
    let source = format!("replay:{recording}@max");
    let play = |table: &str| {
        let words = ["live", &file, "--source", &source, "--tare-s", "0.2", "--json"];
        let played = hapdef(&[&words[..], &["--csv", table]].concat());
        assert!(played.status.success(), "{played:?}");
        let text = String::from_utf8(played.stdout).unwrap();
        let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        lines.filter(|line| line.get("seq").is_some()).collect::<Vec<_>>()
    };
    let frames = play(&table);
    assert_eq!(frames.len(), 800);
    assert_eq!(frames, play(&path("again.csv")));
    let contacts = frames[799]["contacts"].as_array().unwrap();
    assert_eq!(contacts.len(), 1, "{}", frames[799]);
    let point = SkinPoint::new(bundle.skin(), 700, [0.5, 0.3, 0.2]).unwrap();
    let truth = bundle.skin().position(&point);
    let miss_mm = (0..3)
        .map(|i| contacts[0]["position_m"][i].as_f64().unwrap() - truth[i])
        .map(|d| d * d)
        .sum::<f64>()
        .sqrt()
        * 1e3;
    assert!(miss_mm < 2.0, "{miss_mm} mm");
    assert!((contacts[0]["force_n"].as_f64().unwrap() - 15.0).abs() < 1.0);
    assert_eq!(std::fs::read_to_string(&table).unwrap().lines().count(), 801);
    refused(&["live", &file, "--source", &source, "--csv", &table], &["--csv", "is there already"]);
    let reach = ["live", &file, "--source", &source, "--serve"];
    refused(&[&reach[..], &["tcp:0.0.0.0:0"]].concat(), &["--insecure-bind"]);
    let everywhere = ["live", &file, "--source", &source, "--view"];
    let everywhere = [&everywhere[..], &["--view-bind", "0.0.0.0"]].concat();
    refused(&everywhere, &["--view-bind", "--insecure-bind"]);
    refused(&[&everywhere[..], &["--insecure-bind"]].concat(), &["--view-bind", "--view-host"]);
    a_full_disk_is_told_while_it_goes_on(&file, &recording, &path("full.mcap"));
    the_calibration_in_use_is_recorded(&bundle, &source, folder.path());
    limbs_have_topics_and_frames_of_their_own(&file, &source, folder.path());
    a_controller_is_told_to_stop(&file, &source);
    the_net_wrench_is_that_of_the_contact(&frames[799]);
    damage_is_told_and_counted(&file, &recording);
}

/// A press of 15 N that comes in 40 ms: unknown while it tares, clear, a warning, a stop, which the end of the program does not end.
fn a_controller_is_told_to_stop(file: &str, source: &str) {
    let controller = UdpSocket::bind("127.0.0.1:0").unwrap();
    controller.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let address = format!("udp:{}", controller.local_addr().unwrap());
    let live = ["live", file, "--source", source, "--tare-s", "0.2", "--json"];
    let played =
        hapdef(&[&live[..], &["--alert", &address, "--warn-n", "2", "--stop-n", "5:4"]].concat());
    assert!(played.status.success(), "{played:?}");
    let (mut letters, mut bytes) = (String::new(), [0; 64]);
    controller.set_nonblocking(true).unwrap();
    while let Ok(n) = controller.recv(&mut bytes) {
        let line = std::str::from_utf8(&bytes[..n]).unwrap();
        let [letter, force_n, t_ns] =
            line.trim_end().split(' ').collect::<Vec<_>>().try_into().unwrap();
        let force_n: f64 = force_n.parse().unwrap();
        t_ns.parse::<u64>().unwrap();
        assert_eq!(letter == "S" && force_n > 0.0, force_n >= 5.0, "{line}");
        if !letters.ends_with(letter) {
            letters += letter;
        }
    }
    assert_eq!(letters, "UCWS");
    refused(
        &[&live[..], &["--alert", &address, "--stop-n", "2:3"]].concat(),
        &["--stop-n", "3", "not above the force"],
    );
    refused(&[&live[..], &["--alert", "tcp:1.2.3.4:5"]].concat(), &["--alert", "udp:HOST:PORT"]);
}

/// About the origin: force f d, moment p × f d.
fn the_net_wrench_is_that_of_the_contact(frame: &Value) {
    let numbers = |value: &Value| [0, 1, 2].map(|i| value[i].as_f64().unwrap());
    let contact = &frame["contacts"][0];
    let direction = numbers(&contact["direction"]);
    let force_n = direction.map(|d| d * contact["force_n"].as_f64().unwrap());
    let [x, y, z] = numbers(&contact["position_m"]);
    let [a, b, c] = force_n;
    let moment_nm = [y * c - z * b, z * a - x * c, x * b - y * a];
    for (name, expected) in [("force_n", force_n), ("moment_nm", moment_nm)] {
        let found = numbers(&frame["wrench"][name]);
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-9), "{name}: {found:?}");
    }
    let variance = frame["wrench"]["covariance"][0][0].as_f64().unwrap();
    let force_sd_n = contact["force_sd_n"].as_f64().unwrap();
    assert!((variance.sqrt() - force_sd_n * direction[0].abs()).abs() < 1e-9);
    assert!(frame["t_done_ns"].as_u64().is_some());
}

/// Two limbs of a robot share no topic but those that all share, and no frame.
fn limbs_have_topics_and_frames_of_their_own(file: &str, source: &str, folder: &Path) {
    let live = ["live", file, "--source", source];
    refused(
        &[&live[..], &["--prefix", "left"]].concat(),
        &["--prefix", "prefix", "/left_arm/shin", "left"],
    );
    refused(&[&live[..], &["--frame", "my limb"]].concat(), &["--frame", "frame_id", "my limb"]);
    let topics_of = |limb: &str| {
        let recording = folder.join(format!("{limb}.mcap"));
        let prefix = format!("/robot/{limb}");
        let named = ["--prefix", &prefix, "--frame", limb, "--record", recording.to_str().unwrap()];
        let played = hapdef(&[&live[..], &named].concat());
        assert!(played.status.success(), "{played:?}");
        let mut records = Recording::open(&recording).unwrap();
        let (mut topics, mut frames) = (BTreeSet::new(), BTreeSet::new());
        while let Some(record) = records.next_record().unwrap() {
            let Content::Further(topic) = &record.content else {
                continue;
            };
            if topic.name == format!("{prefix}/contacts") {
                let contacts = from_cdr::<msg::Contacts>(&record.bytes).unwrap();
                frames.insert(contacts.header.frame_id);
            }
            topics.insert(topic.name.clone());
        }
        assert_eq!(frames.into_iter().collect::<Vec<_>>(), [limb]);
        topics
    };
    let both = [topics_of("left_shin"), topics_of("right_shin")];
    let shared: Vec<&String> = both[0].intersection(&both[1]).collect();
    assert!(
        shared.iter().all(|topic| ["/tf", "/diagnostics"].contains(&topic.as_str())),
        "{shared:?}"
    );
    assert!(both[0].contains("/robot/left_shin/status"), "{:?}", both[0]);
}

/// Frames at a fifth of their pace, to a disk that is full after 64 KiB.
fn a_full_disk_is_told_while_it_goes_on(file: &str, recording: &str, to: &str) {
    let source = format!("replay:{recording}@0.2");
    let start = Instant::now();
    let mut child = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 128; exec \"$@\"", "sh"])
        .arg(env!("CARGO_BIN_EXE_hapdef"))
        .args(["live", file, "--source", &source, "--record", to])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let reported = lines.find(|line| line.as_ref().unwrap().contains("the recording stopped"));
    let after = start.elapsed();
    assert!(reported.is_some(), "nothing was reported");
    // It goes on for 4 s without it, and its last words name it again.
    assert!(child.try_wait().unwrap().is_none(), "{after:?}");
    let rest: Vec<String> = lines.map_while(Result::ok).collect();
    assert_eq!(child.wait().unwrap().code(), Some(2), "{rest:?}");
    assert!(!rest.iter().any(|line| line.contains("the recording stopped")));
    assert!(rest.last().unwrap().contains("full.partial.mcap"), "{rest:?}");
}

fn the_calibration_in_use_is_recorded(bundle: &Bundle, source: &str, folder: &Path) {
    let (file, recording) = (folder.join("calibrated.hapdef"), folder.join("c.mcap"));
    let mut calibrated = bundle.clone();
    let json = "{\"scene\":\"shin\",\"n_presses\":7}";
    calibrated.calibration_json = Some(json.to_owned());
    std::fs::write(&file, calibrated.to_bytes().unwrap()).unwrap();
    let words = ["live", file.to_str().unwrap(), "--source", source];
    let played = hapdef(&[&words[..], &["--record", recording.to_str().unwrap()]].concat());
    assert!(played.status.success(), "{played:?}");
    let mut records = Recording::open(&recording).unwrap();
    let mut kept = Vec::new();
    while let Some(record) = records.next_record().unwrap() {
        if let Content::Calibration(json) = record.content {
            kept.push(String::from_utf8(json).unwrap());
        }
    }
    assert_eq!(kept, [json]);
}

/// What a chunk that is gone has taken is lost, and a file that is none is refused.
fn damage_is_told_and_counted(file: &str, recording: &str) {
    let mut bytes = std::fs::read(recording).unwrap();
    flip_amid_a_chunk(&mut bytes);
    std::fs::write(recording, bytes).unwrap();
    let source = format!("replay:{recording}@max");
    let played = hapdef(&["live", file, "--source", &source]);
    let said = String::from_utf8_lossy(&played.stderr).into_owned();
    assert!(played.status.success(), "{said}");
    assert!(said.contains("1 damaged stretches"), "{said}");
    let last = said.lines().find(|line| line.contains(" late, ")).unwrap();
    let count = |what: &str| {
        let words: Vec<&str> = last.split([' ', ',']).filter(|w| !w.is_empty()).collect();
        let at = words.iter().position(|word| *word == what).unwrap();
        words[at - 1].parse::<u32>().unwrap()
    };
    assert!(count("lost") > 0, "{last}");
    assert_eq!(count("frames") + count("lost"), 800, "{last}");

    std::fs::write(recording, "no recording at all").unwrap();
    refused(
        &["live", file, "--source", &source],
        &["bytes and not one readable chunk", "is it a recording"],
    );
}

/// The bundle is whole and of this version; the recording has as many channels.
fn the_doctor_looks_at_it(file: &str, recording: &str) {
    let source = format!("replay:{recording}@max");
    let seen = hapdef(&["doctor", "--json", "--source", &source, file]);
    let checks: Vec<Value> = serde_json::from_slice(&seen.stdout).unwrap();
    let check = |name: &str| checks.iter().find(|c| c["check"] == name).unwrap();
    for name in ["bundle", "version"] {
        assert_eq!(check(name)["state"], "ok", "{checks:?}");
    }
    assert_eq!(check("calibration")["state"], "warn");
    assert_eq!(check("gauges")["state"], "ok", "{checks:?}");
    let whole = std::fs::read(file).unwrap();
    let mut bytes = whole.clone();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    std::fs::write(file, bytes).unwrap();
    let seen = hapdef(&["doctor", "--json", file]);
    assert_eq!(seen.status.code(), Some(1));
    let checks: Vec<Value> = serde_json::from_slice(&seen.stdout).unwrap();
    let check = checks.iter().find(|c| c["check"] == "bundle").unwrap();
    assert_eq!(check["state"], "bad", "{check}");
    std::fs::write(file, whole).unwrap();
}

#[track_caller]
fn refused(words: &[&str], expected: &[&str]) {
    let output = hapdef(words);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    for word in expected {
        assert!(text.contains(word), "{word:?} is not in: {text}");
    }
}

#[test]
fn what_has_to_be_corrected_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let damaged = folder.path().join("shin.hapdef");
    std::fs::write(&damaged, [7; 100]).unwrap();
    let damaged = damaged.to_str().unwrap();
    let port = ["--source", "/dev/null"];
    refused(&["live", damaged, port[0], port[1]], &["not a whole bundle", "hapdef bundle"]);
    refused(&["live", "none.hapdef", port[0], port[1]], &["none.hapdef", "check the path"]);
    refused(&["live", damaged, "--source", "usb:1"], &["tcp:HOST:PORT", "usb:1"]);
}
