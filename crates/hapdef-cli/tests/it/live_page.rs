//! `hapdef live --view` as its page uses it: press, tare, record, keep, come back, play again.

use crate::support::page;

use std::path::{Path, PathBuf};

use hapdef_daq::Message;
use hapdef_daq::record::{Content, Recording};
use hapdef_ros::{from_cdr, msg};
use page::{Frame, Page, Program};
use serde_json::{Value, json};

const FORCE_N: f64 = 15.0;
/// A node in the middle of the skin.
const NODE: usize = 700;
/// How far a contact may be from where it is pressed, m.
const NEAR_M: f64 = 5e-3;

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn press(page: &mut Page) {
    let (point, normal) = page.node(NODE);
    page.say(&json!({"cmd": "press", "point_m": point, "normal": normal, "force_n": FORCE_N}));
}

fn is_touched_at(frame: &Frame, point: [f64; 3]) -> bool {
    matches!(frame.contacts[..], [(at, force_n)]
        if distance(at, point) < NEAR_M && (force_n - FORCE_N).abs() < 0.25 * FORCE_N)
}

#[test]
fn a_page_presses_records_keeps_and_plays_again() {
    let folder = tempfile::tempdir().unwrap();
    let scene = page::scene(folder.path());
    let out = folder.path().to_str().unwrap();
    let sim = ["--sim", "--tare-s", "0.5", "--view-out", out];
    let program = Program::start(&scene, &sim, 0);
    let mut page = program.page();
    assert_eq!(page.hello["offers"]["record"], true);
    assert_eq!(page.device["simulated"], true);
    let (point, _) = page.node(NODE);
    page.hear("Tared");
    press(&mut page);
    page.until("the press is found", |frame| is_touched_at(frame, point));
    page.say(&json!({"cmd": "release"}));
    page.until("it is let go", |frame| frame.contacts.is_empty());

    let recording = record(&mut page, point);
    what_is_recorded(&recording, point);
    page.say(&json!({"cmd": "tare"}));
    page.hear("Taring: touch nothing");
    page.hear("Tared");
    page.until("the clock's residual is shown", |frame| frame.clock_residual_us.is_finite());

    let port = program.port();
    drop((program, page));
    let program = Program::start(&scene, &sim, port);
    let mut page = program.page();
    page.until("frames come again", |_| true);
    drop((program, page));

    plays_again(&scene, &recording, point);
}

/// With the map of the skin, and without: the press is found where it was, and nothing beside it for a
/// second.
#[test]
fn contacts_alone_are_shown_without_a_deformation() {
    let found = |outputs: &str, n_components: u8| {
        let folder = tempfile::tempdir().unwrap();
        let scene = page::scene_with(folder.path(), |scene| scene["outputs"] = json!(outputs));
        let program = Program::start(&scene, &["--sim", "--tare-s", "0.5"], 0);
        let mut page = program.page();
        let (point, _) = page.node(NODE);
        page.hear("Tared");
        press(&mut page);
        let start = page.until("the press is found", |frame| is_touched_at(frame, point));
        let mut most_components = 0;
        page.until("it is found a second later, and shown as wanted", |frame| {
            most_components = most_components.max(frame.n_components);
            assert!(is_touched_at(frame, point), "{frame:?}");
            frame.t_s > start.t_s + 1.0 && most_components == n_components
        });
    };
    found("map", 3);
    found("contacts", 0);
}

#[test]
fn one_click_records_again_after_a_recording_that_failed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = page::scene(folder.path());
    let out = folder.path().to_str().unwrap();
    let sim = ["--sim", "--tare-s", "0.5", "--view-out", out];
    {
        // What is solved once is kept before the disk is small.
        let program = Program::start(&scene, &sim, 0);
        program.page().until("it is solved", |_| true);
    }
    let program = Program::start_on_small_disk(&scene, &sim, 64 << 10);
    let mut page = program.page();
    page.until("frames come", |_| true);
    for _ in 0..2 {
        page.say(&json!({"cmd": "record", "on": true}));
        page.until("it records", |frame| frame.recording == 1);
        page.until("it fails", |frame| frame.recording == 2);
    }
}

