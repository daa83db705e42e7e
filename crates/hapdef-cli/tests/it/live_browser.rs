//! The live page in a headless Chromium, with the program behind it and the bundled limb's simulated rig.
//!
//! Left out where there is no Chromium, as `hapdef-view/tests/browser.rs` says.

#[path = "../../../hapdef-view/tests/it/support/chrome.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod chrome;
use crate::support::page;
#[path = "../../../hapdef-view/tests/it/support/pixels.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod pixels;

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use chrome::Chrome;
use hapdef_daq::record::{Content, Recording};
use hapdef_mesh::{GltfParams, read_gltf};
use page::Program;
use pixels::{LimbRow, Pixels};
use serde_json::json;
use tempfile::TempDir;

/// How far an arrow may be from the node that is pressed, m.
const NEAR_M: f64 = 5e-3;
/// Time that a page hangs for, s, and with HAPDEF_SOAK=1.
const HANGS_S: [f64; 2] = [5.0, 60.0];
/// Part of the frames that may be dropped meanwhile: the tests beside it draw pages on the same cores.
const MOST_DROPPED: f64 = 0.01;

/// Keeps all that the page says from then on.
const LISTEN: &str = "globalThis.said = [];
    new MutationObserver(() => said.push(document.getElementById('say').textContent))
        .observe(document.getElementById('say'), { childList: true, characterData: true, subtree: true })";

/// One browser at a time.
static ONE: Mutex<()> = Mutex::new(());

/// The program, and a browser that shows its page.
struct Look {
    chrome: Chrome,
    program: Program,
    scene: PathBuf,
    folder: TempDir,
    /// How much of what the page says was heard.
    n_heard: u64,
    _one: MutexGuard<'static, ()>,
}

/// The page with readings, or `None` where there is no browser.
fn look(size: (u32, u32)) -> Option<Look> {
    look_at(page::scene, size)
}

/// The page of a scene that is written to a folder.
fn look_at(scene: impl FnOnce(&Path) -> PathBuf, size: (u32, u32)) -> Option<Look> {
    let browser = chrome::wanted()?;
    let one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let program = start(&scene, folder.path(), 0);
    program.page().until("frames come", |_| true);
    // In light colours, from which the limb differs whatever its own.
    let mut chrome = Chrome::start(&browser, size, false).unwrap();
    chrome.open(&program.url).unwrap();
    chrome.wait_for("globalThis.hapdefView?.drawn > 1").unwrap();
    chrome.eval(LISTEN).unwrap();
    Some(Look { chrome, program, scene, folder, n_heard: 0, _one: one })
}

fn start(scene: &Path, out: &Path, port: u16) -> Program {
    let out = out.to_str().unwrap();
    let words = ["--sim", "--tare-s", "0.5", "--view-out", out];
    Program::start(scene, &words, port)
}

impl Look {
    fn click(&mut self, button: &str) {
        let click = format!("document.getElementById('{button}').click()");
        self.chrome.eval(&click).unwrap();
    }

    /// Waits until the page says something that has `words` in it, after what was heard before; what it
    /// says.
    fn hears(&mut self, words: &str) -> String {
        let (n, words) = (self.n_heard, json!(words));
        let at = format!("said.findIndex((text, i) => i >= {n} && text.includes({words}))");
        self.chrome.wait_for(&format!("{at} >= 0")).unwrap();
        let at = self.chrome.eval(&at).unwrap().as_u64().unwrap();
        self.n_heard = at + 1;
        let said = self.chrome.eval(&format!("said[{at}]")).unwrap();
        said.as_str().unwrap().to_owned()
    }

    /// Tares, and waits until that tare is over.
    fn tares(&mut self) {
        self.click("tare");
        self.hears("Taring: touch nothing");
        self.hears("Tared");
    }

    /// Presses the limb at a node until something else is done with the pointer; where that is.
    fn press(&mut self, node: u64) -> (f64, f64) {
        let at = self.chrome.eval(&format!("hapdefView.project({node})"));
        let at: (f64, f64) = serde_json::from_value(at.unwrap()).unwrap();
        self.chrome.pointer("mouseMoved", at).unwrap();
        self.chrome.pointer("mousePressed", at).unwrap();
        at
    }

    /// Waits for a picture with one arrow alone, near a node, and its ellipse: how sure it is of the place.
    fn is_found_at(&mut self, node: u64) {
        let off = format!(
            "Math.hypot(...hapdefView.arrows[0].map((c, k) => c - hapdefView.node({node})[k]))"
        );
        let is_near = format!(
            "hapdefView.arrows.length === 1 && hapdefView.ellipses === 1 && {off} < {NEAR_M}"
        );
        self.chrome.wait_for(&is_near).unwrap();
    }

    fn node_in_the_middle(&mut self) -> u64 {
        let node = self.chrome.eval("hapdefView.facing()").unwrap();
        node.as_u64().expect("a node in the middle of the view")
    }
}

