//! What the page says to those who read it, in a headless Chromium: where readings come from, texts that stay in
//! place, keys that are left to the browser, names of files, all of it on a phone; how a limb is bent and coloured,
//! and what goes with it.
//!
//! Left out where there is no Chromium, as `browser.rs` says.

use crate::support::look;
use crate::support::synthetic;

use hapdef_view::{DeviceState, Displacement, ViewFrame};
use look::look;
use serde_json::json;
use synthetic::{Touch, on_limb};

/// Presses of an arrow key that turn the limb by half a turn.
const N_HALF_TURN: usize = 24;

/// Five newtons, at a rate that changes with every frame.
fn touched(n: u32) -> ViewFrame {
    let (point_m, normal) = on_limb(-0.6, 0.2);
    let touch = Touch { id: 0, point_m, normal, force_n: 5.0 };
    let mut frame = ViewFrame::default();
    let t_s = 0.01 * f64::from(n);
    synthetic::show(&synthetic::picture(), &[touch], t_s, &mut frame);
    frame.health.rate_hz = 900.0 + f64::from(n % 100);
    frame
}

/// The tags that are seen, and whether the limb is dimmed.
const TAGS: &str = "[[...document.querySelectorAll('.tag')].filter((tag) => tag.checkVisibility())
    .map((tag) => tag.textContent), document.getElementById('stage').classList.contains('old')]";

#[test]
fn a_device_that_is_away_is_seen_on_a_page_that_is_opened_later_too() {
    let Some(mut look) = look((1200, 800), true, "", touched) else {
        return;
    };
    look.is(TAGS, &json!([["live"], false]));
    let away = DeviceState { is_simulated: true, fault: Some("/dev/limb is unplugged".to_owned()) };
    look.view.view.set_device(&away);
    let tags = json!([["simulated", "device away", "live"], true]);
    look.until(&format!("JSON.stringify({TAGS}) === JSON.stringify({tags})"));
    let url = look.view.view.url().to_owned();
    look.chrome.open("about:blank").unwrap();
    look.chrome.open(&url).unwrap();
    look.until("globalThis.hapdefView?.drawn > 1");
    look.is(TAGS, &tags);
    look.is("document.getElementById('device').title", &json!("/dev/limb is unplugged"));
    look.view.view.set_device(&DeviceState::default());
    let tags = json!([["live"], false]);
    look.until(&format!("JSON.stringify({TAGS}) === JSON.stringify({tags})"));
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}

#[test]
fn texts_change_in_place() {
    let Some(mut look) = look((1200, 800), true, "", touched) else {
        return;
    };
    look.until("document.querySelector('#contacts b')?.textContent === '5.0 N'");
    look.do_it(
        "globalThis.texts = [...document.querySelectorAll(
            '#contacts b, #contacts span, #health dt, #health dd, #gauges .value, #time-out')]
            .map((part) => part.firstChild).filter(Boolean);
        globalThis.rate = document.querySelector('#health dd').textContent;
        getSelection().selectAllChildren(document.querySelector('#contacts b'))",
    );
    look.until("document.querySelector('#health dd').textContent !== rate");
    look.is("texts.length > 20", &json!(true));
    look.is("texts.every((text) => text.isConnected)", &json!(true));
    look.is("getSelection().toString()", &json!("5.0 N"));
}

#[test]
fn a_page_that_is_scrolled_keeps_its_keys() {
    let sizes = [((390, 844), [false, false]), ((1200, 800), [true, true])];
    for (size, of_page) in sizes {
        let Some(mut look) = look(size, true, "", touched) else {
            return;
        };
        look.do_it("addEventListener('keydown', (event) => { globalThis.taken = event.defaultPrevented; })");
        let keys = [("ArrowDown", "ArrowDown"), (" ", "Space")];
        for ((key, code), expected) in keys.into_iter().zip(of_page) {
            look.do_it("document.activeElement.blur()");
            look.chrome.key(key, code).unwrap();
            look.is("taken", &json!(expected));
            look.do_it("document.getElementById('limb').focus()");
            look.chrome.key(key, code).unwrap();
            look.is("taken", &json!(true));
        }
    }
}

