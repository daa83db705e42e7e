//! A bundle comes back as it was written, bit for bit, or is refused with a reason.

use crate::support;

use std::sync::Arc;

use hapdef_inverse::{ModeScope, ResponseMap, ResponseParams};
use hapdef_live::estimator::{Superposition, TouchEstimator};
use hapdef_live::{Bundle, BundleMode, LiveError, Touch};
use nalgebra::Vector3;
use support::world::{World, add_noise, barrel};
use support::{N_GAUGES, bundle, pressed, settings};

fn small() -> World {
    World::on(barrel(6, 3, false), 4, 20, 3)
}

#[test]
fn a_bundle_comes_back_as_it_was() {
    let world = World::new(N_GAUGES, 400, 5);
    let mut written = bundle(&world);
    let nodal: Vec<Vector3<f64>> = world.map.nodal().iter().map(|v| v * 0.1).collect();
    let skin = world.map.skin().clone();
    let params = ResponseParams::default();
    written.modes.push(BundleMode {
        map: ResponseMap::from_nodal(skin, N_GAUGES, &nodal, &params).unwrap(),
        scope: ModeScope::EachGauge,
        prior_sd: 7e-4,
    });
    written.scene_json = "{\"name\": \"barrel\"}".to_owned();
    written.calibration_json = Some("{\"n_presses\": 300}".to_owned());
    written.nets.insert("a.safetensors".to_owned(), vec![1, 2, 3]);
    written.info.settings.map_error = 0.1 + 1e-17;
    let bytes = written.to_bytes().unwrap();
    assert_eq!(bytes, written.to_bytes().unwrap());
    let read = Bundle::from_bytes(&bytes, "test").unwrap();
    assert_eq!(read.info, written.info);
    assert_eq!(read.scene_json, written.scene_json);
    assert_eq!(read.calibration_json, written.calibration_json);
    assert_eq!(read.nets, written.nets);
    assert_eq!(read.map().nodal(), written.map().nodal());
    assert_eq!(read.modes[0].map.nodal(), written.modes[0].map.nodal());
    assert_eq!(read.modes[0].scope, ModeScope::EachGauge);
    assert_eq!(read.to_bytes().unwrap(), bytes);
}

/// Contacts, covariances, χ²: all bits.
#[test]
fn its_estimates_are_those_of_the_map_it_was_made_of() {
    let world = World::new(N_GAUGES, 400, 5);
    let bytes = bundle(&world).to_bytes().unwrap();
    let read = Bundle::from_bytes(&bytes, "test").unwrap();
    let direct = settings().estimator(Arc::clone(&world.map), Vec::new()).unwrap();
    let (mut direct, mut bundled) = (Superposition::new(direct), read.superposition().unwrap());
    let (mut expected, mut found) = (Touch::default(), Touch::default());
    let mut n_contacts = 0;
    for readings in &pressed(&world, 440, 7)[395..] {
        direct.estimate(readings, &mut expected).unwrap();
        bundled.estimate(readings, &mut found).unwrap();
        assert_eq!(found, expected);
        n_contacts += found.contacts.len();
    }
    assert!(n_contacts >= 30, "{n_contacts}");
}

#[test]
fn site_errors_come_along() {
    let world = small();
    let mut written = bundle(&world);
    written.info.settings.n_sites = 10;
    written.site_error = (0..10 * 16).map(|i| f64::from(u8::from(i % 5 == 0))).collect();
    let read = Bundle::from_bytes(&written.to_bytes().unwrap(), "test").unwrap();
    assert_eq!(read.site_error, written.site_error);
    let mut readings = vec![0.0; 4];
    let mut rng = rand::SeedableRng::seed_from_u64(1);
    add_noise(&mut readings, 30.0, &mut rng);
    let (a, b) = (read.contact_estimator(), written.contact_estimator());
    assert_eq!(a.unwrap().estimate(&readings).unwrap(), b.unwrap().estimate(&readings).unwrap());
}

fn is_refused(bytes: &[u8]) -> bool {
    matches!(
        Bundle::from_bytes(bytes, "test"),
        Err(LiveError::NotABundle { .. }
            | LiveError::BundleDamaged { .. }
            | LiveError::BundleVersion { .. })
    )
}

/// One bit of every byte, a different one from byte to byte, and every length.
#[test]
fn no_damage_goes_unnoticed() {
    let bytes = bundle(&small()).to_bytes().unwrap();
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        assert!(is_refused(&damaged), "byte {at} of {}", bytes.len());
    }
    for len in (0..bytes.len()).step_by(7) {
        assert!(is_refused(&bytes[..len]), "{len} of {} bytes", bytes.len());
    }
    assert!(is_refused(&[bytes.clone(), vec![0]].concat()));
}

#[test]
fn another_version_names_both_and_the_remedy() {
    let bytes = bundle(&small()).to_bytes().unwrap();
    let (head, rest) = bytes.split_at(8);
    let len = u64::from_le_bytes(head.try_into().unwrap()) as usize;
    let text = String::from_utf8(rest[..len].to_vec()).unwrap();
    let header: serde_json::Value = serde_json::from_str(&text).unwrap();
    let entry = header["__metadata__"]["hapdef.bundle"].as_str().unwrap();
    let json = entry.split_once(' ').unwrap().1;
    let later = json.replacen("\"version\":2", "\"version\":3", 1);
    let entry_of = |json: &str| {
        let entry = format!("{} {json}", blake3::hash(json.as_bytes()).to_hex());
        serde_json::to_string(&entry).unwrap()
    };
    let text = text.replacen(&entry_of(json), &entry_of(&later), 1);
    let changed = [head, text.as_bytes(), &rest[len..]].concat();
    let error = Bundle::from_bytes(&changed, "a.hapdef").unwrap_err();
    let words = error.to_string();
    assert!(matches!(error, LiveError::BundleVersion { found: 3, expected: 2, .. }), "{words}");
    assert!(words.contains("a.hapdef") && words.contains("make it anew"), "{words}");
}

#[test]
fn files_that_are_none_say_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let missing = Bundle::read(&folder.path().join("no.hapdef")).unwrap_err();
    assert!(missing.to_string().contains("hapdef bundle SCENE"), "{missing}");
    let path = folder.path().join("scene.json");
    std::fs::write(&path, "{\"name\": \"shin\"}").unwrap();
    let other = Bundle::read(&path).unwrap_err();
    assert!(matches!(other, LiveError::NotABundle { .. }), "{other}");
}
