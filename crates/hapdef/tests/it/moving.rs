//! A limb on a robot that moves: loads that are no contacts are learned, and beside them contacts are found.

use hapdef::OpenScene;
use hapdef::scene::Scene;
use hapdef::touch::{
    BundleRequest, EstimatorKind, LearnedLoads, SearchPlace, make_bundle, response_with_loads,
};
use hapdef_live::{Bundle, TouchPhase};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/shin/moving.json");

/// The bundled moving limb, its loads in `learned`.
fn opened(learned: Option<&std::path::Path>) -> OpenScene {
    let scene = Scene::open(SCENE).unwrap();
    let mut loads = scene.scene().loads.clone().unwrap();
    loads.learned = learned.map(Into::into);
    scene.with_scene(Scene { loads: Some(loads), ..scene.scene().clone() }).unwrap()
}

/// What is learned of half a minute of motion is a wrench of six and what of weight along three axes shows above the noise, and in ten seconds of
/// another motion no frame has a contact, and no phase is unknown. With presses one is found where it is.
#[test]
fn contacts_are_found_beside_learned_loads() {
    let unlearned = opened(None);
    let mut frames = unlearned.untouched_source(Some(30.0)).unwrap().raw_frames(None).unwrap();
    assert_eq!(frames.len(), 30_000);
    frames.iter_mut().for_each(|frame| frame.signals.clear());
    let learned = LearnedLoads::learn(unlearned.scene(), &frames, 200, 1.0, 2.0).unwrap();
    let strengths_ue = learned.strengths_ue();
    assert!((6..=9).contains(&strengths_ue.len()), "{strengths_ue:?}");
    assert!(strengths_ue[0] > 200.0 && strengths_ue[5] > 10.0, "{strengths_ue:?}");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("loads.json");
    learned.write(&file).unwrap();
    let scene = opened(Some(&file));
    assert_eq!(LearnedLoads::read(&file, scene.scene()).unwrap(), learned);

    let tracking = || scene.estimator(Some(EstimatorKind::Tracking), SearchPlace::Here).unwrap();
    let untouched = scene.untouched_source(Some(14.0)).unwrap();
    let (mut n_frames, mut n_touched, mut n_unknown) = (0, 0, 0);
    for frame in untouched.boxed_contacts(tracking()).unwrap() {
        // loads begin at 4 s
        if frame.t_device_us < 4_000_000 {
            continue;
        }
        n_frames += 1;
        n_touched += usize::from(frame.touch.contacts.iter().any(|c| c.force_n > 0.5));
        n_unknown += usize::from(matches!(frame.phase, TouchPhase::Unknown(_)));
    }
    assert_eq!((n_frames, n_touched, n_unknown), (10_000, 0, 0));
}

/// An inertial unit and a sensor at the flange, gains off by 2 % and noisy, leave fewer loads unknown than there are without
/// them, and weak ones: what they take off is taken off live, too, and no untouched frame has a contact.
#[test]
fn measured_loads_are_taken_off() {
    let unlearned = opened(None);
    let frames = unlearned.untouched_source(Some(30.0)).unwrap().raw_frames(None).unwrap();
    let learned = LearnedLoads::learn(unlearned.scene(), &frames, 200, 1.0, 2.0).unwrap();
    assert_eq!(learned.signals.len(), 9);
    let rest_ue: f64 = learned.strengths_ue().iter().map(|ue| ue * ue).sum::<f64>().sqrt();
    assert!(learned.sd.len() <= 3 && rest_ue < 10.0, "{:?}", learned.strengths_ue());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("loads.json");
    learned.write(&file).unwrap();
    let scene = opened(Some(&file));
    let tracking = scene.estimator(Some(EstimatorKind::Tracking), SearchPlace::Here).unwrap();
    let untouched = scene.untouched_source(Some(14.0)).unwrap();
    let frames = untouched.boxed_contacts(tracking).unwrap().filter(|f| f.t_device_us >= 4_000_000);
    let (mut n_touched, mut largest_ue) = (0, 0.0_f64);
    for frame in frames {
        n_touched += usize::from(frame.touch.contacts.iter().any(|c| c.force_n > 0.5));
        largest_ue = frame.tared_ue.iter().fold(largest_ue, |most, ue| most.max(ue.abs()));
    }
    assert_eq!(n_touched, 0);
    assert!(largest_ue < 30.0, "{largest_ue} µε");
    let request = BundleRequest::default();
    let made = make_bundle(scene.run(), scene.limb(), "{}".into(), &request).unwrap();
    let read = Bundle::from_bytes(&made.to_bytes().unwrap(), "measured.hapdef").unwrap();
    assert_eq!((read.given.signals.len(), &read.given), (9, &made.given));
}

/// Without `learned` the responses are computed, each with the map's error: one load more for every gauge.
#[test]
fn computed_loads_have_the_error_of_the_map() {
    let scene = opened(None);
    let (_, loads) = response_with_loads(scene.run(), scene.limb()).unwrap();
    assert_eq!(loads.len(), 9 + 16);
    let strength = |row: &[f64]| row.iter().map(|v| v * v).sum::<f64>().sqrt();
    let force: Vec<f64> = loads.response.chunks_exact(16).take(3).map(strength).collect();
    assert!(force.iter().all(|ue| (1.0..100.0).contains(ue)), "{force:?} µε/N");
}

/// A robot's bundle has the loads that the scene learned.
#[test]
fn a_bundle_has_the_loads() {
    let scene = Scene::open(SCENE).unwrap();
    let request = BundleRequest::default();
    let made = make_bundle(scene.run(), scene.limb(), "{}".into(), &request).unwrap();
    let read = Bundle::from_bytes(&made.to_bytes().unwrap(), "moving.hapdef").unwrap();
    assert_eq!(read.loads, made.loads);
    assert!((6..=9).contains(&read.loads.len()), "{}", read.loads.len());
    assert_eq!(read.contact_estimator().unwrap().loads(), &made.loads);
}
