//! The scene that `cargo xtask demo --live` shows: its calibration is that of its rig.

use std::path::{Path, PathBuf};

use hapdef::stages::real_limb;
use hapdef::touch::{Touch, touch_estimator};
use hapdef::{Limb, Profile, Progress, Run};
use hapdef_rig::RealLimb;

/// Nodes between two presses, a prime to the number around the limb, and the force, N.
const STRIDE: usize = 97;
const FORCE_N: f64 = 15.0;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin").join(name)
}

/// Single presses all over the rig, the step of its converter left out: with the calibration they are found as
/// one contact where they are, which the computed response does not do.
#[test]
fn presses_of_the_rig_are_one_contact_each_with_the_calibration() {
    let out = tempfile::tempdir().unwrap();
    let [demo, placed] = ["demo.json", "placed.json"].map(|scene| opened(scene, out.path()));
    let specs = [&demo, &placed].map(|(run, _)| serde_json::to_value(&run.scene.rig).unwrap());
    assert_eq!(specs[0], specs[1], "one rig stands for both scenes");
    let real = real_limb(&demo.0, &demo.1, &demo.1.sites).unwrap();
    let [demo, placed] = [demo, placed].map(|(run, limb)| found(&run, &limb, &real));
    assert!(demo.right > 0.97, "{demo:?}");
    assert!(demo.median_mm < 0.6, "{demo:?}");
    assert!(placed.right < demo.right, "{placed:?}");
    assert!(placed.median_mm > 3.0 * demo.median_mm, "{placed:?}");
}

/// What is found of the presses.
#[derive(Debug)]
struct Found {
    /// Share of them that is found as one contact.
    right: f64,
    /// Median distance of the strongest contact, mm.
    median_mm: f64,
}

fn opened(scene: &str, out: &Path) -> (Run, Limb) {
    let run = Run::new(&fixture(scene), Profile::quick(), out, 2, Progress::silent()).unwrap();
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    (run, limb)
}

fn found(run: &Run, limb: &Limb, real: &RealLimb) -> Found {
    let mut estimator = touch_estimator(run, limb).unwrap();
    let (mut touch, mut n_one, mut misses_mm) = (Touch::default(), 0, Vec::new());
    let points = limb.surface_points();
    for node in (0..points.len()).step_by(STRIDE) {
        let unit = real.response_ue_per_n(&points[node], &limb.directions[node]);
        let readings: Vec<f64> = unit.unwrap().iter().map(|g| g * FORCE_N).collect();
        estimator.estimate(&readings, &mut touch).unwrap();
        n_one += usize::from(touch.contacts.len() == 1);
        let miss = |c: &hapdef::touch::Contact| (c.position_m - points[node]).norm() * 1e3;
        misses_mm.push(touch.contacts.first().map_or(f64::INFINITY, miss));
    }
    misses_mm.sort_by(f64::total_cmp);
    Found {
        right: f64::from(n_one as u32) / misses_mm.len() as f64,
        median_mm: misses_mm[misses_mm.len() / 2],
    }
}
