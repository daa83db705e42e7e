//! Contacts wider than the map's tip, on the made-up limb.

use crate::world;

use std::sync::Arc;

use hapdef_inverse::{
    ContactEstimator, EstimatorParams, InverseError, LocatedContact, NoiseParams, ResponseMap,
    ResponseParams, SearchOutcome, SearchRequest, Searcher, SkinPoint, TrackerParams, WideParams,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use world::World;

const SD: f64 = 1.0;
const FORCE_N: f64 = 20.0;

fn estimator(world: &World, widest_m: f64) -> ContactEstimator {
    let wide = WideParams::up_to(widest_m, 0.0);
    let params = EstimatorParams { wide, ..EstimatorParams::default() };
    world.estimator(NoiseParams::uniform(world.gauges.len(), SD), params)
}

/// The map under a tip of `radius_m`, integrated from the gauges' formulas.
fn under_tip(world: &World, radius_m: f64) -> ResponseMap {
    let params = ResponseParams { tip_radius_m: radius_m };
    let map = &world.map;
    ResponseMap::from_nodal(map.skin().clone(), map.n_gauges(), &map.nodal(), &params).unwrap()
}

fn readings(map: &ResponseMap, point: &SkinPoint, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut readings: Vec<f64> = map.normal(point).iter().map(|g| FORCE_N * g).collect();
    world::add_noise(&mut readings, SD, rng);
    readings
}

/// Palms are one contact each, where they are and as strong as they are, and most have a radius, which is as sure as it
/// is reported to be; by narrow contacts alone most of them are not found.
#[test]
fn a_palm_is_one_contact_with_its_radius() {
    let world = World::new(10, 800, 1);
    let (wide, narrow) = (estimator(&world, 0.02), estimator(&world, 0.0));
    for radius_m in [0.012, 0.0185] {
        let palm = under_tip(&world, radius_m);
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let points = world.draw_points(40, 0.0, &mut rng);
        let (mut n_right, mut n_narrow, mut off_sds) = (0, 0, Vec::new());
        for point in &points {
            let y = readings(&palm, point, &mut rng);
            let x = palm.skin().position(point);
            let is_right = |found: &[LocatedContact]| {
                found.len() == 1
                    && (found[0].position_m - x).norm() < 3e-3
                    && (found[0].force_n / FORCE_N - 1.0).abs() < 0.1
            };
            let found = wide.estimate(&y).unwrap().contacts;
            n_right += usize::from(is_right(&found));
            n_narrow += usize::from(is_right(&narrow.estimate(&y).unwrap().contacts));
            let radius = found[0].radius;
            off_sds
                .extend(radius.and_then(|found| Some((found.radius_m - radius_m) / found.sd_m?)));
        }
        assert!(n_right >= 38, "{n_right} of 40 palms of {radius_m} m");
        assert!(n_narrow < 20, "{n_narrow} of 40 palms of {radius_m} m by narrow contacts");
        let mean_square = off_sds.iter().map(|off| off * off).sum::<f64>() / off_sds.len() as f64;
        assert!(off_sds.len() >= 34, "{} of 40 radii of {radius_m} m", off_sds.len());
        assert!((0.3..3.0).contains(&mean_square), "{radius_m} m: {mean_square}");
    }
}

/// Narrow contacts are found as they are where no wide ones are looked for, one and two at a time.
#[test]
fn narrow_contacts_stay_what_they_are() {
    let world = World::new(10, 800, 3);
    let (wide, narrow) = (estimator(&world, 0.02), estimator(&world, 0.0));
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for k in [1, 2] {
        for _ in 0..20 {
            let points = world.draw_points(k, 0.015, &mut rng);
            let contacts: Vec<_> = points.into_iter().map(|point| (point, FORCE_N)).collect();
            let mut y = world.readings(&contacts);
            world::add_noise(&mut y, SD, &mut rng);
            let (found, alone) = (wide.estimate(&y).unwrap(), narrow.estimate(&y).unwrap());
            assert_eq!(found.contacts, alone.contacts);
        }
    }
}

/// What searches beside a tracker gives narrow contacts alone, however wide its estimator looks: no hypothesis of a
/// tracker has a radius.
#[test]
fn a_trackers_searches_find_narrow_contacts_alone() {
    let world = World::new(10, 800, 1);
    let (wide, narrow) = (estimator(&world, 0.02), estimator(&world, 0.0));
    let palm = under_tip(&world, 0.0185);
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut n_wide = 0;
    for point in world.draw_points(10, 0.0, &mut rng) {
        let y = readings(&palm, &point, &mut rng);
        n_wide += usize::from(wide.estimate(&y).unwrap().contacts[0].radius.is_some());
        let expected = narrow.estimate(&y).unwrap().contacts;
        let live = [true; 10];
        let request = SearchRequest { frame: 1, readings: &y, live: &live, belief: None };
        let for_tracker = Searcher::for_tracker(wide.clone(), TrackerParams::default()).unwrap();
        for mut searcher in [Searcher::new(wide.clone()), for_tracker] {
            let mut outcome = SearchOutcome::default();
            searcher.search(&request, &mut outcome).unwrap();
            assert_eq!(outcome.estimate.contacts, expected);
        }
    }
    assert!(n_wide >= 9, "{n_wide} of 10 palms have a radius");
}

/// A gauge that is left out, other noise and loads count on the wide maps, too.
#[test]
fn what_changes_the_estimator_changes_the_wide_ones() {
    let world = World::new(10, 800, 1);
    let mut live = vec![true; 10];
    live[3] = false;
    let masked = estimator(&world, 0.02).masked(&live).unwrap();
    let palm = under_tip(&world, 0.0185);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let points = world.draw_points(20, 0.0, &mut rng);
    let n_one = points.iter().filter(|point| {
        let mut y = readings(&palm, point, &mut rng);
        // what a gauge reads that does not count
        y[3] = 1e4;
        masked.estimate(&y).unwrap().contacts.len() == 1
    });
    let n_one = n_one.count();
    assert!(n_one >= 19, "{n_one} of 20");
}

#[test]
fn a_widest_contact_no_wider_than_the_tip_is_refused() {
    let world = World::new(10, 100, 1);
    let wide = Some(WideParams { tip_radius_m: 0.002, widest_m: 0.002 });
    let params = EstimatorParams { wide, ..EstimatorParams::default() };
    let (map, sites) = (Arc::clone(&world.map), Arc::clone(&world.sites));
    let refused = ContactEstimator::new(map, sites, NoiseParams::uniform(10, SD), params);
    assert!(matches!(refused, Err(InverseError::Parameter { .. })));
    assert_eq!(WideParams::up_to(0.002, 0.002), None);
}