#[test]
fn a_picture_is_named_after_the_scene() {
    const KEEPS_NAMES: &str = "HTMLAnchorElement.prototype.click = function () {
        globalThis.saved = this.download; };";
    let Some(mut look) = look((900, 700), true, KEEPS_NAMES, touched) else {
        return;
    };
    look.do_it("document.getElementById('snapshot').click()");
    look.until("globalThis.saved === 'Made-up-shin-snapshot.png'");
}

#[test]
fn a_phone_shows_all_of_it() {
    let Some(mut look) = look((390, 844), true, "", touched) else {
        return;
    };
    look.until("document.querySelector('#contacts b') !== null");
    look.is("document.documentElement.scrollWidth", &json!(390));
    assert_eq!(look.chrome.outside(390).unwrap(), json!([]));
    for id in ["limb", "tare", "contacts", "force-plot", "gauges", "health"] {
        let seen = format!("document.getElementById('{id}').getBoundingClientRect().height > 20");
        look.is(&seen, &json!(true));
    }
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}

/// Five of them.
fn crowded(n: u32) -> ViewFrame {
    let mut frame = touched(n);
    for id in 1..5 {
        let mut further = frame.contacts[0];
        further.contact.id = Some(id);
        frame.contacts.push(further);
    }
    frame
}

#[test]
fn a_long_list_of_contacts_leaves_the_plots_alone() {
    let Some(mut look) = look((1280, 600), true, "", crowded) else {
        return;
    };
    look.until("document.querySelectorAll('#contacts li').length === 5");
    look.is(
        "document.getElementById('contacts').getBoundingClientRect().bottom <=
            document.getElementById('force-plot').closest('section').getBoundingClientRect().top",
        &json!(true),
    );
}

/// The first half of the limb's nodes is its skin.
fn with_half_a_skin(n: u32) -> ViewFrame {
    let mut frame = touched(n);
    if let Displacement::Vector(moved) = &mut frame.displacement {
        moved.truncate(moved.len() / 2);
    }
    frame
}

#[test]
fn what_is_beyond_the_skin_bends_with_it() {
    let Some(mut look) = look((900, 700), true, "", with_half_a_skin) else {
        return;
    };
    look.until("hapdefView.coloured > 0");
    look.do_it("const e = document.getElementById('exaggerate'); e.value = 1; e.oninput()");
    let shift = "globalThis.shift = (i) => hapdefView.drawnNode(i).map((x, k) => x - hapdefView.node(i)[k])";
    look.do_it(shift);
    let [farthest, torn] = [
        "Math.max(...Array.from({ length: hapdefView.nodes }, (_, i) => Math.hypot(...shift(i))))",
        "(() => {
            const n = hapdefView.nodes, k = Math.floor(n / 2);
            const rest = Array.from({ length: n }, (_, i) => hapdefView.node(i));
            const gap = (a, b) => Math.hypot(...a.map((x, c) => x - b[c]));
            const shifts = Array.from({ length: n }, (_, i) => shift(i));
            let worst = 0;
            for (let i = k; i < n; i += 1) {
                const gaps = rest.slice(0, k).map((x) => gap(x, rest[i]));
                const least = Math.min(...gaps) + 1e-6;
                const beside = shifts.slice(0, k).filter((_, j) => gaps[j] <= least);
                worst = Math.max(worst, Math.min(...beside.map((s) => gap(s, shifts[i]))));
            }
            return worst;
        })()",
    ];
    look.until(&format!("{farthest} > 0.01"));
    assert!(look.number(torn) < 1e-5);
}

