//! A made-up limb that differs from its map, calibrated by presses.

use crate::limb;

use std::sync::Arc;

use hapdef_inverse::{
    Calibrated, CalibrationParams, InverseError, ModeMap, ModeScope, Press, RejectReason,
    ResponseMap, ResponseParams,
};
use limb::{Limb, N_GAUGES, fit, params, world};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

#[test]
fn gains_are_recovered() {
    let world = world();
    let limb = Limb { gains: vec![1.03, 0.97, 1.0, 1.05, 0.99, 0.96], warp: 0.0 };
    let fitted = fit(&world, &limb.presses(&world, 150, 1.0, 1), &params()).unwrap();
    for (found, gain) in fitted.info.gains.iter().zip(&limb.gains) {
        assert!((1.0 + found - gain).abs() < 0.01, "{found} {gain}");
    }
    let before = limb.error(&world, &world.map);
    let after = limb.error(&world, &fitted.map);
    assert!(after < 0.2 * before, "{before} {after}");
}

/// A gain that the prior of 3 % does not expect is reported.
#[test]
fn a_gain_beyond_its_prior_is_flagged() {
    let world = world();
    let limb = Limb { gains: vec![1.0, 1.0, 1.3, 1.0, 1.0, 1.0], warp: 0.0 };
    let fitted = fit(&world, &limb.presses(&world, 150, 1.0, 1), &params()).unwrap();
    let flagged: Vec<_> = fitted.info.beyond_prior.iter().map(|b| b.gauge).collect();
    assert_eq!(flagged, [Some(2)], "{:?}", fitted.info.gains);
}

#[test]
fn a_mode_is_recovered_and_changes_vectors_too() {
    let world = world();
    let params = ResponseParams::default();
    let skin = world.map.skin().clone();
    let field = |x: &Point3<f64>| Vector3::new(60.0 * x.y, 2.0 * (30.0 * x.x).sin(), 40.0 * x.z);
    let adjoint: Vec<Vector3<f64>> = (skin.nodes().iter())
        .flat_map(|x| (0..N_GAUGES).map(move |g| field(x) * (1.0 + 0.2 * g as f64)))
        .collect();
    let mode = ResponseMap::from_nodal(skin.clone(), N_GAUGES, &adjoint, &params).unwrap();
    let points = skin.subdivided_points();
    let values: Vec<_> = points.iter().flat_map(|p| world.map.vector(p)).collect();
    let subdivided = Arc::new(ResponseMap::from_subdivided(skin, N_GAUGES, &values).unwrap());
    let mut presses = Limb::plain().presses(&world, 150, 0.1, 2);
    for press in &mut presses {
        let h = mode.normal(&press.point);
        press.readings.iter_mut().zip(h).for_each(|(y, h)| *y += 0.4 * press.force_n * h);
    }
    let modes = [ModeMap { map: &mode, scope: ModeScope::Shared, prior_sd: 1.0 }];
    let params = CalibrationParams::new(vec![0.1; N_GAUGES]);
    for map in [&world.map, &subdivided] {
        let fitted = Calibrated::fit(map, &world.sites, &modes, &presses, &params).unwrap();
        let found = fitted.info.mode_coefficients[0][0];
        assert!((found - 0.4).abs() < 0.02, "{found}");
        // tangential forces: what a normal residual alone could not change
        let point = presses[0].point;
        let tangent = map.skin().tangents(&point)[0];
        let along = |map: &ResponseMap| map.vector(&point)[3].dot(&tangent);
        let expected = along(map) + found * along(&mode);
        assert!((along(&fitted.map) - expected).abs() < 0.05 * expected.abs().max(1.0));
    }
}

#[test]
fn the_residual_is_learned_and_its_error_falls_with_the_presses() {
    let world = world();
    let limb = Limb { warp: 0.1, ..Limb::plain() };
    let errors: Vec<f64> = [50, 150, 450]
        .map(|n| {
            let fitted = fit(&world, &limb.presses(&world, n, 0.2, 3), &params()).unwrap();
            limb.error(&world, &fitted.map)
        })
        .to_vec();
    let before = limb.error(&world, &world.map);
    assert!(
        errors[0] < before && errors[1] < 0.7 * errors[0] && errors[2] < 0.7 * errors[1],
        "{before} {errors:?}"
    );
}

#[test]
fn the_reported_error_is_that_of_other_presses() {
    let world = world();
    let limb = Limb { warp: 0.1, ..Limb::plain() };
    let fitted = fit(&world, &limb.presses(&world, 300, 1.0, 4), &params()).unwrap();
    let (mut squares, mut n) = (0.0, 0);
    for (site, point) in world.sites.points().iter().enumerate() {
        let x = world.map.skin().position(point);
        let truth = limb.response(&world, &x);
        for (g, (t, found)) in truth.iter().zip(fitted.map.normal(point)).enumerate() {
            let at = site * N_GAUGES * N_GAUGES + g * (N_GAUGES + 1);
            squares += (t - found).powi(2) / fitted.model_error.per_site[at];
            n += 1;
        }
    }
    let mean = squares / f64::from(n);
    assert!((0.4..2.5).contains(&mean), "mean square of standardised errors {mean}");
    let reported = fitted.info.relative_error;
    let found = limb.error(&world, &fitted.map);
    assert!(found < 1.3 * reported, "reported {reported}, found {found}");
}

