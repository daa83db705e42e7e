//! Bad frames, bad layouts, contacts in bad places: an answer or a typed error, never a panic, a
//! NaN, or a run without end.

use crate::world;

use std::time::Instant;

use hapdef_inverse::{
    ContactEstimate, ContactEstimator, EstimatorParams, InverseError, ModelError, NoiseParams,
    ResponseMap, ResponseParams, ScanSites, SkinPoint, Verdict, WhyNot, single_bounds,
};
use nalgebra::Vector3;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;
use world::World;

#[track_caller]
fn check_numbers(e: &ContactEstimate) {
    for c in &e.contacts {
        assert!(c.position_m.iter().all(|v| v.is_finite()), "{c:?}");
        assert!(c.force_n.is_finite() && c.force_n >= 0.0, "{c:?}");
        assert!(c.force_vector_n.iter().all(|v| v.is_finite()), "{c:?}");
        assert!(c.covariance.iter().all(|v| v.is_finite()), "{c:?}");
        assert!((0..3).all(|i| c.covariance[(i, i)] >= 0.0), "{c:?}");
    }
    assert!(e.joint_covariance.iter().all(|v| v.is_finite()));
    assert!(e.residual.iter().all(|v| v.is_finite()));
    assert!(e.chi2.is_finite() && e.chi2 >= 0.0 && (0.0..=1.0).contains(&e.p_value));
    assert!(e.runner_ups.iter().all(|r| r.delta_cost.is_finite()));
    let if_two = e.if_two.iter().flat_map(|t| [t.force_sd_n, t.position_sd_m]);
    assert!(if_two.into_iter().all(|sd| sd.is_finite() && sd >= 0.0));
}

fn small() -> (World, ContactEstimator) {
    let world = World::new(10, 300, 5);
    let estimator = world.estimator(NoiseParams::uniform(10, 1.0), EstimatorParams::default());
    (world, estimator)
}

fn rim_point(world: &World) -> SkinPoint {
    let skin = world.map.skin();
    let y = |p: &SkinPoint| skin.position(p).y;
    let points = skin.node_points();
    let lowest = points.into_iter().flatten();
    lowest.min_by(|a, b| y(a).total_cmp(&y(b))).unwrap()
}

#[test]
fn two_contacts_merge() {
    let (world, estimator) = small();
    let skin = world.map.skin();
    let start = world.draw_points(1, 0.0, &mut ChaCha8Rng::seed_from_u64(3))[0];
    let [t, _] = skin.tangents(&start);
    let mut merged_n = 0.0;
    for gap_mm in [20.0, 10.0, 5.0, 2.0, 1.0, 0.1, 1e-3, 1e-6, 0.0] {
        let step = t * (gap_mm * 1e-3);
        let other = skin.walk(&start, &step, hapdef_inverse::AtWall::Slide).point;
        let y = world.readings(&[(start, 10.0), (other, 12.0)]);
        let found = estimator.estimate(&y).unwrap();
        check_numbers(&found);
        merged_n = found.contacts.iter().map(|c| c.force_n).sum();
        let warm = &mut ContactEstimate::default();
        let points = [start, other];
        estimator.refine_into(&y, &points, &mut estimator.scratch(), warm).unwrap();
        check_numbers(warm);
    }
    assert!((merged_n - 22.0).abs() < 0.1, "{merged_n} N of 22");
}

#[test]
fn a_contact_on_the_rim_is_found() {
    let (world, estimator) = small();
    let rim = rim_point(&world);
    let found = estimator.estimate(&world.readings(&[(rim, 20.0)])).unwrap();
    check_numbers(&found);
    let miss = found.contacts[0].position_m - world.map.skin().position(&rim);
    assert!(miss.norm() < 1e-4, "{} mm", miss.norm() * 1e3);
}

#[test]
fn forces_over_eight_decades() {
    let (world, estimator) = small();
    let point = world.draw_points(1, 0.0, &mut ChaCha8Rng::seed_from_u64(8))[0];
    for exponent in -3..=5 {
        let force_n = 10.0_f64.powi(exponent);
        let found = estimator.estimate(&world.readings(&[(point, force_n)])).unwrap();
        check_numbers(&found);
        if force_n >= 10.0 {
            let n: f64 = found.contacts.iter().map(|c| c.force_n).sum();
            assert!((n / force_n - 1.0).abs() < 1e-3, "{n} N of {force_n}");
        }
    }
}

