//! Gains of a made-up limb that drift, followed by known touches.

use crate::world::{World, add_noise, draw_point};

use hapdef_inverse::{
    GainChange, InverseError, KnownTouch, Recalibration, RecalibrationParams, SkinPoint, TouchZero,
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const N_GAUGES: usize = 6;
const NOISE: f64 = 1.0;

fn world() -> World {
    World::new(N_GAUGES, 100, 7)
}

fn params() -> RecalibrationParams {
    RecalibrationParams::new(vec![NOISE; N_GAUGES])
}

fn forgetting_nothing() -> RecalibrationParams {
    RecalibrationParams { gain_drift_per_touch: 0.0, gain_drift_per_hour: 0.0, ..params() }
}

/// A touch of gauges with `gains` on a limb whose response differs from the map by `error`, per newton.
fn touch(
    world: &World,
    point: SkinPoint,
    force_n: f64,
    [gains, error]: [&[f64]; 2],
    rng: &mut ChaCha8Rng,
) -> KnownTouch {
    let mut readings = world.readings(&[(point, force_n)]);
    for (gauge, y) in readings.iter_mut().enumerate() {
        *y = *y * (1.0 + gains[gauge]) + error[gauge] * force_n;
    }
    add_noise(&mut readings, NOISE, rng);
    KnownTouch::against_normal(world.map.skin(), point, force_n, readings)
}

fn touches(world: &World, n: usize, gains: &[f64], seed: u64) -> Vec<KnownTouch> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let draw = |_| {
        let point = draw_point(world.map.skin(), &mut rng);
        let force_n = rng.random_range(5.0..30.0);
        touch(world, point, force_n, [gains, &[0.0; N_GAUGES]], &mut rng)
    };
    (0..n).map(draw).collect()
}

fn sds(change: &GainChange) -> Vec<f64> {
    (0..N_GAUGES).map(|i| change.covariance[i * (N_GAUGES + 1)].sqrt()).collect()
}

#[track_caller]
fn assert_near(change: &GainChange, gains: &[f64], most_sds: f64) {
    for ((found, gain), sd) in change.gains.iter().zip(gains).zip(sds(change)) {
        assert!((found - gain).abs() < most_sds * sd, "{found} ± {sd}, true {gain}");
    }
}

