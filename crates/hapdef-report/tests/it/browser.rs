//! A report's page in a headless Chromium: its limb is drawn, turns, zooms and has a length bar.
//!
//! Left out where there is no Chromium, as `hapdef-view/tests/browser.rs` says.

#[path = "../../../hapdef-view/tests/it/support/chrome.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod chrome;

use chrome::Chrome;
use hapdef_report::{Block, LimbMap, LimbView, Page};
use serde_json::Value;

/// The canvas that can be turned.
const CANVAS: &str = "document.querySelector('canvas.turn')";

/// A wedge of 20 × 100 × 30 mm, other on each side, with a gauge.
fn page() -> Page {
    let points_m = vec![[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.03]];
    let map = |title: &str, values: [f64; 4]| LimbMap {
        title: title.to_owned(),
        unit: "mm".to_owned(),
        factor: 1e3,
        values: values.to_vec(),
        range: [0.0, 0.004],
    };
    Page {
        title: "A limb".to_owned(),
        blocks: vec![Block::Limb(LimbView {
            points_m,
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
            maps: vec![
                map("one", [0.001, 0.0025, 0.004, 0.0]),
                map("other", [0.004, 0.0, 0.001, 0.002]),
            ],
            marks_m: vec![[0.0, 0.05, 0.0]],
        })],
        ..Page::default()
    }
}

/// A browser with the page, or `None` where there is no browser.
fn look() -> Option<Chrome> {
    let browser = chrome::wanted()?;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.html");
    page().write(&file).unwrap();
    let mut chrome = Chrome::start(&browser, (1000, 900), false).unwrap();
    chrome.open(&format!("file://{}", file.display())).unwrap();
    let loaded = format!("document.readyState === 'complete' && {CANVAS} !== null");
    chrome.wait_for(&loaded).unwrap();
    Some(chrome)
}

/// Everything that a canvas shows, as text.
fn shown(chrome: &mut Chrome, canvas: &str) -> Value {
    chrome.eval(&format!("{canvas}.toDataURL()")).unwrap()
}

/// Colours on a canvas between its upper and its lower end, as shares of its height.
fn n_colours(chrome: &mut Chrome, canvas: &str, upper: f64, lower: f64) -> u64 {
    let script = format!(
        "(() => {{ const c = {canvas}, top = Math.floor({upper} * c.height), rows = Math.floor({lower} * c.height) - top; \
         const d = new Uint32Array(c.getContext('2d').getImageData(0, top, c.width, rows).data.buffer); \
         return new Set(d).size; }})()"
    );
    chrome.eval(&script).unwrap().as_u64().unwrap()
}

#[track_caller]
fn changes(chrome: &mut Chrome, what: &str, act: impl FnOnce(&mut Chrome)) {
    let before = shown(chrome, CANVAS);
    act(chrome);
    assert_ne!(before, shown(chrome, CANVAS), "{what} changes nothing");
}

#[test]
fn a_limb_on_a_page_is_drawn_and_turned() {
    let Some(mut chrome) = look() else {
        return;
    };
    let n = chrome.eval("document.querySelectorAll('canvas').length");
    assert_eq!(n.unwrap(), 2 * 4 + 1);
    for i in 0..9 {
        let canvas = format!("document.querySelectorAll('canvas')[{i}]");
        let [limb, ruler] =
            [(0.1, 0.8), (0.92, 1.0)].map(|(a, b)| n_colours(&mut chrome, &canvas, a, b));
        assert!(limb >= 3, "canvas {i} has {limb} colours where the limb is");
        assert!(ruler >= 2, "canvas {i} has no length bar");
    }
    chrome.eval(&format!("{CANVAS}.focus()")).unwrap();
    for key in ["ArrowLeft", "ArrowUp", "+"] {
        changes(&mut chrome, key, |chrome| chrome.key(key, "").unwrap());
    }
    let choose = "(() => { const s = document.querySelector('select'); s.value = '1'; \
                  s.dispatchEvent(new Event('change')); })()";
    changes(&mut chrome, "another field", |chrome| {
        chrome.eval(choose).unwrap();
    });
    changes(&mut chrome, "dragging", |chrome| {
        let middle = format!(
            "(() => {{ {CANVAS}.scrollIntoView({{block: 'center'}}); const b = {CANVAS}.getBoundingClientRect(); \
             return [b.x + b.width / 2, b.y + b.height / 2]; }})()"
        );
        let (x, y): (f64, f64) = serde_json::from_value(chrome.eval(&middle).unwrap()).unwrap();
        chrome.pointer("mousePressed", (x, y)).unwrap();
        chrome.pointer("mouseMoved", (x + 40.0, y)).unwrap();
        chrome.pointer("mouseReleased", (x + 40.0, y)).unwrap();
    });
    assert_eq!(chrome.complaints().unwrap(), Vec::<String>::new());
}

/// 0.6 − 0.13 + 0.13 may differ from 0.6 in the last digit only, which no pixel shows.
#[test]
fn left_undoes_right() {
    let Some(mut chrome) = look() else {
        return;
    };
    chrome.eval(&format!("{CANVAS}.focus()")).unwrap();
    let before = shown(&mut chrome, CANVAS);
    chrome.key("ArrowRight", "ArrowRight").unwrap();
    assert_ne!(before, shown(&mut chrome, CANVAS));
    chrome.key("ArrowLeft", "ArrowLeft").unwrap();
    assert_eq!(before, shown(&mut chrome, CANVAS));
    assert_eq!(chrome.complaints().unwrap(), Vec::<String>::new());
}
