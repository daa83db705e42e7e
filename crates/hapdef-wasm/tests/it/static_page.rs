//! The folder that `cargo xtask wasm` made, in a headless Chromium: the module's results beside the native ones, its
//! speed, and the page. `HAPDEF_PAGE` names the folder; without it these are left out.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hapdef_report::{MetricContext, MetricLog};
use hapdef_wasm::{PageMessage, PageModel, Session};
use serde_json::{Value, json};

use crate::support::chrome::{self, Chrome, Fault};
use crate::support::{files, told};

/// Loads the module and the model; `said()` is all that the page is told, in base64.
const LOAD: &str = include_str!("static_page/load.js");
/// Frames whose times are taken.
const N_TIMED: usize = 2000;
/// Presses of the script, N.
const FORCES_N: [f64; 3] = [10.0, 6.0, 18.0];
/// How far native results and those in the browser may be apart: m, and as a share of a force and of a reading.
const APART: f64 = 1e-6;

/// One browser at a time.
static ONE: Mutex<()> = Mutex::new(());

/// The folder and a browser, where both are there.
fn prepared() -> Option<(PathBuf, PathBuf)> {
    let Some(folder) = std::env::var_os("HAPDEF_PAGE") else {
        println!("SKIPPED: no HAPDEF_PAGE; `cargo xtask wasm` makes the page");
        return None;
    };
    Some((folder.into(), chrome::wanted()?))
}

/// Words of the page, and how many frames go by after them.
fn script(model: &PageModel) -> Vec<(Value, usize)> {
    let skin = model.bundle().skin();
    let press = |finger: usize| {
        let node = (finger + 1) * skin.n_nodes() / 4;
        let point_m: [f64; 3] = skin.nodes()[node].coords.into();
        let normal: [f64; 3] = skin.normals()[node].into();
        json!({"cmd": "press", "finger": finger, "point_m": point_m, "normal": normal, "force_n": FORCES_N[finger]})
    };
    vec![
        (json!({"cmd": "random", "on": false}), 1200),
        (press(0), 800),
        (press(1), 800),
        (json!({"cmd": "lift", "finger": 0}), 800),
        (press(2), 800),
        (json!({"cmd": "release"}), 800),
        (json!({"cmd": "random", "on": true}), 4000),
        (json!({"cmd": "tare"}), 2000),
    ]
}

/// Frames from a picture to the next.
const STRIDE: usize = 16;

fn native(model: &PageModel) -> Vec<PageMessage> {
    let mut session = Session::new(model).unwrap();
    let mut said = Vec::new();
    for (words, n_frames) in script(model) {
        session.hear(&words.to_string());
        for _ in 0..n_frames / STRIDE {
            session.step(STRIDE as u32);
            said.extend(told::all(&mut session));
        }
    }
    said
}

/// The same in the browser.
fn in_browser(chrome: &mut Chrome, model: &PageModel) -> Result<Vec<PageMessage>, Fault> {
    for (words, n_frames) in script(model) {
        chrome.eval(&format!("program.play({words}, {}, {STRIDE})", n_frames / STRIDE))?;
    }
    let said = chrome.eval("program.said()")?;
    let message = |said: &Value| -> Result<PageMessage, Fault> {
        let bytes = STANDARD.decode(said[1].as_str().ok_or("no bytes")?)?;
        Ok(match said[0].as_u64() {
            Some(1) => PageMessage::Text(String::from_utf8(bytes)?),
            _ => PageMessage::Bytes(bytes),
        })
    };
    said.as_array().ok_or("nothing was said")?.iter().map(message).collect()
}

/// The largest difference of two frames' contacts, truths and readings: m, and shares of a force and a reading.
#[track_caller]
fn apart(expected: &told::Frame, found: &told::Frame) -> f64 {
    let counts = |frame: &told::Frame| {
        let numbers =
            |marks: &[told::Mark]| marks.iter().map(|mark| mark.number).collect::<Vec<_>>();
        (frame.flags, numbers(&frame.contacts), frame.n_others, numbers(&frame.truths))
    };
    assert_eq!(counts(expected), counts(found), "at {} s", expected.t_s);
    let share = |a: f64, b: f64| (a - b).abs() / a.abs().max(1.0);
    let marks = expected.contacts.iter().zip(&found.contacts);
    let marks = marks.chain(expected.truths.iter().zip(&found.truths)).map(|(a, b)| {
        let off_m = (a.at - b.at).norm();
        off_m.max((a.force_n - b.force_n).norm() / a.force_n.norm().max(1.0))
    });
    let readings = expected.readings_ue.iter().zip(&found.readings_ue).map(|(a, b)| share(*a, *b));
    marks.chain(readings).fold(0.0, f64::max)
}

