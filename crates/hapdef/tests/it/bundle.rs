//! A scene's bundle finds what the scene's own estimator finds, bit for bit, without the scene.

use std::path::{Path, PathBuf};

use hapdef::touch::{
    BundleRequest, Calibration, EstimatorKind, SearchPlace, Touch, TouchEstimator, live_estimator,
    make_bundle, touch_estimator,
};
use hapdef::{Limb, Profile, Progress, Run};
use hapdef_inverse::SkinPoint;
use hapdef_live::Bundle;

fn placed() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/placed.json")
}

fn run_of(scene: &Path, out: &Path) -> (Run, Limb) {
    let run = Run::new(scene, Profile::quick(), out, 2, Progress::silent()).unwrap();
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    (run, limb)
}

/// Made, written and read again.
fn through_bytes(run: &Run, limb: &Limb) -> Bundle {
    let text = std::fs::read_to_string(placed()).unwrap();
    let bundle = make_bundle(run, limb, text.clone(), &BundleRequest::default()).unwrap();
    let read = Bundle::from_bytes(&bundle.to_bytes().unwrap(), "test").unwrap();
    assert_eq!(read.scene_json, text);
    read
}

/// Readings of presses at some faces, with something like noise.
fn readings(bundle: &Bundle) -> Vec<Vec<f64>> {
    let map = bundle.map();
    let press = |face: usize, force_n: f64| -> Vec<f64> {
        let point = SkinPoint::new(map.skin(), face, [0.5, 0.3, 0.2]).unwrap();
        map.normal(&point).iter().map(|g| g * force_n).collect()
    };
    let sum = |(i, (a, b)): (usize, (Vec<f64>, Vec<f64>))| {
        let wobble = |g: usize| 0.5 * ((7 * i + 3 * g) as f64).sin();
        let pairs = a.iter().zip(&b).enumerate();
        pairs.map(|(g, (a, b))| a + b + wobble(g)).collect()
    };
    let faces = [(100, 1200), (7, 900), (512, 40), (300, 1000)];
    let both = faces.map(|(a, b)| (press(a, 20.0), press(b, 6.0)));
    both.into_iter().enumerate().map(sum).collect()
}

#[track_caller]
fn same(readings: &[Vec<f64>], mut a: impl TouchEstimator, mut b: Box<dyn TouchEstimator>) {
    let (mut found, mut expected) = (Touch::default(), Touch::default());
    let mut n = 0;
    for readings in readings {
        a.estimate(readings, &mut found).unwrap();
        b.estimate(readings, &mut expected).unwrap();
        assert_eq!(found, expected);
        n += found.contacts.len();
    }
    assert!(n > 0);
}

#[test]
fn a_bundle_stands_for_its_scene() {
    let out = tempfile::tempdir().unwrap();
    let (run, limb) = run_of(&placed(), out.path());
    let bundle = through_bytes(&run, &limb);
    let frames = readings(&bundle);
    same(&frames, bundle.superposition().unwrap(), touch_estimator(&run, &limb).unwrap());
    let stream: Vec<Vec<f64>> = frames.iter().flat_map(|f| vec![f.clone(); 150]).collect();
    let place = SearchPlace::Here;
    let followed = live_estimator(&run, &limb, EstimatorKind::Tracking, place).unwrap();
    same(&stream, bundle.tracking(place).unwrap(), followed);
}

#[test]
fn a_calibrated_scene_takes_its_calibration_along() {
    let out = tempfile::tempdir().unwrap();
    let (run, limb) = run_of(&placed(), out.path());
    let plain = through_bytes(&run, &limb);
    let n_sites = 100;
    let error = |i: usize| if i.is_multiple_of(11) { 1e-3 } else { 0.0 };
    let adjoint = plain.map().nodal().into_iter().map(|v| (v * 1.02).cast().into());
    let calibration = Calibration {
        version: 1,
        scene: run.scene.name.clone(),
        deck_hash: limb.deck_hash.clone(),
        presses_hash: String::new(),
        n_presses: 40,
        n_used: 40,
        relative_error: 0.01,
        relative_error_before: 0.1,
        noise_ue: 1.0,
        n_gauges: 10,
        n_sites,
        adjoint_ue_per_n: adjoint.collect(),
        site_error: (0..n_sites * 100).map(|i| error(i % 100)).collect(),
        place_factor: 1.4,
        since: None,
    };
    let path = out.path().join("calibration.json");
    calibration.write(&path).unwrap();
    let text = std::fs::read_to_string(placed()).unwrap();
    let mut scene: serde_json::Value = serde_json::from_str(&text).unwrap();
    scene["estimator"]["calibration"] = path.to_str().unwrap().into();
    let deck = placed().with_file_name("shin.inp.gz").canonicalize().unwrap();
    scene["geometry"]["solid_deck"] = deck.to_str().unwrap().into();
    let scene_path = out.path().join("scene.json");
    std::fs::write(&scene_path, scene.to_string()).unwrap();
    let (run, limb) = run_of(&scene_path, out.path());
    let bundle = through_bytes(&run, &limb);
    assert!(bundle.calibration_json.as_ref().unwrap().contains("\"n_presses\":40"));
    let frames = readings(&bundle);
    same(&frames, bundle.superposition().unwrap(), touch_estimator(&run, &limb).unwrap());
}