/// The same by least squares over all touches at once: (P⁻¹ + Σ Hᵀ R⁻¹ H) γ = Σ Hᵀ R⁻¹ (y − s).
fn at_once(world: &World, touches: &[KnownTouch], params: &RecalibrationParams) -> GainChange {
    let m = N_GAUGES;
    let mut information = DMatrix::identity(m, m) / params.gain_sd.powi(2);
    let mut sum = DVector::zeros(m);
    for touch in touches {
        let force_n = touch.force_n.norm();
        let s = DVector::from_vec(world.readings(&[(touch.point, force_n)]));
        let per_newton = world.map.vector(&touch.point);
        let per_newton = DMatrix::from_fn(m, 3, |i, axis| per_newton[i][axis]);
        let noise = DMatrix::identity(m, m) * NOISE * NOISE
            + &per_newton * per_newton.transpose() * touch.force_sd_n.powi(2);
        let weights = noise.try_inverse().unwrap();
        let h = DMatrix::from_diagonal(&s);
        information += &h * &weights * &h;
        sum += &h * weights * (DVector::from_column_slice(&touch.readings) - s);
    }
    let covariance = information.try_inverse().unwrap();
    let gains = &covariance * sum;
    GainChange { gains: gains.as_slice().to_vec(), covariance: covariance.as_slice().to_vec() }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn without_forgetting_the_order_is_nothing_and_all_at_once_is_the_same(
        seed in 0_u64..1000,
        n in 1_usize..20,
        turn in 0_usize..20,
        force_sd_n in 0.0..0.5,
        gains in proptest::collection::vec(-0.05..0.05, N_GAUGES),
    ) {
        let world = world();
        let mut touches = touches(&world, n, &gains, seed);
        touches.iter_mut().for_each(|touch| touch.force_sd_n = force_sd_n);
        let params = RecalibrationParams { refuse_p: 1e-300, ..forgetting_nothing() };
        let expected = at_once(&world, &touches, &params);
        for turn in [0, turn % n] {
            touches.rotate_left(turn);
            let mut state = Recalibration::new(params.clone()).unwrap();
            for touch in &touches {
                prop_assert!(state.update(&world.map, &[], touch).unwrap().is_accepted);
            }
            let found = state.change();
            let pairs = found.gains.iter().zip(&expected.gains);
            for (found, expected) in pairs.chain(found.covariance.iter().zip(&expected.covariance)) {
                prop_assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }

    #[test]
    fn the_covariance_stays_positive_and_shrinks_wherever_it_is_touched(
        seed in 0_u64..1000,
        n_places in 1_usize..6,
        error in 0.0..1.0,
        max_places in 1_usize..4,
    ) {
        let world = world();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let places = world.draw_points(n_places, 0.0, &mut rng);
        let params = RecalibrationParams { max_places, ..forgetting_nothing() };
        let mut state = Recalibration::new(params).unwrap();
        let map_error: Vec<f64> = (0..N_GAUGES * N_GAUGES)
            .map(|at| if at % (N_GAUGES + 1) == 0 { error * error } else { 0.3 * error * error })
            .collect();
        let mut before = sds(&state.change());
        for i in 0..40 {
            let point = places[i % n_places];
            let readings = world.readings(&[(point, 10.0)]);
            let touch = KnownTouch::against_normal(world.map.skin(), point, 10.0, readings);
            let info = state.update(&world.map, &map_error, &touch).unwrap();
            prop_assert!(info.is_accepted);
            let change = state.change();
            let covariance = DMatrix::from_row_slice(N_GAUGES, N_GAUGES, &change.covariance);
            prop_assert!(covariance.symmetric_eigenvalues().min() > 0.0);
            let now = sds(&change);
            let grows = now.iter().zip(&before).any(|(now, before)| *now > before * (1.0 + 1e-9));
            prop_assert!(!grows, "touch {i}: {before:?} {now:?}");
            before = now;
        }
    }
}

#[test]
fn gains_that_drift_are_followed() {
    let world = world();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut gains = [0.02, -0.03, 0.0, 0.01, -0.01, 0.04];
    let drift: Vec<f64> = (0..N_GAUGES).map(|_| rng.random_range(-3e-4..3e-4)).collect();
    let mut state = Recalibration::new(params()).unwrap();
    for _ in 0..200 {
        gains.iter_mut().zip(&drift).for_each(|(gain, drift)| *gain += drift);
        let point = draw_point(world.map.skin(), &mut rng);
        let force_n = rng.random_range(5.0..30.0);
        let touch = touch(&world, point, force_n, [&gains, &[0.0; N_GAUGES]], &mut rng);
        assert!(state.update(&world.map, &[], &touch).unwrap().is_accepted);
    }
    let change = state.change();
    assert_near(&change, &gains, 3.5);
    assert!(sds(&change).iter().all(|sd| *sd < 0.01), "{:?}", sds(&change));
    let map = change.map(&world.map).unwrap();
    let point = draw_point(world.map.skin(), &mut rng);
    for (gauge, (now, before)) in
        map.normal(&point).iter().zip(world.map.normal(&point)).enumerate()
    {
        assert!((now - before * (1.0 + change.gains[gauge])).abs() < 1e-9, "{now} {before}");
    }
}

/// However often one place is touched, the map's error there is not taken for a gain; what drifts shows all the same.
#[test]
fn one_place_shows_what_drifts_and_not_the_maps_error() {
    let world = world();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let point = draw_point(world.map.skin(), &mut rng);
    let s = world.map.normal(&point);
    let error: Vec<f64> = s.iter().map(|s| 0.04 * s).collect();
    let map_error: Vec<f64> =
        DMatrix::from_diagonal(&DVector::from_fn(N_GAUGES, |i, _| (0.04 * s[i]).powi(2)))
            .as_slice()
            .to_vec();
    let mut state = Recalibration::new(params()).unwrap();
    let mut press = |state: &mut Recalibration, gain: &dyn Fn(usize) -> f64| {
        for i in 0..60 {
            let gains = [gain(i); N_GAUGES];
            let touch = touch(&world, point, 25.0, [&gains, &error], &mut rng);
            assert!(state.update(&world.map, &map_error, &touch).unwrap().is_accepted);
        }
        state.change()
    };
    let first = press(&mut state, &|_| 0.0);
    assert_near(&first, &[0.0; N_GAUGES], 3.0);
    let strong: Vec<usize> = (0..N_GAUGES).filter(|&i| s[i].abs() > 4.0).collect();
    assert!(!strong.is_empty(), "{s:?}");
    assert!(strong.iter().all(|&i| sds(&first)[i] > 0.02), "{:?}", sds(&first));
    let second = press(&mut state, &|i| 5e-4 * i as f64);
    for i in strong {
        let moved = second.gains[i] - first.gains[i];
        assert!((moved - 0.03).abs() < 0.01, "gauge {i}: {moved}");
    }
}

#[test]
fn a_touch_that_does_not_fit_is_refused_and_changes_nothing() {
    let world = world();
    let mut state = Recalibration::new(params()).unwrap();
    let all = touches(&world, 20, &[0.02; N_GAUGES], 5);
    for touch in &all {
        assert!(state.update(&world.map, &[], touch).unwrap().is_accepted);
    }
    let before = state.change();
    let mut elsewhere = all[0].clone();
    elsewhere.point = all[7].point;
    elsewhere.force_n = -world.map.skin().normal(&elsewhere.point) * all[0].force_n.norm();
    let mut stronger = all[3].clone();
    stronger.force_n *= 1.5;
    for wrong in [elsewhere, stronger] {
        let info = state.update(&world.map, &[], &wrong).unwrap();
        assert!(!info.is_accepted && info.chi2 > info.limit && info.p_value < 1e-6, "{info:?}");
        assert_eq!((&info.gains_before, state.n_touches()), (&info.gains_after, 20));
        let worst = info.worst_gauge();
        assert!((info.innovation[worst] / info.innovation_sd[worst]).abs() > 4.0, "{info:?}");
    }
    assert_eq!(state.change(), before);
}

/// Readings above zeros of their own, which untouched frames show and which jump once.
#[test]
fn zeros_are_followed_and_begin_anew_where_they_jump() {
    let world = world();
    let gains = [0.03, 0.0, -0.02, 0.0, 0.01, 0.0];
    let mut state = Recalibration::new(params()).unwrap();
    let mut n_jumps = 0;
    for (i, mut touch) in touches(&world, 60, &gains, 6).into_iter().enumerate() {
        let zero = if i < 30 { 40.0 + i as f64 } else { -300.0 };
        touch.readings.iter_mut().for_each(|y| *y += zero);
        touch.zero = match i % 3 {
            0 => TouchZero::Untouched(vec![zero; N_GAUGES]),
            _ => TouchZero::Followed,
        };
        let info = state.update(&world.map, &[], &touch).unwrap();
        assert!(info.is_accepted, "touch {i}: {info:?}");
        n_jumps += usize::from(info.has_new_zeros);
    }
    assert_eq!(n_jumps, 1);
    assert_near(&state.change(), &gains, 3.5);
    let zeros = state.zeros();
    assert!(zeros.iter().all(|(zero, sd)| (zero + 300.0).abs() < 4.0 * sd), "{zeros:?}");
}

#[test]
fn a_touch_that_cannot_be_used_is_an_error() {
    let world = world();
    let mut state = Recalibration::new(params()).unwrap();
    let good = touches(&world, 1, &[0.0; N_GAUGES], 8).remove(0);
    let pulling = KnownTouch { force_n: -good.force_n, ..good.clone() };
    let short = KnownTouch { readings: vec![0.0; N_GAUGES - 1], ..good.clone() };
    let nan = KnownTouch { readings: vec![f64::NAN; N_GAUGES], ..good.clone() };
    let back = KnownTouch { hours_since: -1.0, ..good.clone() };
    for wrong in [pulling, short, nan, back] {
        assert!(state.update(&world.map, &[], &wrong).is_err(), "{wrong:?}");
    }
    let error = state.update(&world.map, &[0.0; 3], &good).unwrap_err();
    assert!(matches!(error, InverseError::Length { expected: 36, found: 3, .. }));
    assert!(Recalibration::new(RecalibrationParams::new(Vec::new())).is_err());
    assert!(Recalibration::new(RecalibrationParams { gain_sd: -1.0, ..params() }).is_err());
    assert!(state.clone().with_params(RecalibrationParams::new(vec![1.0; 5])).is_err());
    assert_eq!(state.n_touches(), 0);
}
