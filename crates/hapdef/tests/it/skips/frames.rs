//! What is left out of a frame: contacts are found as with it.

use hapdef::Run;
use hapdef::scene::{EstimatorSpec, SuperpositionSpec};
use hapdef::touch::{response_map, superposition};
use hapdef_inverse::{
    ContactEstimate, ContactEstimator, EstimatorParams, NoiseParams, ResponseMap, ScanSites,
    SkinPoint, Verdict,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::sync::Arc;

use super::{loaded, run_of};

fn estimate(
    run: &Run,
    spec: &SuperpositionSpec,
    map: &ResponseMap,
    readings: &[f64],
) -> ContactEstimate {
    let made = superposition(&run.scene, spec, map.clone()).unwrap();
    made.into_estimator().estimate(readings).unwrap()
}

/// Where one contact is wanted nothing looks for pairs, and where nothing rubs no shear is in the
/// noise: single contacts are found as by the estimator that has both.
#[test]
pub(crate) fn pair_search_and_friction_change_no_single_contact() {
    let out = tempfile::tempdir().unwrap();
    let mut run = run_of("placed.json", out.path());
    let limb = loaded(&run);
    let map = response_map(&limb, run.scene.contact.tip_radius_m, 2).unwrap();
    let EstimatorSpec::Superposition(spec) = run.scene.estimator.clone() else {
        panic!("placed.json chooses superposition")
    };
    for face in [150, 700, 1300] {
        let point = SkinPoint::new(map.skin(), face, [0.5, 0.3, 0.2]).unwrap();
        let readings: Vec<f64> = map.normal(&point).iter().map(|g| 20.0 * g).collect();
        run.scene.contact.max_contacts = 4;
        let full = estimate(&run, &spec, &map, &readings);
        let barely = SuperpositionSpec { friction: 1e-12, ..spec.clone() };
        let rubbed = estimate(&run, &barely, &map, &readings);
        run.scene.contact.max_contacts = 1;
        let lean = estimate(&run, &spec, &map, &readings);
        assert_eq!(full.contacts.len(), 1);
        for other in [&lean, &rubbed] {
            let (a, b) = (&full.contacts[0], &other.contacts[0]);
            assert!((a.position_m - b.position_m).norm() < 1e-9);
            assert!((a.force_n - b.force_n).abs() < 1e-9 * a.force_n);
        }
    }
}

/// Five gauges carry one contact: whatever the scene allows, one is looked for, no pair is scanned, and
/// single contacts are found as where no second is allowed.
#[test]
pub(crate) fn gauges_that_carry_one_contact_find_it_without_pairs() {
    let out = tempfile::tempdir().unwrap();
    let mut run = run_of("placed.json", out.path());
    run.scene.gauges.sites.truncate(5);
    let limb = loaded(&run);
    let map = response_map(&limb, run.scene.contact.tip_radius_m, 2).unwrap();
    let spec = run.scene.estimator.superposition();
    for face in [150, 700, 1300] {
        let readings = pressed(&map, face, 20.0);
        let [many, one] = [4, 1].map(|max_contacts| {
            run.scene.contact.max_contacts = max_contacts;
            estimate(&run, &spec, &map, &readings)
        });
        assert_eq!((many.info, many.contacts.len()), (one.info, 1));
        assert_eq!(many.info.most_contacts, 1);
        assert_eq!(many.contacts, one.contacts);
    }
}

/// The χ² test ends frames that nothing touches. Where something does, the contacts are those of an
/// estimator that searches every frame; where nothing does, that one is sure of no contact either.
#[test]
pub(crate) fn the_test_for_a_touch_changes_no_contact() {
    let out = tempfile::tempdir().unwrap();
    let run = run_of("placed.json", out.path());
    let limb = loaded(&run);
    let map = Arc::new(response_map(&limb, run.scene.contact.tip_radius_m, 2).unwrap());
    let [tested, always] = [EstimatorParams::default().touch_p, 1.0].map(|touch_p| {
        let params = EstimatorParams { touch_p, ..EstimatorParams::default() };
        let sites = Arc::new(ScanSites::farthest(map.skin(), 400).unwrap());
        let noise = NoiseParams::uniform(map.n_gauges(), 1.0);
        ContactEstimator::new(map.clone(), sites, noise, params).unwrap()
    });
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut noisy = |readings: Vec<f64>| -> Vec<f64> {
        let add = |r: f64| -> f64 {
            let draw: f64 = StandardNormal.sample(&mut rng);
            r + draw
        };
        readings.into_iter().map(add).collect()
    };
    for face in (0..20).map(|i| 70 * i) {
        let readings = noisy(pressed(&map, face, 20.0));
        let [a, b] = [&tested, &always].map(|e| e.estimate(&readings).unwrap());
        assert_eq!(a.contacts.len(), 1);
        assert_eq!(a, b);
    }
    for _ in 0..100 {
        let readings = noisy(vec![0.0; map.n_gauges()]);
        let [a, b] = [&tested, &always].map(|e| e.estimate(&readings).unwrap());
        assert_eq!((a.verdict, a.info.n_scanned), (Verdict::Untouched, 0));
        assert!(a.contacts.is_empty() && b.info.n_scanned > 0);
        assert_ne!(b.verdict, Verdict::Identified, "{b:?}");
    }
}

fn pressed(map: &ResponseMap, face: usize, force_n: f64) -> Vec<f64> {
    let point = SkinPoint::new(map.skin(), face, [0.5, 0.3, 0.2]).unwrap();
    map.normal(&point).iter().map(|g| force_n * g).collect()
}
