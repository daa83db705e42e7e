//! The limb, pressed by words of the page.

use std::sync::OnceLock;

use hapdef_wasm::{PageModel, Session};
use nalgebra::Point3;
use proptest::prelude::*;
use serde_json::json;

use crate::support::{self, LARGEST_N, told};

/// Frames in which the tare is over.
const TARE: u32 = 1100;
/// Frames after which a press is settled.
const SETTLED: u32 = 600;

fn model() -> &'static PageModel {
    static MODEL: OnceLock<PageModel> = OnceLock::new();
    MODEL.get_or_init(support::model)
}

/// Tared, and pressed by nobody but the test.
fn quiet() -> Session {
    let mut session = Session::new(model()).unwrap();
    session.hear(r#"{"cmd":"random","on":false}"#);
    session.step(TARE);
    told::all(&mut session);
    session
}

/// A node of the skin nearest to a place on the barrel.
fn node_near(angle: f64, height_m: f64) -> Point3<f64> {
    let radius = support::world::RADIUS_M;
    let at = Point3::new(radius * angle.cos(), height_m, radius * angle.sin());
    let nodes = model().bundle().skin().nodes();
    *nodes.iter().min_by(|a, b| (*a - at).norm().total_cmp(&(*b - at).norm())).unwrap()
}

fn press(session: &mut Session, finger: u32, at: &Point3<f64>, force_n: f64) {
    let normal = [at.x / at.x.hypot(at.z), 0.0, at.z / at.x.hypot(at.z)];
    let point_m: [f64; 3] = at.coords.into();
    let words = json!({"cmd": "press", "finger": finger, "point_m": point_m, "normal": normal, "force_n": force_n});
    session.hear(&words.to_string());
}

#[track_caller]
fn is_found(found: &[told::Mark], at: &Point3<f64>, force_n: f64) {
    let mark = found.iter().min_by(|a, b| (a.at - at).norm().total_cmp(&(b.at - at).norm()));
    let mark = mark.expect("a contact");
    let off_m = (mark.at - at).norm();
    assert!(off_m < 1e-3, "{:.2} mm off", 1e3 * off_m);
    let found_n = mark.force_n.norm();
    assert!((found_n - force_n).abs() < 0.05 * force_n, "{found_n} N of {force_n}");
}

#[test]
fn it_greets_as_the_server_does() {
    let mut session = Session::new(model()).unwrap();
    let messages = told::all(&mut session);
    let texts = told::texts(&messages);
    assert_eq!(texts[0]["type"], "hello");
    assert_eq!(texts[0]["title"], "barrel");
    assert_eq!(texts[0]["gauges"].as_array().unwrap().len(), support::N_GAUGES);
    assert_eq!(texts[0]["offers"]["record"], false);
    assert_eq!(texts[0]["offers"]["press"]["max_n"], LARGEST_N);
    assert_eq!(texts[1], json!({"type": "device", "simulated": true, "fault": null}));
    assert_eq!(messages.len(), 3);
}

#[test]
fn untouched_it_shows_nothing_once_it_is_tared() {
    let mut session = Session::new(model()).unwrap();
    session.hear(r#"{"cmd":"random","on":false}"#);
    session.step(500);
    assert_eq!(told::newest(&mut session).phase(), "taring");
    session.step(TARE - 500);
    let messages = told::all(&mut session);
    assert_eq!(told::texts(&messages), [json!({"type": "notice", "text": "Tared"})]);
    for _ in 0..20 {
        session.step(50);
        let frame = told::newest(&mut session);
        assert_eq!((frame.phase(), frame.contacts.len()), ("untouched", 0));
        assert!(frame.truths.is_empty());
    }
}

#[test]
fn one_press_is_one_contact() {
    let mut session = quiet();
    let at = node_near(0.7, 0.06);
    press(&mut session, 0, &at, 10.0);
    session.step(SETTLED);
    let frame = told::newest(&mut session);
    assert_eq!((frame.phase(), frame.contacts.len()), ("touched", 1), "{frame:?}");
    is_found(&frame.contacts, &at, 10.0);
    assert!((frame.truths[0].at - at).norm() < 1e-6);
    session.hear(r#"{"cmd":"release"}"#);
    session.step(SETTLED);
    assert_eq!(told::newest(&mut session).phase(), "untouched");
}

#[test]
fn two_presses_are_two_contacts() {
    let mut session = quiet();
    let (first, second) = (node_near(0.5, 0.05), node_near(2.5, 0.07));
    press(&mut session, 0, &first, 10.0);
    press(&mut session, 1, &second, 15.0);
    session.step(SETTLED);
    let frame = told::newest(&mut session);
    assert_eq!(frame.contacts.len(), 2, "{frame:?}");
    is_found(&frame.contacts, &first, 10.0);
    is_found(&frame.contacts, &second, 15.0);
    session.hear(r#"{"cmd":"lift","finger":0}"#);
    session.step(SETTLED);
    let frame = told::newest(&mut session);
    assert_eq!(frame.contacts.len(), 1, "{frame:?}");
    is_found(&frame.contacts, &second, 15.0);
}

#[test]
fn it_presses_by_itself_until_it_is_told_not_to() {
    let mut session = Session::new(model()).unwrap();
    session.step(TARE);
    let mut is_pressed = false;
    for _ in 0..100 {
        session.step(50);
        is_pressed |= !told::newest(&mut session).truths.is_empty();
    }
    assert!(is_pressed);
    session.hear(r#"{"cmd":"random","on":false}"#);
    session.step(50);
    assert!(told::newest(&mut session).truths.is_empty());
}

#[test]
fn a_tare_lets_go_first() {
    let mut session = quiet();
    let at = node_near(1.0, 0.06);
    press(&mut session, 0, &at, 10.0);
    session.step(SETTLED);
    told::all(&mut session);
    session.hear(r#"{"cmd":"tare"}"#);
    session.step(TARE + SETTLED);
    let messages = told::all(&mut session);
    let words: Vec<_> = told::texts(&messages).iter().map(|text| text["text"].clone()).collect();
    assert_eq!(words, ["Taring: touch nothing", "Tared"]);
    let frame = messages.iter().rev().find_map(told::frame).unwrap();
    assert_eq!(frame.contacts.len(), 1, "the finger is still there");
    is_found(&frame.contacts, &at, 10.0);
}

#[test]
fn what_is_not_offered_is_refused() {
    let mut session = quiet();
    for words in [r#"{"cmd":"record","on":true}"#, "nonsense", r#"{"cmd":"press"}"#] {
        session.hear(words);
        let answers = told::texts(&told::all(&mut session));
        assert_eq!(answers[0]["type"], "refused", "{words}");
    }
}

#[test]
fn the_same_words_give_the_same_messages() {
    let run = || {
        let mut session = Session::new(model()).unwrap();
        session.step(TARE);
        press(&mut session, 0, &node_near(0.7, 0.06), 10.0);
        for _ in 0..20 {
            session.step(30);
        }
        told::all(&mut session)
    };
    assert!(run() == run());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever is said, it goes on.
    #[test]
    fn no_words_stop_it(words in prop::collection::vec(any_words(), 1..8)) {
        let mut session = Session::new(model()).unwrap();
        for text in &words {
            session.hear(text);
            session.step(3);
        }
        prop_assert!(told::all(&mut session).iter().any(|message| told::frame(message).is_some()));
    }
}

fn any_words() -> impl Strategy<Value = String> {
    let bytes = prop::collection::vec(any::<u8>(), 0..40)
        .prop_map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    let numbers = (any::<u32>(), any::<[f64; 3]>(), any::<f64>());
    let press = numbers.prop_map(|(finger, at, force_n)| {
        json!({"cmd": "press", "finger": finger, "point_m": at, "normal": [0.0, 0.0, 1.0], "force_n": force_n})
            .to_string()
    });
    let lift = any::<u32>().prop_map(|finger| json!({"cmd": "lift", "finger": finger}).to_string());
    let seek = any::<f64>().prop_map(|at| json!({"cmd": "seek", "position_s": at}).to_string());
    prop_oneof![bytes, press, lift, seek, Just(r#"{"cmd":"tare"}"#.to_owned())]
}
