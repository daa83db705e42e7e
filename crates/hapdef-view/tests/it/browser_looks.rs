//! What the page shows and how it is handled, in a headless Chromium, on frames that say what is to be seen.
//!
//! Left out where there is no Chromium, as `browser.rs` says.

use crate::support::look;
use crate::support::page;
use crate::support::synthetic;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use hapdef_contact::{GaugeHealth, TouchPhase, UnknownReason};
use hapdef_view::{Displacement, ReplayPosition, ViewCommand, ViewFrame, ViewParams};
use look::{Look, Served, look};
use page::params;
use serde_json::json;
use synthetic::{Touch, on_limb};

/// Pixels of the force plot that have the colour of the first contact.
const CURVE: &str = "import('/js/colour.js').then(({ contactColour }) => {
    const of = (at) => parseInt(contactColour(0).slice(at, at + 2), 16);
    const colour = [1, 3, 5].map(of);
    const plot = document.getElementById('force-plot');
    const { data } = plot.getContext('2d').getImageData(0, 0, plot.width, plot.height);
    let n = 0;
    for (let i = 0; i < data.length; i += 4) n += colour.every((c, k) => Math.abs(c - data[i + k]) < 9) && data[i + 3] > 200;
    return n; })";

/// Pixels of the gauges' plot that have the colour of the first gauge.
const GAUGE_CURVE: &str = "import('/js/colour.js').then(({ mapColour }) => {
    const colour = mapColour('viridis', 0.25).map((c) => Math.round(255 * c));
    const plot = document.getElementById('gauge-plot');
    const { data } = plot.getContext('2d').getImageData(0, 0, plot.width, plot.height);
    let n = 0;
    for (let i = 0; i < data.length; i += 4) n += colour.every((c, k) => Math.abs(c - data[i + k]) < 9) && data[i + 3] > 200;
    return n; })";

fn touch(force_n: f64) -> Touch {
    let (point_m, normal) = on_limb(-0.6, 0.2);
    Touch { id: 0, point_m, normal, force_n }
}

/// One touch, at a time that goes `speed` times as fast as it is pushed.
fn touched(n: u32, speed: f64, force_n: f64) -> ViewFrame {
    let mut frame = ViewFrame::default();
    let t_s = 0.01 * speed * f64::from(n);
    synthetic::show(&synthetic::picture(), &[touch(force_n)], t_s, &mut frame);
    frame
}

/// A soft limb, another explanation, gauges that are dead, saturated and left out, readings of four digits,
/// frames that were dropped.
fn doubtful(n: u32) -> ViewFrame {
    let mut frame = touched(n, 1.0, 5.0);
    let (point_m, normal) = on_limb(-0.2, 0.1);
    let other = Touch { id: 0, point_m, normal, force_n: 3.0 };
    frame.alternatives = vec![(0.21, vec![synthetic::mark(&other)])];
    frame.readings_ue[0] = -1990.0;
    frame.readings_ue[1] = 1990.0;
    frame.gauge_health[1] = GaugeHealth::Saturated;
    frame.gauge_health[7] = GaugeHealth::Dead;
    frame.gauge_health[4] = GaugeHealth::Spike;
    frame.health.n_lost = 7;
    frame.health.n_dropped = 1234;
    frame.health.n_crc_errors = 3;
    frame.health.rate_hz = 0.0;
    frame.health.latency_p50_us = 182.0;
    frame.health.latency_p99_us = 1740.0;
    frame.health.clock_residual_us = 4.25;
    if let Displacement::Vector(moved) = &mut frame.displacement {
        moved.as_flattened_mut().iter_mut().for_each(|c| *c *= 40.0);
    }
    frame
}