/// Beside the map's error alone every force is known to the same share of it.
#[test]
fn the_doubt_of_a_force_grows_with_it() {
    let world = World::new(10, 300, 5);
    let mut noise = NoiseParams::uniform(10, 1e-3);
    noise.model_error.relative = 0.03;
    let estimator = world.estimator(noise, EstimatorParams::default());
    let point = world.draw_points(1, 0.0, &mut ChaCha8Rng::seed_from_u64(8))[0];
    let shares = [1e2, 1e3, 1e5].map(|force_n| {
        let readings = world.readings(&[(point, force_n)]);
        let found = estimator.estimate(&readings).unwrap();
        let (sheared, _) = estimator.refine_shear(&readings, &[point], 0.5).unwrap();
        let along = sheared[0].force_vector_n.try_normalize(0.0).unwrap();
        let of_vector = along.dot(&(sheared[0].force_covariance_n2 * along)).sqrt();
        let own = found.contacts[0].covariance[(2, 2)].sqrt();
        [own, found.if_two[0].force_sd_n, of_vector].map(|sd| sd / force_n)
    });
    for [least, most] in [[shares[0], shares[1]], [shares[1], shares[2]]] {
        for (a, b) in least.into_iter().zip(most) {
            assert!((a / b - 1.0).abs() < 0.02, "{shares:?}");
        }
    }
}

#[test]
fn readings_that_are_not_finite_are_refused_by_gauge() {
    let (_, estimator) = small();
    for found in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let mut y = vec![1.0; 10];
        y[7] = found;
        let error = estimator.estimate(&y).unwrap_err();
        assert!(matches!(error, InverseError::Reading { gauge: 7, .. }), "{error}");
    }
    let expected = InverseError::Length { what: "the readings", expected: 10, found: 3 };
    assert_eq!(estimator.estimate(&[0.0; 3]).unwrap_err(), expected);
}

#[test]
fn dead_gauges_are_not_looked_at_and_covariances_grow() {
    let (world, estimator) = small();
    let point = world.draw_points(1, 0.0, &mut ChaCha8Rng::seed_from_u64(8))[0];
    let mut y = world.readings(&[(point, 20.0)]);
    let full = estimator.estimate(&y).unwrap();
    let mut live = vec![true; 10];
    for n_dead in 1..=8 {
        let gauge = (3 * n_dead) % 10;
        live[gauge] = false;
        y[gauge] = f64::NAN;
        if n_dead == 8 {
            let error = estimator.masked(&live).unwrap_err();
            let (n_live, needed) = (2, 3);
            assert_eq!(error, InverseError::TooFewGauges { n_live, needed });
            break;
        }
        let masked = estimator.masked(&live).unwrap();
        assert_eq!(masked.most_contacts(), (10 - n_dead) / 3);
        let found = masked.estimate(&y).unwrap();
        check_numbers(&found);
        let warm = &mut ContactEstimate::default();
        masked.refine_into(&y, &[point], &mut masked.scratch(), warm).unwrap();
        let area = |e: &ContactEstimate| e.contacts[0].covariance.determinant();
        assert!(area(warm) > area(&full), "{n_dead} dead");
    }
}

/// A map whose gauges are those of a world, changed by `change` (gauge, value).
fn changed(
    world: &World,
    change: impl Fn(usize, Vector3<f64>) -> Vector3<f64>,
) -> ContactEstimator {
    let skin = world.map.skin().clone();
    let n = world.gauges.len();
    let adjoint: Vec<_> = skin
        .nodes()
        .iter()
        .flat_map(|x| (0..n).map(|g| change(g, world.gauges[g].response(x))).collect::<Vec<_>>())
        .collect();
    let map = ResponseMap::from_nodal(skin, n, &adjoint, &ResponseParams::default()).unwrap();
    let sites = ScanSites::farthest(map.skin(), 300).unwrap();
    let (map, sites) = (Arc::new(map), Arc::new(sites));
    let noise = NoiseParams::uniform(n, 1.0);
    ContactEstimator::new(map, sites, noise, EstimatorParams::default()).unwrap()
}

#[track_caller]
fn check_layout(world: &World, estimator: &ContactEstimator) {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for k in 1..=3 {
        let points = world.draw_points(k, 0.012, &mut rng);
        let mut y = vec![0.0; world.gauges.len()];
        for point in &points {
            for (y, g) in y.iter_mut().zip(estimator.map().normal(point)) {
                *y += 15.0 * g;
            }
        }
        world::add_noise(&mut y, 1.0, &mut rng);
        check_numbers(&estimator.estimate(&y).unwrap());
    }
}

#[test]
fn strange_layouts() {
    let world = World::new(10, 300, 5);
    check_layout(&world, &changed(&world, |g, v| if g == 4 { v * 0.0 } else { v }));
    check_layout(&world, &changed(&world, |g, v| v * 10.0_f64.powi(g as i32 - 5)));
    let twins =
        World { gauges: (0..10).map(|g| world.gauges[g / 2].clone()).collect(), ..world.clone() };
    check_layout(&twins, &changed(&twins, |_, v| v));
    let same = World { gauges: vec![world.gauges[0].clone(); 10], ..world.clone() };
    check_layout(&same, &changed(&same, |_, v| v));
    let blind = changed(&world, |_, v| v * 0.0);
    check_layout(&world, &blind);
    let bounds = single_bounds(&blind, 10.0).unwrap();
    assert!(bounds.iter().all(Option::is_none));
}

