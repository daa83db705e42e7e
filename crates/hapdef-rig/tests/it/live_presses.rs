//! The limb at run time and scripts on it: superposition, and truth that is what was asked for.

use crate::live_support;

use hapdef_rig::RigError;
use hapdef_rig::live::{
    Play, PressHandle, PressScript, Pressed, RandomScriptParams, SurfacePoint, TrueContact,
    TruthFrame, random_script,
};
use live_support::{N_GAUGES, column, plate, script};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

fn surface_point() -> impl Strategy<Value = SurfacePoint> {
    (0..120u32, 0.0..1.0f64, 0.0..1.0f64).prop_map(|(face, u, v)| {
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        SurfacePoint { face, bary: [1.0 - u - v, u, v] }
    })
}

fn force() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-30.0..30.0).prop_map(Vector3::from)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Strains of several forces are the sum of each one's, and grow with the force.
    #[test]
    fn strains_superpose(presses in prop::collection::vec((surface_point(), force()), 1..5), k in -3.0..3.0) {
        let limb = plate();
        let (mut all, mut sum) = ([0.0; N_GAUGES], [0.0; N_GAUGES]);
        for (point, force) in &presses {
            limb.add_strain_ue(point, &(force * k), &mut all);
            let mut alone = [0.0; N_GAUGES];
            limb.add_strain_ue(point, force, &mut alone);
            sum.iter_mut().zip(alone).for_each(|(s, a)| *s += k * a);
        }
        for (a, b) in all.iter().zip(sum) {
            prop_assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{a} and {b}");
        }
    }

    /// A quadratic response is had exactly anywhere on a face.
    #[test]
    fn a_quadratic_response_is_exact(point in surface_point(), force in force()) {
        let limb = plate();
        let x = limb.position_m(&point);
        let mut strain = [0.0; N_GAUGES];
        limb.add_strain_ue(&point, &force, &mut strain);
        for (gauge, strain) in strain.into_iter().enumerate() {
            let expected = column(gauge, &x).dot(&force);
            prop_assert!((strain - expected).abs() < 1e-9, "{strain}, expected {expected}");
        }
    }

    /// A place beside the skin comes back as the place below it, at its distance.
    #[test]
    fn the_nearest_point_is_below(x in 0.0..0.1f64, y in 0.0..0.06f64, off in -3e-3..3e-3f64) {
        let limb = plate();
        let (point, distance_m) = limb.nearest(&Point3::new(x, y, off)).unwrap();
        let found = limb.position_m(&point);
        prop_assert!((found - Point3::new(x, y, 0.0)).norm() < 1e-12, "{found}");
        prop_assert!((distance_m - off.abs()).abs() < 1e-12);
    }
}

fn contacts(play: &Play, t_s: f64) -> Vec<TrueContact> {
    let mut out = Vec::new();
    play.at(t_s, &plate(), &mut out);
    out
}

#[track_caller]
fn check(play: &Play, t_s: f64, expected: &[(u32, [f64; 2], f64)]) {
    let found = contacts(play, t_s);
    assert_eq!(found.len(), expected.len(), "at {t_s} s: {found:?}");
    for (contact, (id, [x, y], force_n)) in found.iter().zip(expected) {
        assert_eq!(contact.id, *id);
        let miss_m = (contact.position_m - Point3::new(*x, *y, 0.0)).norm();
        assert!(miss_m < 1e-9, "at {t_s} s: {contact:?}");
        let off_n = contact.force_n - force_n;
        assert!(off_n.abs() < 1e-9, "at {t_s} s: {contact:?}");
    }
}

#[test]
fn truth_is_what_was_asked_for() {
    let play = Play::new(&script(), &plate()).unwrap();
    let second = (7, [0.08, 0.05], 5.0);
    check(&play, 0.05, &[]);
    check(&play, 0.125, &[(1, [0.02, 0.02], 5.0 * (1.0 - 0.5f64.sqrt()))]);
    check(&play, 0.15, &[(1, [0.02, 0.02], 5.0), second]);
    check(&play, 0.25, &[(1, [0.02, 0.02], 10.0), second]);
    check(&play, 0.35, &[(1, [0.03, 0.02], 10.0), second]);
    check(&play, 0.45, &[(1, [0.04, 0.03], 10.0), second]);
    check(&play, 0.55, &[(1, [0.04, 0.04], 10.0), second]);
    check(&play, 0.65, &[(1, [0.04, 0.04], 15.0), second]);
    check(&play, 0.75, &[(1, [0.04, 0.04], 20.0), second]);
    check(&play, 0.85, &[(1, [0.04, 0.04], 10.0), second]);
    check(&play, 0.92, &[]);
    check(&play, 0.96, &[(7, [0.02, 0.02], 30.0)]);
    check(&play, 0.98, &[]);
    // Of the force along (2, 0, 5) the part along the skin counts.
    let pressed = contacts(&play, 0.75)[0];
    assert_eq!(pressed.shear_n, Vector3::new(2.0, 0.0, 0.0));
    assert_eq!(pressed.force_vector_n(), Vector3::new(2.0, 0.0, -20.0));
}