#[test]
fn a_light_page_marks_what_is_dead_saturated_and_doubtful() {
    let Some(mut look) = look((1200, 800), false, "", doubtful) else {
        return;
    };
    look.until("document.querySelectorAll('#gauges li.dead').length === 1");
    let text = |query: &str| format!("document.querySelector('{query}').textContent");
    look.is(&text("#gauges li.dead .value"), &json!("dead"));
    look.is(&text("#gauges li.saturated .value"), &json!("sat."));
    look.is(
        "[...document.querySelectorAll('#gauges li')].map((li) => li.className)",
        &json!(["", "saturated", "", "", "out", "", "", "dead", "", ""]),
    );
    look.is(&text("#gauges li.out .value"), &json!("out"));
    look.is(
        "[...document.querySelectorAll('#health .bad')].map((row) => row.textContent)",
        &json!(["Rate0 Hz", "Lost7", "Dropped1,234", "CRC errors3"]),
    );
    look.is(
        "[...document.querySelectorAll('#health div:not(.bad)')].map((row) => row.textContent)",
        &json!(["Latency182 µs · p99 1.7 ms", "Fitp 0.40", "Clock±4.3 µs", "Recordingoff"]),
    );
    let (good, saturated, dead, out) = ("#f3f6fa", "#ffb454", "#ff7b72", "#8a94a3");
    look.is(
        "hapdefView.sites",
        &json!([good, saturated, good, good, out, good, good, dead, good, good]),
    );
    look.is(&text("#contacts li.other span"), &json!("or this, 21 %"));
    look.until("document.querySelectorAll('.label.other:not([hidden])').length === 1");
    look.is(
        "[hapdefView.contacts.length, hapdefView.others, hapdefView.arrows.length, hapdefView.ellipses]",
        &json!([1, 1, 2, 2]),
    );
    look.until("hapdefView.ghosts > 0");
    look.is("[...document.querySelectorAll('#ticks span')].at(-1).textContent", &json!("5 mm"));
    let first_column = "(({ height }, pen) => [...pen.getImageData(0, 0, 1, height).data])(
        document.getElementById('gauge-plot'),
        document.getElementById('gauge-plot').getContext('2d'))";
    look.is(&format!("{first_column}.some((x) => x > 0)"), &json!(false));
    look.until(&format!("{CURVE}.then((n) => n > 60)"));
    look.until(&format!("{GAUGE_CURVE}.then((n) => n > 60)"));
    for (x, y) in [(0.5, 0.02), (0.98, 0.98)] {
        let pixel = look.picture_at(x, y);
        assert!(pixel[..3].iter().all(|&c| c > 200), "{pixel:?}");
        assert_eq!(pixel[3], 255);
    }
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}

/// Whether the limb is hatched all over, by what is painted above it.
const HATCHED: &str = "(() => {
    const above = getComputedStyle(document.getElementById('stage'), '::after');
    return above.content !== 'none' && above.backgroundImage.startsWith('repeating-linear-gradient')
        && above.inset === '0px'; })()";

/// A second of good frames in turn with one that no believed contact explains.
#[test]
fn readings_that_nothing_explains_look_bad() {
    let is_bad = |n: u32| n / 100 % 2 == 1;
    let make = move |n: u32| {
        let mut frame = touched(n, 1.0, 5.0);
        if is_bad(n) {
            frame.phase = TouchPhase::Unknown(UnknownReason::Misfit);
            frame.is_stale = true;
        }
        frame
    };
    let Some(mut look) = look((1200, 800), true, "", make) else {
        return;
    };
    let said = "document.getElementById('unknown').textContent";
    let opacity = "Number(getComputedStyle(document.getElementById('contacts')).opacity)";
    let good = format!("!{HATCHED} && {said} === '' && {opacity} === 1");
    let bad = format!("{HATCHED} && {said} === 'Readings not explained' && {opacity} < 1");
    for _ in 0..2 {
        look.until(&good);
        look.until(&bad);
    }
}