#[test]
fn exaggeration_bends_the_limb_and_a_map_colours_it() {
    let Some(mut look) = look((1200, 800), true, "", touched) else {
        return;
    };
    look.until("hapdefView.coloured > 0");
    let farthest = "Math.max(...Array.from({ length: hapdefView.nodes }, (_, i) => {
        const [a, b] = [hapdefView.node(i), hapdefView.drawnNode(i)];
        return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }))";
    assert_eq!(look.number(farthest), 0.0);
    look.do_it("const e = document.getElementById('exaggerate'); e.value = 1 / 3; e.oninput()");
    // 18 µm a newton, five newtons, ten times.
    look.until(&format!("Math.abs({farthest} - 0.0009) < 0.00005"));
    let shown = "document.getElementById('exaggerate').ariaValueText";
    look.is(shown, &json!("×10"));
    look.do_it("e.value = 1; e.oninput()");
    // A thousand times that is more than there is room for: three tenths of the limb's radius.
    look.do_it(
        "globalThis.box = new Array(3).fill(0).map((_, k) => {
            const all = Array.from({ length: hapdefView.nodes }, (_, i) => hapdefView.node(i)[k]);
            return (Math.min(...all) + Math.max(...all)) / 2;
        });
        globalThis.radius = Math.max(...Array.from({ length: hapdefView.nodes }, (_, i) =>
            Math.hypot(...hapdefView.node(i).map((x, k) => x - box[k]))))",
    );
    look.until(&format!("Math.abs({farthest} / radius - 0.3) < 0.02"));
    look.until(&format!("/^×[0-9]+ at most$/.test({shown})"));
    let outside = "Array.from({ length: hapdefView.nodes }, (_, i) => hapdefView.drawnNode(i))
        .filter((p) => hapdefView.pickable(p) === false).length";
    look.is(outside, &json!(0));
    look.do_it("e.value = 0; e.oninput()");
    look.until(&format!("{farthest} === 0"));
    let bar = "[...document.getElementById('bar').getContext('2d').getImageData(0, 0, 1, 1).data]";
    look.is(bar, &json!([68, 1, 84, 255]));
    let viridis = look.picture_at(0.5, 0.5);
    look.do_it("const c = document.getElementById('colours'); c.value = 'cividis'; c.onchange()");
    look.is(bar, &json!([0, 34, 78, 255]));
    let drawn = look.number("hapdefView.drawn");
    look.until(&format!("hapdefView.drawn > {drawn} + 1"));
    let cividis = look.picture_at(0.5, 0.5);
    assert_ne!(viridis, cividis);
    look.is("[...document.querySelectorAll('#ticks span')].at(-1).textContent", &json!("100 µm"));
}

#[test]
fn marks_go_with_the_bent_skin() {
    let Some(mut look) = look((900, 700), true, "", touched) else {
        return;
    };
    look.until("hapdefView.coloured > 0 && hapdefView.ghosts > 1");
    look.do_it("globalThis.rest = hapdefView.marksDrawn");
    // An arrow, its ellipse, a ghost and ten gauges.
    look.is("rest.length", &json!(13));
    look.do_it("const e = document.getElementById('exaggerate'); e.value = 2 / 3; e.oninput()");
    let moved = "hapdefView.marksDrawn.map((at, i) => at.map((x, k) => x - rest[i][k]))";
    let lengths = format!("{moved}.map((by) => Math.hypot(...by))");
    // 18 µm a newton, five newtons, a hundred times: as deep as the dent.
    for i in 0..3 {
        look.until(&format!("Math.abs({lengths}[{i}] - 0.009) < 0.0003"));
    }
    look.is(&format!("{lengths}.slice(3).some((length) => length > 0.001)"), &json!(true));
    let off = format!(
        "{moved}.map((by, m) => {{
            const gap = (a, b) => Math.hypot(...a.map((x, k) => x - b[k]));
            const gaps = Array.from({{ length: hapdefView.nodes }}, (_, i) => gap(rest[m], hapdefView.node(i)));
            const i = gaps.indexOf(Math.min(...gaps));
            return gap(by, hapdefView.drawnNode(i).map((x, k) => x - hapdefView.node(i)[k]));
        }})"
    );
    let worst_m = look.number(&format!("Math.max(...{off})"));
    assert!(worst_m < 0.0015, "{worst_m} m from the skin");
    look.do_it("e.value = 0; e.oninput()");
    look.until(&format!("Math.max(...{lengths}) < 1e-7"));
}

