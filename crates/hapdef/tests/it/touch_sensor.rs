//! The simulated skin that a simulator of robots steps.

use hapdef::{OpenScene, TouchSensor, TouchSensorParams, scene::Scene};
use hapdef_live::TouchPhase;
use hapdef_rig::live::LimbLoads;
use nalgebra::{Point3, Vector3};

fn opened(name: &str) -> OpenScene {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/shin");
    Scene::open(format!("{folder}/{name}")).unwrap()
}

/// A press of 10 N is found where it is and as strong, a second sensor says the same to the last bit, and a force that
/// pulls does nothing.
#[test]
fn what_presses_is_found() {
    let scene = opened("demo.json");
    let limb = scene.limb();
    let node = limb.n_surface_nodes() / 2;
    let (place, inward) = (limb.skin.nodes[node], limb.directions[node]);
    let place: Point3<f64> = limb.mesh.position(place);
    let params = TouchSensorParams { tare_s: 0.3, ..TouchSensorParams::default() };
    let frames = || {
        let mut sensor = TouchSensor::new(&scene, &params).unwrap();
        let mut step = |force_n: f64| {
            let forces = [(place, inward * force_n)];
            sensor.step(&forces, LimbLoads::default()).unwrap()
        };
        let mut frames: Vec<_> = (0..400).map(|_| step(-5.0)).collect();
        assert_eq!(frames[399].phase, TouchPhase::Untouched);
        frames.extend((0..200).map(|i| step(10.0 * (f64::from(i) / 40.0).min(1.0))));
        frames
    };
    let found = frames();
    let last = &found[599];
    let [contact] = last.touch.contacts.as_slice() else {
        panic!("{:?}", last.touch.contacts);
    };
    assert!((contact.position_m - place).norm() < 2e-3, "{contact:?} {place}");
    assert!((contact.force_n - 10.0).abs() < 0.5, "{contact:?}");
    assert_eq!(found, frames());
}

/// A limb that carries its flange's load is not touched.
#[test]
fn what_loads_the_limb_is_no_contact() {
    let scene = opened("moving.json");
    let mut sensor = TouchSensor::new(&scene, &TouchSensorParams::default()).unwrap();
    for ms in 0..3000 {
        let share = (f64::from(ms - 1200) / 500.0).clamp(0.0, 1.0);
        let loads = LimbLoads {
            flange_force_n: Vector3::new(8.0, -3.0, 5.0) * share,
            specific_force_m_s2: Vector3::new(0.0, -4.0, 9.0) * share,
            ..LimbLoads::default()
        };
        let frame = sensor.step(&[], loads).unwrap();
        assert_ne!(frame.phase, TouchPhase::Touched, "{ms}: {:?}", frame.touch.contacts);
        if ms == 2999 {
            assert_eq!(frame.signals.len(), 9);
            let force_z = frame.signals.iter().find(|s| s.0.to_string() == "force_2").unwrap().1;
            assert!((force_z - 5.0).abs() < 0.6, "{force_z}");
            assert!(frame.raw_ue.iter().any(|ue| ue.abs() > 50.0), "{:?}", frame.raw_ue);
        }
    }
}
