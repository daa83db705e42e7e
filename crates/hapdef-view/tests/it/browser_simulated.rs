//! What the page shows of a simulated limb: the truth, presses of several fingers, peaks between pictures,
//! labels beside panels, help; in a headless Chromium.
//!
//! Left out where there is no Chromium, as `browser.rs` says.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hapdef_view::{ViewCommand, ViewFrame};
use serde_json::json;

use crate::support::film::{Still, film};
use crate::support::look::{Look, look};
use crate::support::synthetic::{self, Touch, on_limb};

/// Boxes of the labels that are over a panel or over each other.
const OVER: &str = "(() => {
    const boxes = (selector) => [...document.querySelectorAll(selector)].map((part) => part.getBoundingClientRect()).filter((box) => box.width > 0);
    const labels = boxes('.label:not([hidden])');
    const panels = boxes('#tools > *, #legend, #ruler, #axes');
    const over = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    return labels.filter((label, i) => panels.some((panel) => over(label, panel)) || labels.some((other, k) => k < i && over(label, other))).length;
})()";

/// Most of the height of the gauges' plot that a curve covers in one place.
const TALLEST: &str = "(() => {
    const plot = document.getElementById('gauge-plot');
    const { width, height } = plot;
    const { data } = plot.getContext('2d').getImageData(0, 0, width, height);
    const isLine = (i) => data[i + 3] > 100 && Math.abs(data[i] - data[i + 2]) > 24;
    let tallest = 0;
    for (let x = 0; x < width; x += 1) {
        let n = 0;
        for (let y = 0; y < height; y += 1) n += isLine(4 * (y * width + x));
        tallest = Math.max(tallest, n);
    }
    return tallest / height; })()";

fn touch(id: u32, theta: f64, z: f64) -> Touch {
    let (point_m, normal) = on_limb(theta, z);
    Touch { id, point_m, normal, force_n: 5.0 }
}

fn frame_of(n: u32, touches: &[Touch]) -> ViewFrame {
    let mut frame = ViewFrame::default();
    synthetic::show(&synthetic::picture(), touches, 0.01 * f64::from(n), &mut frame);
    frame
}

/// A contact 3 mm beside where the limb is pressed, and a press that nothing was found of.
fn beside(n: u32) -> ViewFrame {
    let found = touch(0, -0.6, 0.2);
    let mut frame = frame_of(n, &[found]);
    let mut near = synthetic::mark(&found);
    near.contact.position_m.z += 3e-3;
    frame.truths = vec![synthetic::mark(&touch(1, 2.0, 0.1)), near];
    frame
}

#[test]
fn a_simulated_contact_says_how_far_off_the_truth_it_is() {
    let Some(mut look) = look((1200, 800), true, "", beside) else {
        return;
    };
    look.until("document.querySelector('#contacts .off')?.textContent === '3.0 mm off'");
    look.until("document.querySelector('.label:not([hidden]) small').textContent === '3.0 mm off'");
    look.is("hapdefView.truths.length", &json!(2));
    look.is("hapdefView.offs.map((off) => off.toFixed(4))", &json!(["0.0030"]));
    look.is("document.getElementById('truth-key').checkVisibility()", &json!(true));
    look.is(
        "document.querySelector('#contacts .where').textContent.match(/x .*y .*z .* mm/u) !== null",
        &json!(true),
    );
    // the region has standard deviations of 1.6 and 2.7 mm: 3 mm off is within its picture
    look.is("document.querySelector('.zoom .true').style.display", &json!(""));
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}

#[test]
fn without_a_truth_nothing_is_said_of_it() {
    let Some(mut look) = look((1200, 800), true, "", |n| frame_of(n, &[touch(0, -0.6, 0.2)]))
    else {
        return;
    };
    look.until("document.querySelector('#contacts b')?.textContent === '5.0 N'");
    look.is("document.querySelector('#contacts .off').textContent", &json!(""));
    look.is("document.getElementById('truth-key').checkVisibility()", &json!(false));
    look.is("hapdefView.offs", &json!([null]));
}