#[test]
fn a_repeated_script_begins_again() {
    let once = Play::new(&script(), &plate()).unwrap();
    let repeat_s = Some(1.5);
    let again = PressScript { repeat_s, ..script() };
    let again = Play::new(&again, &plate()).unwrap();
    for i in 0..150 {
        let t_s = f64::from(i) * 0.01 + 0.003;
        assert_eq!(contacts(&once, t_s), contacts(&again, t_s));
        assert_eq!(contacts(&once, t_s).len(), contacts(&again, t_s + 4.5).len(), "{t_s}");
    }
}

#[test]
fn scripts_come_back_from_their_file() {
    let text = script().to_json().unwrap();
    assert_eq!(PressScript::from_json(&text).unwrap(), script());
}

#[track_caller]
fn refused(from: &str, to: &str, path: &str) {
    let text = script().to_json().unwrap();
    assert!(text.contains(from), "{from} in {text}");
    let found = PressScript::from_json(&text.replacen(from, to, 1))
        .and_then(|script| Play::new(&script, &plate()));
    let error = found.unwrap_err().to_string();
    assert!(error.starts_with(&format!("at {path}")), "{error}");
}

#[test]
fn wrong_scripts_are_refused_with_their_path() {
    refused("\"version\": 1", "\"version\": 2", "version:");
    refused("\"version\": 1", "\"version\": 1, \"bpm\": 2", "bpm:");
    refused("\"id\": 7", "\"id\": 1", "contacts[1].id:");
    refused("\"at_s\": 0.3", "\"at_s\": 0.15", "contacts[0].events[1].at_s:");
    refused("\"for_s\": 0.2", "\"for_s\": 0.0", "contacts[0].events[1].for_s:");
    refused("\"force_n\": 10.0", "\"force_n\": -1.0", "contacts[0].events[0].force_n:");
    refused("\"kind\": \"leave\"", "\"kind\": \"go\"", "contacts[0].events[3]");
    refused("0.05,", "0.09,", "contacts[1].events[0].position_m:");
    let leave = script().contacts[0].events[3].clone();
    let mut script = script();
    script.contacts[0].events.insert(0, leave);
    script.contacts[0].events.truncate(1);
    let error = script.check().unwrap_err();
    assert!(matches!(error, RigError::Script { .. }), "{error}");
    assert!(error.to_string().contains("arrive or impact"), "{error}");
}

#[test]
fn random_scripts_keep_to_what_was_asked() {
    let limb = plate();
    let params =
        RandomScriptParams { duration_s: 30.0, ..RandomScriptParams::new(3, 0.02, (3.0, 15.0), 5) };
    let script = random_script(&limb, &params);
    assert_eq!(script, random_script(&limb, &params));
    let other = RandomScriptParams { seed: 6, ..params };
    assert_ne!(script, random_script(&limb, &other));
    let play = Play::new(&script, &limb).unwrap();
    let (mut most, mut n_moved) = (0, 0);
    let mut last: Vec<TrueContact> = Vec::new();
    for i in 0..3000 {
        let now = contacts(&play, f64::from(i) * 0.01);
        assert!(i >= 100 || now.is_empty(), "touched before the tare");
        most = most.max(now.len());
        for (k, a) in now.iter().enumerate() {
            assert!(a.force_n <= 15.0);
            let same = last.iter().find(|b| b.id == a.id);
            n_moved += usize::from(same.is_some_and(|b| b.position_m != a.position_m));
            for b in &now[..k] {
                let apart_m = (a.position_m - b.position_m).norm();
                assert!(apart_m > 0.02 - 1e-3, "{apart_m} m apart at {i}");
            }
        }
        last = now;
    }
    assert_eq!(most, 3);
    assert!(n_moved > 50, "{n_moved} slides' frames");
}

#[test]
fn what_is_pressed_by_hand_is_pressed() {
    let limb = plate();
    let handle = PressHandle::new();
    let other = handle.clone();
    let here = Point3::new(0.03, 0.03, 0.002);
    std::thread::spawn(move || other.set(vec![Pressed::normal(4, here, 6.0)])).join().unwrap();
    let contact = handle.pressed()[0].on(&limb).unwrap();
    assert_eq!((contact.id, contact.force_n), (4, 6.0));
    assert!((contact.position_m - Point3::new(0.03, 0.03, 0.0)).norm() < 1e-12);
    assert!(Pressed::normal(4, here, 0.0).on(&limb).is_none());
    assert!(Pressed::normal(4, here, f64::NAN).on(&limb).is_none());
}

#[test]
fn truth_comes_back_from_its_line() {
    let play = Play::new(&script(), &plate()).unwrap();
    let frame = TruthFrame {
        boot_id: 3,
        seq: 9,
        t_device_us: 12_345,
        t_s: 0.1 + 0.2,
        contacts: contacts(&play, 0.41),
        loads: vec![12.5, -0.1 - 0.2],
    };
    let mut line = Vec::new();
    frame.write_json_line(&mut line).unwrap();
    let text = String::from_utf8(line).unwrap();
    assert!(text.ends_with("}\n") && text.lines().count() == 1);
    assert_eq!(TruthFrame::from_json_line(&text).unwrap(), frame);
}