#[test]
fn the_browser_finds_what_the_program_finds() {
    let Some((folder, program)) = prepared() else { return };
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let model = PageModel::from_bytes(&std::fs::read(folder.join("limb.model")).unwrap()).unwrap();
    let expected = native(&model);
    let port = files::serve(&folder);
    let mut chrome = Chrome::start(&program, (800, 600), false).unwrap();
    chrome.open(&format!("http://127.0.0.1:{port}/vendor/three/LICENSE")).unwrap();
    chrome
        .wait_for("location.pathname.endsWith('LICENSE') && document.readyState === 'complete'")
        .unwrap();
    assert_eq!(chrome.eval(LOAD).unwrap(), json!("open"));
    let found = in_browser(&mut chrome, &model).unwrap();
    assert_eq!(expected.len(), found.len());
    let (mut worst, mut n_contacts) = (0.0_f64, 0);
    for (a, b) in expected.iter().zip(&found) {
        match (told::frame(a), told::frame(b)) {
            (Some(a), Some(b)) => {
                worst = worst.max(apart(&a, &b));
                n_contacts += a.contacts.len();
            }
            _ => assert!(a == b, "{a:?} but {b:?}"),
        }
    }
    println!("{} messages with {n_contacts} contacts, at most {worst:.1e} apart", found.len());
    assert!(n_contacts > 100, "{n_contacts}");
    assert!(worst <= APART, "{worst}");
    tell_speed(&mut chrome).unwrap();
}

/// Prints how long frames take while somebody presses.
fn tell_speed(chrome: &mut Chrome) -> Result<(), Fault> {
    let times = chrome.eval(&format!("program.times({N_TIMED})"))?;
    let times = times.as_array().ok_or("no times")?;
    let mut times_us: Vec<f64> = times.iter().filter_map(Value::as_f64).collect();
    times_us.sort_by(f64::total_cmp);
    let at = |share: f64| times_us[((times_us.len() - 1) as f64 * share) as usize];
    let mut log = MetricLog::new(std::io::stdout(), MetricContext::here(1));
    log.value("wasm.frame_p50_us", at(0.5).round(), "us")?;
    log.value("wasm.frame_p99_us", at(0.99).round(), "us")?;
    if let Some(file) = std::env::var_os("HAPDEF_METRICS") {
        log.append_to(file.as_ref())?;
    }
    Ok(())
}

#[test]
fn the_page_is_pressed_without_a_server_of_ours() {
    let Some((folder, program)) = prepared() else { return };
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let port = files::serve(&folder);
    let mut chrome = Chrome::start(&program, (1200, 800), true).unwrap();
    chrome.open(&format!("http://127.0.0.1:{port}/")).unwrap();
    chrome.wait_for("document.querySelector('#link')?.dataset.state === 'live'").unwrap();
    assert_eq!(chrome.eval("document.querySelector('#record').hidden").unwrap(), json!(true));
    assert_eq!(chrome.eval("document.querySelector('#simulated').hidden").unwrap(), json!(false));
    chrome.key("a", "KeyA").unwrap();
    chrome.wait_for("document.querySelector('#random').ariaPressed === 'false'").unwrap();
    chrome.wait_for("hapdefView.t > 2").unwrap();
    let at = chrome.eval("hapdefView.project(hapdefView.facing())").unwrap();
    let at = (at[0].as_f64().unwrap(), at[1].as_f64().unwrap());
    chrome.pointer("mousePressed", at).unwrap();
    chrome.wait_for("hapdefView.contacts.length === 1 && hapdefView.truths.length === 1").unwrap();
    chrome.wait_for("hapdefView.offs[0] !== null && hapdefView.offs[0] < 0.005").unwrap();
    if let Some(picture) = std::env::var_os("HAPDEF_PAGE_PICTURE") {
        std::fs::write(picture, chrome.screenshot().unwrap()).unwrap();
    }
    chrome.pointer("mouseReleased", at).unwrap();
    chrome.wait_for("hapdefView.contacts.length === 0").unwrap();
    assert_eq!(chrome.complaints().unwrap(), Vec::<String>::new());
}

#[test]
fn a_page_without_its_model_says_so() {
    let Some((folder, program)) = prepared() else { return };
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let other = tempfile::tempdir().unwrap();
    copy_without(&folder, other.path(), "limb.model");
    let port = files::serve(other.path());
    let mut chrome = Chrome::start(&program, (1200, 800), true).unwrap();
    chrome.open(&format!("http://127.0.0.1:{port}/")).unwrap();
    chrome.wait_for("document.querySelector('#link')?.dataset.state === 'failed'").unwrap();
    let why = chrome.eval("document.querySelector('#device').title").unwrap();
    assert!(why.as_str().unwrap().contains("limb.model: 404"), "{why}");
}

fn copy_without(from: &std::path::Path, to: &std::path::Path, left_out: &str) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_dir() {
            copy_without(&path, &to.join(name), left_out);
        } else if name != left_out {
            std::fs::copy(&path, to.join(name)).unwrap();
        }
    }
}