#[test]
fn presses_that_are_held_stay_until_they_are_let_go_together() {
    let Some(mut look) = look((1200, 800), true, "", |n| frame_of(n, &[])) else {
        return;
    };
    look.do_it("document.getElementById('keep').click()");
    let mut fingers = Vec::new();
    for shift in [-60.0, 60.0] {
        let node = look.number("hapdefView.facing()");
        let x = look.number(&format!("hapdefView.project({node})[0]"));
        let y = look.number(&format!("hapdefView.project({node})[1]")) + shift;
        look.chrome.pointer("mouseMoved", (x, y)).unwrap();
        look.chrome.pointer("mousePressed", (x, y)).unwrap();
        fingers.push(pressing_finger(&look));
        look.chrome.pointer("mouseReleased", (x, y)).unwrap();
    }
    assert_eq!(fingers, [0, 1]);
    look.is("hapdefView.pressing", &json!(2));
    look.chrome.key("Escape", "Escape").unwrap();
    look.view.hears(&ViewCommand::Release);
    look.is("hapdefView.pressing", &json!(0));
    look.do_it("document.getElementById('random').click()");
    look.view.hears(&ViewCommand::Random(false));
    look.is("document.getElementById('random').ariaPressed", &json!("false"));
    assert_eq!(look.chrome.complaints().unwrap(), Vec::<String>::new());
}

/// The finger of the next press; nothing is let go before it.
fn pressing_finger(look: &Look) -> u32 {
    loop {
        match look.view.view.commands().recv() {
            Ok(ViewCommand::Press { finger, .. }) => return finger,
            Ok(ViewCommand::Release | ViewCommand::Lift { .. }) => panic!("let go"),
            Ok(_) => {}
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn one_of_two_fingers_can_be_lifted() {
    let Some(mut look) = look((1200, 800), true, "", |n| frame_of(n, &[])) else {
        return;
    };
    look.do_it(
        "globalThis.finger = (kind, id, dy) => {
            const [x, y] = hapdefView.project(hapdefView.facing());
            const canvas = document.getElementById('limb');
            canvas.setPointerCapture = () => {};
            canvas.dispatchEvent(new PointerEvent(kind, { pointerId: id, pointerType: 'touch', button: 0, clientX: x, clientY: y + dy, bubbles: true }));
        };
        finger('pointerdown', 11, -40); finger('pointerdown', 12, 40); finger('pointerup', 11, -40)",
    );
    look.view.hears(&ViewCommand::Lift { finger: 0 });
    look.is("hapdefView.pressing", &json!(1));
    look.do_it("finger('pointerup', 12, 40)");
    look.view.hears(&ViewCommand::Release);
}

#[test]
fn a_peak_between_two_pictures_is_in_the_plot() {
    let tallest = |has_peaks: bool| {
        let mut look = look((1200, 800), true, "", move |n| {
            let mut frame = frame_of(n, &[touch(0, -0.6, 0.2)]);
            frame.ranges_ue = frame.readings_ue.iter().map(|&reading| [reading; 2]).collect();
            if has_peaks {
                frame.ranges_ue[3] = [-150.0, 150.0];
            }
            frame
        })?;
        look.until("hapdefView.newest > 1.5");
        look.until("hapdefView.t > 1.5");
        Some(look.number(TALLEST))
    };
    let (Some(smooth), Some(peaked)) = (tallest(false), tallest(true)) else {
        return;
    };
    assert!(peaked > 0.6 && smooth < 0.3, "{peaked} of the height with peaks, {smooth} without");
}

#[test]
fn labels_keep_off_panels_and_each_other() {
    for size in [(1200, 800), (390, 844)] {
        let wandering = |n: u32| frame_of(n, &synthetic::wandering(0.01 * f64::from(n)));
        let Some(mut look) = look(size, true, "", wandering) else {
            return;
        };
        look.do_it("document.getElementById('names').click()");
        look.until("document.querySelectorAll('.label:not([hidden])').length > 10");
        for turn in 0..3 {
            assert_eq!(look.number(OVER), 0.0, "{size:?}, turned {turn} times");
            for _ in 0..6 {
                look.do_it("document.getElementById('limb').focus()");
                look.chrome.key("ArrowLeft", "ArrowLeft").unwrap();
            }
            let drawn = look.number("hapdefView.drawn");
            look.until(&format!("hapdefView.drawn > {drawn} + 1"));
        }
    }
}

#[test]
fn a_gauge_is_found_by_its_row_its_curve_and_its_place() {
    let Some(mut look) = look((1200, 800), true, "", |n| frame_of(n, &[])) else {
        return;
    };
    look.do_it("document.querySelector('#gauges li:nth-child(3)').click()");
    look.until("document.querySelector('.label.seen:not([hidden])') !== null");
    look.is(
        "document.querySelector('.label.seen:not([hidden])').textContent === document.querySelector('#gauges li.seen span').textContent",
        &json!(true),
    );
    look.is("document.querySelectorAll('#gauges li.seen').length", &json!(1));
    look.until("hapdefView.sites[2] === '#5cc8ff'");
}

#[test]
fn help_opens_with_its_key_and_says_every_key() {
    let Some(mut look) = look((1200, 800), true, "", |n| frame_of(n, &[])) else {
        return;
    };
    look.is("document.getElementById('help').open", &json!(false));
    look.chrome.key("?", "Slash").unwrap();
    look.is("document.getElementById('help').open", &json!(true));
    look.is(
        "['T', 'R', 'S', 'P', 'H', 'A', 'F', 'N', 'space', 'enter', 'arrows'].filter((key) =>
            ![...document.querySelectorAll('#help dt')].some((part) => part.textContent.split(' ').includes(key))).join()",
        &json!(""),
    );
    look.chrome.key("?", "Slash").unwrap();
    look.is("document.getElementById('help').open", &json!(false));
}

#[test]
fn what_is_touched_on_a_phone_is_as_large_as_a_finger() {
    let Some(mut look) = look((390, 844), true, "", beside) else {
        return;
    };
    look.is(
        "[...document.querySelectorAll('button, select, input')].filter((part) => part.checkVisibility())
            .filter((part) => part.getBoundingClientRect().height < 43.5 || part.getBoundingClientRect().width < 43.5)
            .map((part) => part.id).join()",
        &json!(""),
    );
}

#[test]
fn an_exaggeration_comes_smoothly() {
    let Some(mut look) = look((1200, 800), true, "", |n| frame_of(n, &[])) else {
        return;
    };
    // pictures of 16 ms each until it is there
    look.is(
        "import('/js/limb.js').then(({ Limb }) => {
            const limb = { exaggeration: 100, eased: 0, ease: Limb.prototype.ease };
            const drawn = [];
            while (limb.ease(16) && drawn.length < 100) drawn.push(limb.eased);
            const steps = drawn.map((at, i) => at - (drawn[i - 1] ?? 0));
            return [drawn.length > 20, drawn.at(-1), Math.max(...steps) < 15, Math.min(...steps) > 0];
        })",
        &json!([true, 100, true, true]),
    );
}