/// Gauges that see nothing, and twins, carry no contact, and readings that no contact makes are
/// neither a contact's nor nothing.
#[test]
fn only_gauges_that_tell_something_count() {
    let world = World::new(10, 300, 5);
    assert_eq!(changed(&world, |_, v| v).most_contacts(), 3);
    let half = changed(&world, |g, v| if g < 6 { v } else { v * 1e-9 });
    assert_eq!(half.most_contacts(), 2);
    let twins =
        World { gauges: (0..10).map(|g| world.gauges[g / 2].clone()).collect(), ..world.clone() };
    assert_eq!(changed(&twins, |_, v| v).most_contacts(), 1);
    let blind = changed(&world, |_, v| v * 0.0);
    let verdict = blind.estimate(&[30.0; 10]).unwrap().verdict;
    assert_eq!(verdict, Verdict::NotIdentifiable(WhyNot::Misfit));
}

/// With noise ten times as assumed nothing that is said surely is wrong.
#[test]
fn answers_under_more_noise_than_assumed_are_not_sure() {
    let world = World::new(10, 300, 5);
    let estimator = world.estimator(NoiseParams::uniform(10, 0.1), EstimatorParams::default());
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    for k in [0, 1, 2] {
        for _ in 0..10 {
            let points = world.draw_points(k, 0.012, &mut rng);
            let contacts: Vec<_> = points.into_iter().map(|p| (p, 20.0)).collect();
            let mut y = world.readings(&contacts);
            world::add_noise(&mut y, 1.0, &mut rng);
            let found = estimator.estimate(&y).unwrap();
            let is_sure = !matches!(found.verdict, Verdict::NotIdentifiable(_));
            assert!(!is_sure || found.contacts.len() == k, "{k}: {found:?}");
        }
    }
}

/// Ten times the same gauge leave the place of a contact open, and the answer says so.
#[test]
fn one_gauge_ten_times_identifies_nothing() {
    let world = World::new(10, 300, 5);
    let same = World { gauges: vec![world.gauges[0].clone(); 10], ..world };
    let estimator = changed(&same, |_, v| v);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for point in same.draw_points(10, 0.0, &mut rng) {
        let g = estimator.map().normal(&point);
        if g[0].abs() < 1.0 {
            continue;
        }
        let y: Vec<f64> = g.iter().map(|g| 20.0 * g).collect();
        let verdict = estimator.estimate(&y).unwrap().verdict;
        assert!(
            matches!(
                verdict,
                Verdict::NotIdentifiable(WhyNot::SingularInformation | WhyNot::TiedExplanations)
            ),
            "{verdict:?}"
        );
    }
}

#[test]
fn noise_assumed_ten_times_wrong() {
    let world = World::new(10, 300, 5);
    for assumed in [0.1, 10.0] {
        let estimator =
            world.estimator(NoiseParams::uniform(10, assumed), EstimatorParams::default());
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        for k in 0..=3 {
            let points = world.draw_points(k, 0.012, &mut rng);
            let contacts: Vec<_> = points.into_iter().map(|p| (p, 20.0)).collect();
            let mut y = world.readings(&contacts);
            world::add_noise(&mut y, 1.0, &mut rng);
            let start = Instant::now();
            let found = estimator.estimate(&y).unwrap();
            check_numbers(&found);
            assert!(start.elapsed().as_secs_f64() < 5.0);
            assert!(found.contacts.len() <= estimator.most_contacts());
        }
    }
}

#[test]
fn an_error_of_the_map_widens_the_regions() {
    let world = World::new(10, 300, 5);
    let point = world.draw_points(1, 0.0, &mut ChaCha8Rng::seed_from_u64(8))[0];
    let y = world.readings(&[(point, 20.0)]);
    let area = |relative: f64, friction_rms: f64, tip_ring_m: f64| {
        let model_error =
            ModelError { relative, friction_rms, tip_ring_m, ..ModelError::default() };
        let noise = NoiseParams { model_error, ..NoiseParams::uniform(10, 1.0) };
        let estimator = world.estimator(noise, EstimatorParams::default());
        let found = estimator.estimate(&y).unwrap();
        check_numbers(&found);
        assert_eq!(found.contacts.len(), 1);
        let miss = found.contacts[0].position_m - world.map.skin().position(&point);
        assert!(miss.norm() < 1e-5, "{}", miss.norm());
        found.contacts[0].covariance.determinant()
    };
    let exact = area(0.0, 0.0, 0.0);
    assert!(area(0.02, 0.0, 0.0) > 2.0 * exact);
    assert!(area(0.0, 0.1, 0.0) > 2.0 * exact);
    assert!(area(0.0, 0.0, 0.004) > 2.0 * exact);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    /// Whatever finite readings come, an answer comes.
    #[test]
    fn any_readings(y in proptest::collection::vec(-1e4_f64..1e4, 10)) {
        let world = World::new(10, 60, 5);
        let params = EstimatorParams { n_starts: 20, n_bases: 10, ..EstimatorParams::default() };
        let estimator = world.estimator(NoiseParams::uniform(10, 1.0), params);
        check_numbers(&estimator.estimate(&y).unwrap());
    }
}