/// Share of one part of the page that another covers.
const COVERED: &str = "globalThis.covered = (part, by) => {
    const [a, b] = [part, by].map((id) => document.getElementById(id).getBoundingClientRect());
    const wide = Math.max(0, Math.min(a.right, b.right) - Math.max(a.left, b.left));
    const high = Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));
    return wide * high / (a.width * a.height); }";

/// How many of the limb's nodes are under the legend.
const HIDDEN_NODES: &str = "(({ left, top, right, bottom }) =>
    Array.from({ length: hapdefView.nodes }, (_, i) => hapdefView.project(i))
        .filter(([x, y]) => x > left && x < right && y > top && y < bottom).length)(
    document.getElementById('legend').getBoundingClientRect())";

#[test]
fn a_window_of_any_width_has_room_for_its_sliders_and_scales() {
    for size in [(1200, 800), (1024, 700), (900, 700), (850, 600), (390, 844)] {
        let Some(mut look) = look(size, true, "", touched) else {
            return;
        };
        look.until("hapdefView.coloured > 0");
        look.do_it(COVERED);
        for slider in ["time", "exaggerate"] {
            let width = format!("document.getElementById('{slider}').offsetWidth");
            let width_px = look.number(&width);
            assert!(width_px >= 120.0, "{slider} {width_px} px in {size:?}");
        }
        let share = look.number("covered('limb', 'legend')");
        assert!(share < 0.06, "{share} of the stage in {size:?}");
        look.is(HIDDEN_NODES, &json!(0));
        for part in ["ruler", "legend", "tools", "health"] {
            look.is(&format!("covered('axes', '{part}')"), &json!(0));
        }
        let heights =
            "['exaggerate-out', 'legend'].map((id) => document.getElementById(id).offsetHeight)";
        let off = look.chrome.eval(heights).unwrap();
        look.do_it("const e = document.getElementById('exaggerate'); e.value = 1; e.oninput()");
        look.until("document.getElementById('exaggerate-out').textContent.endsWith('at most')");
        look.is(heights, &off);
    }
}

#[test]
fn axes_turn_with_the_view() {
    let Some(mut look) = look((900, 700), true, "", touched) else {
        return;
    };
    let end = |letter: &str, at: &str| {
        let lines = "[...document.querySelectorAll('#axes g')]";
        format!(
            "Number({lines}.find((g) => g.textContent === '{letter}').children[0].getAttribute('{at}'))"
        )
    };
    // From x and a little from the right, z is up and y to the right.
    let before: Vec<f64> = ["x", "y", "z"].map(|axis| look.number(&end(axis, "x2"))).into();
    assert!(before[1] > 15.0 && before[2].abs() < 1e-6, "{before:?}");
    assert!(look.number(&end("z", "y2")) < -20.0);
    look.do_it("document.getElementById('limb').focus()");
    look.chrome.key("ArrowLeft", "ArrowLeft").unwrap();
    look.until(&format!("Math.abs({} - {}) > 1", end("x", "x2"), before[0]));
}

#[test]
fn an_arrow_that_is_seen_along_itself_has_a_sign_beside_its_newtons() {
    let Some(mut look) = look((1200, 800), true, "", touched) else {
        return;
    };
    look.until("hapdefView.signs.length === 1");
    look.is("hapdefView.signs[0][3]", &json!(false));
    let clear = "(([x, y, radius], box) => Math.max(box.left - x, x - box.right) >= radius)(
        hapdefView.signs[0], document.querySelector('.label:not([hidden])').getBoundingClientRect())";
    look.is(clear, &json!(true));
    look.do_it("document.getElementById('limb').focus()");
    for _ in 0..4 {
        look.chrome.key("ArrowLeft", "ArrowLeft").unwrap();
    }
    look.until("hapdefView.signs.length === 0");
    for _ in 0..N_HALF_TURN - 4 {
        look.chrome.key("ArrowLeft", "ArrowLeft").unwrap();
    }
    look.until("hapdefView.signs.length === 1 && hapdefView.signs[0][3]");
    look.is(clear, &json!(true));
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}