#[test]
fn a_click_presses_the_limb_and_is_found_there() {
    let Some(mut look) = look((1200, 800)) else {
        return;
    };
    look.tares();
    let node = look.node_in_the_middle();
    let below = LimbRow::of_node(&mut look.chrome, node, 40.0).unwrap();
    Pixels::of_stage(&mut look.chrome).unwrap().shows_limb_across(&below);
    let at = look.press(node);
    look.is_found_at(node);
    // Numbers follow the picture by up to a tenth of a second.
    let shown_right = "(() => {
        const listed = [...document.querySelectorAll('#contacts b')].map((row) => parseFloat(row.textContent));
        const force_n = Number(document.getElementById('force').value);
        return listed.length === 1 && Math.abs(listed[0] - force_n) < 0.25 * force_n; })()";
    look.chrome.wait_for(shown_right).unwrap();
    // The true place is that of the same sample: what is said to be off is what is.
    let off_m = "Math.hypot(...hapdefView.contacts[0].map((c, k) => c - hapdefView.truths[0][k]))";
    let is_right =
        format!("hapdefView.truths.length === 1 && Math.abs(hapdefView.offs[0] - {off_m}) < 1e-9");
    look.chrome.wait_for(&is_right).unwrap();
    look.chrome.pointer("mouseReleased", at).unwrap();
    look.chrome.wait_for("hapdefView.arrows.length === 0").unwrap();

    look.click("record");
    look.hears("Recording to ");
    let recorded_s = "(() => {
        const [, minutes, seconds] = document.getElementById('health').textContent.match(/Recording(\\d+):(\\d+)/) ?? [];
        return 60 * Number(minutes) + Number(seconds); })()";
    look.chrome.wait_for(&format!("{recorded_s} >= 2")).unwrap();
    look.click("record");
    let said = look.hears(" readings, ");
    let path = said.split(": ").next().unwrap();
    assert!(Path::new(path).starts_with(look.folder.path()), "{said}");
    let n = n_readings(Path::new(path));
    assert!(n >= 2000, "{n} readings");
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}

fn n_readings(path: &Path) -> usize {
    let mut recording = Recording::open(path).unwrap();
    let mut n = 0;
    while let Some(record) = recording.next_record().unwrap() {
        let is_reading = matches!(record.content, Content::Message(hapdef_daq::Message::Frame(_)));
        n += usize::from(is_reading);
    }
    n
}

#[test]
fn a_page_that_hangs_and_one_that_never_reads_cost_the_acquisition_nothing() {
    let Some(mut look) = look((900, 700)) else {
        return;
    };
    let mut other = look.program.page();
    other.until("its rate is shown", |frame| frame.rate_hz > 0.0);
    let _never_reads = look.program.page();
    let drawn = look.chrome.eval("hapdefView.drawn").unwrap();
    look.chrome.halt().unwrap();
    let first = other.until("a frame", |_| true);
    let hangs_s = HANGS_S[usize::from(std::env::var_os("HAPDEF_SOAK").is_some())];
    let until_s = first.t_s + hangs_s;
    let last = other.until("it hung long enough", |frame| frame.t_s >= until_s);
    println!("{first:?}, {last:?}");
    assert_eq!(last.n_lost, first.n_lost);
    let dropped = f64::from(last.n_dropped - first.n_dropped) / (1000.0 * (last.t_s - first.t_s));
    assert!(dropped <= MOST_DROPPED, "{dropped} of the frames dropped");
    look.chrome.go_on().unwrap();
    look.chrome.wait_for(&format!("hapdefView.drawn > {drawn} + 2")).unwrap();
}

#[test]
fn the_page_comes_back_with_its_program_and_presses_again() {
    let Some(mut look) = look((1200, 800)) else {
        return;
    };
    let port = look.program.port();
    let away = "document.getElementById('link').dataset.state === 'away'";
    drop(look.program);
    look.chrome.wait_for(away).unwrap();
    let drawn = look.chrome.eval("hapdefView.drawn").unwrap();
    look.program = start(&look.scene, look.folder.path(), port);
    look.program.page().until("frames come", |_| true);
    look.chrome.wait_for(&format!("hapdefView.drawn > {drawn} + 2")).unwrap();
    look.tares();
    let node = look.node_in_the_middle();
    look.press(node);
    look.is_found_at(node);
}

#[test]
fn the_gltf_that_the_scene_names_is_drawn_in_colours_and_pressed() {
    let Some(mut look) = look_at(page::scene_with_gltf, (900, 700)) else {
        return;
    };
    let skin = read_gltf(&page::shin().join("shin_skin.glb"), &GltfParams::default()).unwrap();
    let n_vertices = skin.mesh.vertices().len();
    assert_eq!(look.chrome.eval("hapdefView.nodes").unwrap(), n_vertices);
    look.tares();
    let node = look.node_in_the_middle();
    look.press(node);
    look.is_found_at(node);
    look.chrome.wait_for("hapdefView.coloured > 0").unwrap();
    let bend = "const e = document.getElementById('exaggerate'); e.value = 1; e.oninput()";
    look.chrome.eval(bend).unwrap();
    let moved =
        format!("hapdefView.drawnNode({node}).some((x, k) => x !== hapdefView.node({node})[k])");
    look.chrome.wait_for(&moved).unwrap();
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}

#[test]
fn a_phone_shows_all_of_it() {
    let Some(mut look) = look((390, 844)) else {
        return;
    };
    let wide = look.chrome.eval("document.documentElement.scrollWidth").unwrap();
    assert_eq!(wide, 390);
    assert_eq!(look.chrome.outside(390).unwrap(), json!([]));
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}
