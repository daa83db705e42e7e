//! The regions that a calibration reports, against presses that it has not seen.

use crate::limb;
use crate::world;

use std::sync::Arc;

use hapdef_inverse::{
    CHI2_95, Calibrated, ContactEstimator, EstimatorParams, ModelError, NoiseParams, Verdict,
};
use limb::{Limb, N_GAUGES, fit, params};
use world::World;

fn estimator(world: &World, fitted: &Calibrated, place_factor: f64) -> ContactEstimator {
    let noise = NoiseParams {
        model_error: ModelError { place_factor, ..fitted.model_error.clone() },
        ..NoiseParams::uniform(N_GAUGES, 1.0)
    };
    let params = EstimatorParams { max_contacts: 1, ..EstimatorParams::default() };
    let (map, sites) = (Arc::new(fitted.map.clone()), world.sites.clone());
    ContactEstimator::new(map, sites, noise, params).unwrap()
}

/// Of 600 presses that no calibration has seen, 92 to 98 % lie in the regions that are reported as 95 %.
#[test]
fn confidence_regions_hold_presses_that_were_not_seen() {
    let world = limb::world();
    let limb = Limb { warp: 0.15, ..Limb::plain() };
    let fitted = fit(&world, &limb.presses(&world, 300, 1.0, 3), &params()).unwrap();
    let factor = fitted.model_error.place_factor;
    let estimator = estimator(&world, &fitted, factor);
    let (skin, mut inside, mut all) = (world.map.skin(), 0, 0);
    for press in limb.presses(&world, 600, 1.0, 4) {
        let found = estimator.estimate(&press.readings).unwrap();
        if let ([one], Verdict::Identified) = (&found.contacts[..], found.verdict) {
            let truth = skin.position(&press.point);
            let distance_2 = one.distance_2(skin, &truth, 0.0).unwrap();
            (inside, all) = (inside + usize::from(distance_2 <= CHI2_95), all + 1);
        }
    }
    let share = inside as f64 / f64::from(all);
    println!("{share} of {all} with a factor of {factor}");
    assert!(all > 500 && (0.92..=0.98).contains(&share), "{share} of {all}");
}

#[test]
fn a_factor_of_places_changes_only_what_is_reported() {
    let world = limb::world();
    let limb = Limb::plain();
    let fitted = fit(&world, &limb.presses(&world, 150, 1.0, 1), &params()).unwrap();
    let [plain, wide] = [1.0, 4.0].map(|factor| estimator(&world, &fitted, factor));
    for press in limb.presses(&world, 20, 1.0, 5) {
        let [plain, wide] = [&plain, &wide].map(|e| e.estimate(&press.readings).unwrap());
        assert_eq!(plain.verdict, wide.verdict);
        for (a, b) in plain.contacts.iter().zip(&wide.contacts) {
            assert_eq!((a.position_m, a.force_n), (b.position_m, b.force_n));
            let scale = [[4.0, 4.0, 2.0], [4.0, 4.0, 2.0], [2.0, 2.0, 1.0]];
            for (p, q) in (0..9).map(|k| (k / 3, k % 3)) {
                let wanted = scale[p][q] * a.covariance[(p, q)];
                let miss = (b.covariance[(p, q)] - wanted).abs();
                assert!(miss <= 1e-12 * wanted.abs(), "{p}, {q}");
            }
        }
        assert_eq!(plain.joint_covariance.len(), wide.joint_covariance.len());
        assert!((wide.joint_covariance[0] / plain.joint_covariance[0] - 4.0).abs() < 1e-9);
    }
}

#[test]
fn presses_are_held_out_where_they_tell_a_quantile() {
    let parts = [12, 39, 40, 300, 600, 1000, 3000].map(Calibrated::n_refits);
    assert_eq!(parts, [0, 0, 10, 10, 5, 3, 0]);
}