#[test]
fn a_paused_picture_stays_and_the_slider_goes_back() {
    let Some(mut look) = look((1200, 800), true, "", |n| touched(n, 10.0, 5.0)) else {
        return;
    };
    look.until("hapdefView.newest > 12");
    look.do_it("document.getElementById('pause').click()");
    look.is("document.getElementById('pause').textContent", &json!("Resume"));
    let held = look.number("hapdefView.t");
    // The slider goes back 30 s: the frame is beyond that, and gone from what can be gone back to.
    look.until(&format!("hapdefView.newest > {held} + 45"));
    look.do_it("document.querySelector('#gauges li').onpointerenter()");
    let drawn = look.number("hapdefView.drawn");
    look.do_it("document.getElementById('colours').onchange()");
    look.until(&format!("hapdefView.drawn > {drawn}"));
    assert_eq!(look.number("hapdefView.t"), held);
    look.do_it("document.getElementById('snapshot').click()");
    look.view.hears(&ViewCommand::Snapshot { t_s: Some(held) });

    let then = look.number(
        "(() => { const time = document.getElementById('time'); time.value = -12;
            const then = hapdefView.newest + Number(time.value);
            time.oninput();
            return hapdefView.times.findLast((t) => t <= then); })()",
    );
    assert!(then > held, "{then} {held}");
    look.until(&format!("hapdefView.t === {then}"));
    look.is("document.getElementById('time').ariaValueText.startsWith('−')", &json!(true));
    look.do_it("document.getElementById('time').focus()");
    look.chrome.key(" ", "Space").unwrap();
    look.until("document.getElementById('time-out').textContent === 'live'");
    look.until("hapdefView.newest - hapdefView.t < 5");
    look.chrome.key("t", "KeyT").unwrap();
    look.view.hears(&ViewCommand::Tare);
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}

#[test]
fn keys_turn_zoom_press_record_and_keep() {
    let Some(mut look) = look((1200, 800), true, "", |n| touched(n, 1.0, 5.0)) else {
        return;
    };
    let at = |look: &mut Look| -> (f64, f64) {
        serde_json::from_value(look.chrome.eval("hapdefView.project(20)").unwrap()).unwrap()
    };
    look.do_it("document.getElementById('limb').focus()");
    let first = at(&mut look);
    for (key, code) in [("ArrowLeft", "ArrowLeft"), ("ArrowUp", "ArrowUp"), ("+", "Equal")] {
        let before = at(&mut look);
        look.chrome.key(key, code).unwrap();
        let now = at(&mut look);
        assert!((now.0 - before.0).hypot(now.1 - before.1) > 2.0, "{key}: {before:?} {now:?}");
    }
    look.chrome.key("f", "KeyF").unwrap();
    let fitted = at(&mut look);
    assert!((fitted.0 - first.0).hypot(fitted.1 - first.1) < 1e-6, "{first:?} {fitted:?}");
    look.chrome.key("r", "KeyR").unwrap();
    look.view.hears(&ViewCommand::Record(true));
    let pressing = "document.getElementById('press').ariaPressed";
    look.is(pressing, &json!("true"));
    look.chrome.key("p", "KeyP").unwrap();
    look.is(pressing, &json!("false"));
    look.chrome.key("p", "KeyP").unwrap();
    look.chrome.key("Enter", "Enter").unwrap();
    look.view.hears(&ViewCommand::Release);
}

#[test]
fn everything_that_is_handled_has_a_name() {
    for size in [(1200, 800), (390, 844)] {
        let Some(mut look) = look(size, true, "", |n| touched(n, 1.0, 5.0)) else {
            return;
        };
        let all = "[...document.querySelectorAll('button, input, select, [role=img]')]
            .filter((part) => part.checkVisibility())";
        // Eleven buttons, three sliders, one list, the limb, two plots and the contact's region.
        look.is(&format!("{all}.length"), &json!(19));
        for i in 0..19 {
            let part = format!("{all}[{i}]");
            let name = look.chrome.name_of(&part).unwrap();
            let id = look.chrome.eval(&format!("{part}.id")).unwrap();
            let n_letters = name.chars().filter(|c| c.is_alphabetic()).count();
            assert!(n_letters > 2, "{size:?}, {id}: {name:?}");
        }
    }
}

#[test]
fn without_webgl_the_numbers_go_on() {
    const NO_WEBGL: &str = "const own = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
            return kind.startsWith('webgl') ? null : own.call(this, kind, ...rest);
        };";
    let Some(mut look) = look((1200, 800), true, NO_WEBGL, |n| touched(n, 1.0, 5.0)) else {
        return;
    };
    look.until("document.querySelector('#contacts b')?.textContent === '5.0 N'");
    look.is("document.getElementById('link').textContent", &json!("live"));
    look.is("document.getElementById('no-webgl').offsetHeight > 10", &json!(true));
    look.is("document.getElementById('tools').offsetHeight", &json!(0));
    look.is("document.querySelectorAll('#gauges li').length", &json!(10));
    let drawn = look.number("hapdefView.drawn");
    look.until(&format!("hapdefView.drawn > {drawn} + 5"));
}