#[test]
fn stills_make_a_moving_picture_that_a_browser_plays() {
    let Some(mut look) = look((400, 300), true, "", beside) else {
        return;
    };
    let stills = [120, 250].map(|for_ms| {
        let webp = look.chrome.picture("webp").unwrap();
        Still { webp, for_ms }
    });
    let moving = STANDARD.encode(film(&stills).unwrap());
    let played = look.chrome.eval(&format!(
        "(async () => {{
            const data = Uint8Array.from(atob('{moving}'), (c) => c.charCodeAt(0));
            const decoder = new ImageDecoder({{ data, type: 'image/webp' }});
            await decoder.completed;
            await decoder.tracks.ready;
            const seen = [decoder.tracks.selectedTrack.frameCount];
            for (let frameIndex = 0; frameIndex < seen[0]; frameIndex += 1) {{
                const {{ image }} = await decoder.decode({{ frameIndex }});
                seen.push(image.duration / 1000, image.displayWidth, image.displayHeight);
            }}
            return seen;
        }})()"
    ));
    // A window as narrow as a phone has two pixels for each of CSS.
    assert_eq!(played.unwrap(), json!([2, 120, 800, 600, 250, 800, 600]));
    assert!(film(&[]).is_err());
    let webp = look.chrome.picture("png").unwrap();
    assert!(film(&[Still { webp, for_ms: 1 }]).is_err());
}