#[test]
fn bad_presses_are_named_and_do_no_harm() {
    let world = world();
    let limb = Limb { warp: 0.05, ..Limb::plain() };
    let mut presses = limb.presses(&world, 300, 1.0, 6);
    let bad = [10, 77, 150, 222, 299];
    let good: Vec<Press> =
        (0..presses.len()).filter(|i| !bad.contains(i)).map(|i| presses[i].clone()).collect();
    let without = limb.error(&world, &fit(&world, &good, &params()).unwrap().map);
    for (k, &i) in bad.iter().enumerate() {
        match k % 3 {
            0 => presses[i].force_n *= 3.0,
            1 => presses[i].readings.reverse(),
            _ => presses[i].readings.iter_mut().for_each(|y| *y = -*y),
        }
    }
    let fitted = fit(&world, &presses, &params()).unwrap();
    let named: Vec<usize> = fitted.info.rejected.iter().map(|r| r.press).collect();
    assert!(bad.iter().all(|i| named.contains(i)), "{named:?}");
    assert!(named.len() <= bad.len() + 3, "{named:?}");
    assert!(matches!(fitted.info.rejected[0].reason, RejectReason::Outlier { .. }));
    let error = limb.error(&world, &fitted.map);
    assert!(error < 1.1 * without, "{error}, without them {without}, {named:?}");
}

#[test]
fn errors_of_the_press_position_are_allowed_for() {
    let world = world();
    let limb = Limb { warp: 0.05, ..Limb::plain() };
    let mut presses = limb.presses(&world, 250, 0.2, 7);
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let skin = world.map.skin();
    for press in &mut presses {
        let [t1, t2] = skin.tangents(&press.point);
        let [a, b]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
        let x = skin.position(&press.point) + (t1 * a + t2 * b) * 1e-3;
        let readings = press.readings.clone();
        *press = Press::at_position(skin, &x, 0.01, press.force_n, readings).unwrap();
    }
    let declared =
        CalibrationParams { position_sd_m: 1e-3, ..CalibrationParams::new(vec![0.2; N_GAUGES]) };
    let undeclared = CalibrationParams::new(vec![0.2; N_GAUGES]);
    let with = limb.error(&world, &fit(&world, &presses, &declared).unwrap().map);
    let without = limb.error(&world, &fit(&world, &presses, &undeclared).unwrap().map);
    assert!(with < without, "declared {with}, undeclared {without}");
    assert!(with < limb.error(&world, &world.map), "{with}");
}

#[test]
fn unusable_presses_are_refused() {
    let world = world();
    let presses = Limb::plain().presses(&world, 40, 1.0, 9);
    let found = fit(&world, &presses[..5], &params()).map(|_| ());
    assert_eq!(found, Err(InverseError::TooFewPresses { found: 5, needed: 12 }));
    let mut changed = presses.clone();
    changed[7].readings[2] = f64::NAN;
    let found = fit(&world, &changed, &params()).map(|_| ());
    assert!(
        matches!(found, Err(InverseError::PressReading { press: 7, gauge: 2, .. })),
        "{found:?}"
    );
    changed = presses.clone();
    changed[3].force_n = 0.0;
    let found = fit(&world, &changed, &params()).map(|_| ());
    assert_eq!(found, Err(InverseError::PressForce { press: 3, found: 0.0 }));
    for (factor, gauge) in [(-1.0, 3), (1e6, 0), (0.0, 5)] {
        changed = presses.clone();
        changed.iter_mut().for_each(|p| p.readings[gauge] *= factor);
        let found = fit(&world, &changed, &params()).map(|_| ());
        assert!(
            matches!(found, Err(InverseError::PressScale { gauge: g, .. }) if g == gauge),
            "{found:?}"
        );
    }
    let spot = vec![presses[0].clone(); 40];
    let found = fit(&world, &spot, &params()).map(|_| ());
    assert!(matches!(found, Err(InverseError::PressesInOneSpot { .. })), "{found:?}");
    let away = Point3::new(1.0, 0.0, 0.0);
    let found = Press::at_position(world.map.skin(), &away, 0.01, 1.0, vec![0.0; N_GAUGES]);
    assert!(matches!(found, Err(InverseError::PressOffSkin { .. })), "{found:?}");
}

#[test]
fn one_and_two_threads_give_the_same_bits() {
    let world = world();
    let presses = Limb::plain().presses(&world, 100, 1.0, 10);
    let on = |n_threads| {
        let params = CalibrationParams { n_threads, ..params() };
        let fitted = fit(&world, &presses, &params).unwrap();
        (fitted.info, fitted.model_error)
    };
    assert_eq!(on(1), on(2));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3))]

    /// Covariances have no negative variance in any direction.
    #[test]
    fn covariances_are_positive_semidefinite(seed in 0_u64..1000, n in 20_usize..120) {
        let world = world();
        let limb = Limb { warp: 0.08, ..Limb::plain() };
        let fitted = fit(&world, &limb.presses(&world, n, 1.0, seed), &params()).unwrap();
        for c in fitted.model_error.per_site.chunks_exact(N_GAUGES * N_GAUGES) {
            let c = nalgebra::DMatrix::from_row_slice(N_GAUGES, N_GAUGES, c);
            let trace = c.trace();
            let least = c.symmetric_eigenvalues().min();
            prop_assert!(least >= -1e-9 * trace, "{least} of {trace}");
        }
        let sds: Vec<f64> = fitted.info.next.iter().map(|p| p.relative_sd).collect();
        prop_assert!(sds.windows(2).all(|w| w[1] <= w[0]), "{sds:?}");
    }
}