#[test]
fn a_page_that_comes_later_knows_that_a_replay_is_stopped() {
    let is_paused = Arc::new(AtomicBool::new(true));
    let says = Arc::clone(&is_paused);
    let make = move |n| ViewFrame {
        replay: Some(ReplayPosition {
            position_s: 2.0,
            duration_s: 9.0,
            is_paused: says.load(Ordering::Relaxed),
        }),
        ..touched(n, 0.0, 5.0)
    };
    let Some(mut look) = look((1200, 800), true, "", make) else {
        return;
    };
    let button = "document.getElementById('pause').textContent";
    look.is(button, &json!("Resume"));
    look.do_it("document.getElementById('pause').click()");
    look.view.hears(&ViewCommand::Pause(false));
    look.is(button, &json!("Resume"));
    look.do_it(
        "(() => { const time = document.getElementById('time'); time.value = 6; time.oninput(); })()",
    );
    look.view.hears(&ViewCommand::Seek { position_s: 6.0 });
    is_paused.store(false, Ordering::Relaxed);
    look.until(&format!("{button} === 'Pause'"));

    let url = look.view.view.url().split('#').next().unwrap().to_owned();
    look.chrome.open("about:blank").unwrap();
    look.chrome.open(&url).unwrap();
    look.until("globalThis.hapdefView?.drawn > 1");
    look.do_it("document.getElementById('pause').click()");
    look.until("document.getElementById('say').textContent.startsWith('Refused: view only')");
    look.is(button, &json!("Pause"));
}

#[test]
fn another_limb_on_the_same_port_is_looked_at_anew() {
    let Some(mut look) = look((900, 700), true, "", |n| touched(n, 1.0, 5.0)) else {
        return;
    };
    let radius_m = look.number("hapdefView.radius");
    let bind = look.view.view.address();
    let mut small = synthetic::picture();
    small.vertices_m.as_flattened_mut().iter_mut().for_each(|c| *c *= 0.5);
    let Look { chrome, view, _one } = look;
    drop(view);
    let view = Served::start(ViewParams { bind, ..params() }, small, |n| touched(n, 1.0, 5.0));
    let mut look = Look { chrome, view, _one };
    look.until(&format!("Math.abs(hapdefView.radius - {radius_m} / 2) < 1e-6"));
    look.until("document.getElementById('ruler').textContent.trim() !== ''");
}

#[test]
fn a_drag_presses_on_where_the_pointer_goes() {
    let Some(mut look) = look((1200, 800), true, "", |n| touched(n, 1.0, 5.0)) else {
        return;
    };
    look.do_it("document.getElementById('press').click()");
    let node = look.number("hapdefView.facing()");
    let project = |look: &mut Look| {
        ["0", "1"].map(|k| look.number(&format!("hapdefView.project({node})[{k}]")))
    };
    let at = project(&mut look);
    let (from, to) = ((at[0], at[1]), (at[0], at[1] - 50.0));
    look.chrome.pointer("mouseMoved", from).unwrap();
    look.chrome.pointer("mousePressed", from).unwrap();
    let first = look.view.hears_a_press();
    // the page sends 30 presses a second at most
    std::thread::sleep(Duration::from_millis(100));
    look.chrome.pointer("mouseMoved", to).unwrap();
    let then = look.view.hears_a_press();
    let moved: f64 = (0..3).map(|k| (then[k] - first[k]).powi(2)).sum();
    assert!(moved.sqrt() > 0.003, "{first:?} {then:?}");
    look.chrome.pointer("mouseReleased", to).unwrap();
    look.view.hears(&ViewCommand::Release);
    let after = project(&mut look);
    assert!((after[0] - at[0]).hypot(after[1] - at[1]) < 0.5, "the view stays where it is");
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}