/// Records a second untouched and a second pressed, and keeps what is shown at the end.
fn record(page: &mut Page, point: [f64; 3]) -> PathBuf {
    page.say(&json!({"cmd": "record", "on": true}));
    page.until("a second is recorded", |frame| frame.recorded_s >= 1.0);
    press(page);
    page.until("the press is found", |frame| is_touched_at(frame, point));
    let frame = page.until("two more are recorded", |frame| frame.recorded_s >= 3.0);
    page.say(&json!({"cmd": "snapshot", "t_s": frame.t_s}));
    let kept = page.hear("Kept in ");
    let text = std::fs::read_to_string(kept.strip_prefix("Kept in ").unwrap()).unwrap();
    let kept: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(kept["t_s"], frame.t_s);
    assert_eq!(kept["simulated"], true);
    assert_eq!(kept["device_fault"], Value::Null);
    assert_eq!(kept["frame"]["contacts"].as_array().unwrap().len(), 1);
    let at = [0, 1, 2].map(|i| kept["frame"]["contacts"][0]["position_m"][i].as_f64().unwrap());
    assert!(distance(at, point) < NEAR_M, "{at:?} for {point:?}");
    page.say(&json!({"cmd": "record", "on": false}));
    let said = page.hear(" readings, ");
    page.until("nothing is recorded", |frame| frame.recording == 0);
    let path = PathBuf::from(said.split(": ").next().unwrap());
    assert_eq!(kept["recording"], path.to_str().unwrap());
    path
}

/// Readings, and for them without a gap what was found and what is true.
fn what_is_recorded(path: &Path, point: [f64; 3]) {
    let mut recording = Recording::open(path).unwrap();
    let (mut frames, mut found, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(record) = recording.next_record().unwrap() {
        let contacts = || from_cdr::<msg::Contacts>(&record.bytes).unwrap();
        match (&record.content, record.topic()) {
            (Content::Message(Message::Frame(frame)), _) => {
                frames.push((frame.seq, record.log_time_ns));
            }
            (_, "/hapdef/contacts") => found.push((record.log_time_ns, contacts())),
            (_, "/hapdef/truth") => truth.push((record.log_time_ns, contacts())),
            _ => {}
        }
    }
    assert!(recording.damage().is_finished);
    let n = frames.len();
    assert!(n >= 2000, "{n} readings");
    println!("{n} readings, {} found, {} true", found.len(), truth.len());
    for all in [&found, &truth] {
        let is_next = |pair: &[(u64, msg::Contacts)]| pair[1].1.seq == pair[0].1.seq + 1;
        assert!(all.windows(2).all(is_next), "a reading is left out");
    }
    let is_known =
        |(time_ns, contacts): &(u64, msg::Contacts)| frames.contains(&(contacts.seq, *time_ns));
    assert!(found.iter().all(is_known) && truth.iter().all(is_known));
    let place = |(_, contacts): &(u64, msg::Contacts)| {
        let at = &contacts.contacts.first()?.position;
        Some([at.x, at.y, at.z])
    };
    assert_eq!(place(&truth[0]), None);
    let last = place(&truth[truth.len() - 1]).unwrap();
    assert!(distance(last, point) < 1e-6, "{last:?} for {point:?}");
    let last = place(&found[found.len() - 1]).unwrap();
    assert!(distance(last, point) < NEAR_M, "{last:?} for {point:?}");
}

/// A replay tells where it is, goes where it is sent, stays while it is stopped and at its end.
fn plays_again(scene: &Path, recording: &Path, point: [f64; 3]) {
    let source = format!("replay:{}", recording.display());
    let program = Program::start(scene, &["--source", &source, "--tare-s", "0.5"], 0);
    let mut page = program.page();
    assert_eq!(page.hello["offers"]["record"], false);
    let frame = page.until("it plays", |frame| frame.position_s > 0.6);
    assert_eq!(page.device["simulated"], true);
    assert!(frame.duration_s > 2.5, "{} s", frame.duration_s);
    page.say(&json!({"cmd": "pause", "on": true}));
    for (position_s, is_touched) in [(2.5, true), (0.7, false), (2.0, true)] {
        page.say(&json!({"cmd": "seek", "position_s": position_s}));
        let what = format!("it is at {position_s} s, touched: {is_touched}");
        page.until(&what, |frame| {
            let is_there = (frame.position_s - position_s).abs() < 2e-3;
            let is_right = match is_touched {
                true => is_touched_at(frame, point),
                false => frame.contacts.is_empty(),
            };
            is_there && is_right
        });
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    let frame = page.until("it stays", |_| true);
    assert!((frame.position_s - 2.0).abs() < 2e-3, "{} s", frame.position_s);
    page.say(&json!({"cmd": "pause", "on": false}));
    let end_s = frame.duration_s;
    page.until("it plays to its end", |frame| frame.position_s > end_s - 1e-3);
    page.say(&json!({"cmd": "seek", "position_s": 1.0}));
    page.until("it goes back from there", |frame| frame.position_s < 1.5);
}
