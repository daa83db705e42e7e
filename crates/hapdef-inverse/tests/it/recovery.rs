//! What is put in is found: exactly without noise, at the bound with it, within the stated regions.

use crate::world;

use hapdef_inverse::{
    AtWall, ContactEstimate, EstimatorParams, ModelError, NoiseParams, SkinPoint, Verdict,
    joint_bounds,
};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use world::World;

const SD: f64 = 1.0;

fn given(count: usize) -> EstimatorParams {
    EstimatorParams { known_count: Some(count), ..EstimatorParams::default() }
}

fn draw(world: &World, k: usize, rng: &mut ChaCha8Rng) -> Vec<(SkinPoint, f64)> {
    let points = world.draw_points(k, 0.015, rng);
    let force = |p| (p, rng.random_range(5.0..34.0));
    points.into_iter().map(force).collect()
}

#[test]
fn without_noise_one_and_two_contacts_are_exact() {
    for (seed, k) in [(1, 1), (2, 1), (3, 1), (4, 2), (5, 2), (6, 2)] {
        let world = World::new(10, 800, seed);
        let params =
            EstimatorParams { chi2_tolerance: 0.0, max_steps: 200, ..EstimatorParams::default() };
        let estimator = world.estimator(NoiseParams::uniform(10, SD), params);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for frame in 0..20 {
            let contacts = draw(&world, k, &mut rng);
            let found = estimator.estimate(&world.readings(&contacts)).unwrap();
            assert_eq!(found.contacts.len(), k, "seed {seed}, frame {frame}");
            for (point, force_n) in &contacts {
                let x = world.map.skin().position(point);
                let nearest = found
                    .contacts
                    .iter()
                    .min_by(|a, b| {
                        let far = |c: &hapdef_inverse::LocatedContact| (c.position_m - x).norm();
                        far(a).total_cmp(&far(b))
                    })
                    .unwrap();
                let miss = (nearest.position_m - x).norm() / world::RADIUS_M;
                let miss_n = (nearest.force_n / force_n - 1.0).abs();
                assert!(
                    miss < 1e-6 && miss_n < 1e-6,
                    "seed {seed}, frame {frame}: {miss:e}, {miss_n:e}, χ² {:e}",
                    found.chi2
                );
            }
        }
    }
}

/// The sum of two contacts' forces is as sure as is said of the one in their middle, in the direction
/// where it is least so.
#[test]
fn what_one_contact_is_worth_if_it_is_two_is_what_two_are() {
    let world = World::new(10, 800, 3);
    let params = EstimatorParams::default();
    let estimator = world.estimator(NoiseParams::uniform(10, SD), params);
    let skin = world.map.skin();
    for point in world.draw_points(6, 0.01, &mut ChaCha8Rng::seed_from_u64(8)) {
        let one = estimator.estimate(&world.readings(&[(point, 20.0)])).unwrap();
        let [if_two] = one.if_two[..] else {
            panic!("{} contacts", one.contacts.len());
        };
        let [t1, t2] = skin.tangents(&one.contacts[0].point);
        let mut largest = [0.0_f64; 2];
        for turn in [0.0, 0.25, 0.5, 0.75] {
            let (sin, cos) = (turn * std::f64::consts::PI).sin_cos();
            let step = (t1 * cos + t2 * sin) * params.distinct_m;
            let ends = [step, -step].map(|step| {
                let end = skin.walk(&one.contacts[0].point, &step, AtWall::Slide);
                (end.point, 10.0)
            });
            let mut two = ContactEstimate::default();
            let (points, y) = (ends.map(|(point, _)| point), world.readings(&ends));
            estimator.refine_into(&y, &points, &mut estimator.scratch(), &mut two).unwrap();
            let joint = |p: usize, q: usize| two.joint_covariance[6 * p + q];
            let force_sd_n = (joint(2, 2) + 2.0 * joint(2, 5) + joint(5, 5)).sqrt();
            let place_sd_m = |p: usize| (joint(p, p) + joint(p + 1, p + 1)).sqrt();
            largest[0] = largest[0].max(force_sd_n);
            largest[1] = largest[1].max(place_sd_m(0).max(place_sd_m(3)));
        }
        let off = [if_two.force_sd_n / largest[0] - 1.0, if_two.position_sd_m / largest[1] - 1.0];
        assert!(off.iter().all(|off| off.abs() < 1e-6), "{off:?}");
        assert!(if_two.force_sd_n > one.contacts[0].covariance[(2, 2)].sqrt());
    }
}

#[test]
fn where_no_further_contact_may_touch_none_is_weighed() {
    let world = World::new(10, 800, 3);
    let alone = EstimatorParams { max_contacts: 1, ..EstimatorParams::default() };
    let estimator = world.estimator(NoiseParams::uniform(10, SD), alone);
    let [point] = world.draw_points(1, 0.01, &mut ChaCha8Rng::seed_from_u64(8))[..] else {
        panic!("one point was asked for");
    };
    let one = estimator.estimate(&world.readings(&[(point, 20.0)])).unwrap();
    assert_eq!((one.contacts.len(), one.if_two.len()), (1, 0));
}

/// Normalised errors of frames with `k` contacts that the answer calls identified: (Mahalanobis distance² of all unknowns, Σ of
/// squared position errors, Σ of squared bounds).
fn frames(k: usize, n_frames: usize, seed: u64) -> Vec<(f64, f64, f64)> {
    let world = World::new(10, 800, seed);
    let estimator = world.estimator(NoiseParams::uniform(10, SD), given(k));
    let (mut scratch, mut out) = (estimator.scratch(), ContactEstimate::default());
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 100);
    let mut results = Vec::new();
    let skin = world.map.skin();
    for _ in 0..n_frames {
        let contacts = draw(&world, k, &mut rng);
        let mut y = world.readings(&contacts);
        world::add_noise(&mut y, SD, &mut rng);
        estimator.estimate_into(&y, &mut scratch, &mut out).unwrap();
        if out.verdict != Verdict::Identified {
            continue;
        }
        if out.verdict != Verdict::Identified {
            continue;
        }
        let truth: Vec<_> = contacts.iter().map(|c| skin.position(&c.0)).collect();
        let found: Vec<_> = out.contacts.iter().map(|c| c.position_m).collect();
        let mut difference = vec![0.0; 3 * out.contacts.len()];
        let mut square = 0.0;
        for (i, j) in world::matched(&truth, &found).into_iter().enumerate() {
            let Some(j) = j else { continue };
            let contact = &out.contacts[j];
            let d = truth[i] - contact.position_m;
            let [t1, t2] = skin.tangents(&contact.point);
            difference[3 * j] = d.dot(&t1);
            difference[3 * j + 1] = d.dot(&t2);
            difference[3 * j + 2] = contacts[i].1 - contact.force_n;
            square += d.norm_squared();
        }
        let n = difference.len();
        let covariance = DMatrix::from_row_slice(n, n, &out.joint_covariance);
        let difference = DVector::from_vec(difference);
        let solved = covariance.cholesky().unwrap().solve(&difference);
        let bounds = joint_bounds(&estimator, &contacts).unwrap().unwrap();
        let bound = bounds.iter().map(|b| b.position_sd_m.powi(2)).sum();
        results.push((difference.dot(&solved), square, bound));
    }
    results
}

/// A region is the linearised problem's, so what it says is claimed where the bound of all positions
/// together is below this: well inside the few millimetres over which a response changes.
const LINEAR_M: f64 = 1e-3;

/// 95 % points of χ²₃ and χ²₆: Abramowitz and Stegun, table 26.8.
#[test]
fn regions_hold_what_they_say_and_errors_meet_the_bound() {
    for (k, n_frames, chi2_95) in [(1, 1500, 7.814_73), (2, 600, 12.591_6)] {
        let results = frames(k, n_frames, 11);
        let linear = || results.iter().filter(|r| r.2 < LINEAR_M * LINEAR_M);
        let n_inside = linear().filter(|r| r.0 <= chi2_95).count();
        let coverage = n_inside as f64 / linear().count() as f64;
        assert!(results.len() * 5 > n_frames * 4, "{} identified", results.len());
        assert!((0.92..0.98).contains(&coverage), "{k} contacts: 95 % regions hold {coverage:.3}");
        let mut ratios: Vec<f64> = results.iter().map(|r| (r.1 / r.2).sqrt()).collect();
        ratios.sort_by(f64::total_cmp);
        // the median of error over bound: 1.18/√2 for a round region, 0.67 for a needle
        let median = ratios[ratios.len() / 2];
        assert!((0.6..1.05).contains(&median), "{k} contacts: median error over bound {median:.3}");
    }
}

#[test]
fn nothing_touches_most_of_the_time_that_nothing_touches() {
    let world = World::new(10, 300, 2);
    let estimator = world.estimator(NoiseParams::uniform(10, SD), EstimatorParams::default());
    let (mut scratch, mut out) = (estimator.scratch(), ContactEstimate::default());
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut n_touched = 0;
    for _ in 0..2000 {
        let mut y = vec![0.0; 10];
        world::add_noise(&mut y, SD, &mut rng);
        estimator.estimate_into(&y, &mut scratch, &mut out).unwrap();
        n_touched += usize::from(out.verdict != Verdict::Untouched);
    }
    assert!(n_touched <= 10, "{n_touched} of 2000 at a level of 1e-3");
}

#[test]
fn the_same_frame_gives_the_same_answer() {
    let world = World::new(10, 400, 2);
    let estimator = world.estimator(NoiseParams::uniform(10, SD), EstimatorParams::default());
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let contacts = draw(&world, 2, &mut rng);
    let mut y = world.readings(&contacts);
    world::add_noise(&mut y, SD, &mut rng);
    let first = estimator.estimate(&y).unwrap();
    let mut scratch = estimator.scratch();
    let mut again = ContactEstimate::default();
    for _ in 0..3 {
        let mut other = world.readings(&draw(&world, 3, &mut rng));
        world::add_noise(&mut other, SD, &mut rng);
        estimator.estimate_into(&other, &mut scratch, &mut again).unwrap();
    }
    estimator.estimate_into(&y, &mut scratch, &mut again).unwrap();
    assert_eq!(first, again);
}

/// Two contacts with friction on twelve gauges, found from a start 2 mm off.
#[test]
fn shear_is_found_from_a_start_nearby() {
    let world = World::new(12, 400, 9);
    let params = EstimatorParams { chi2_tolerance: 0.0, ..EstimatorParams::default() };
    let estimator = world.estimator(NoiseParams::uniform(12, SD), params);
    let skin = world.map.skin();
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut n_exact = 0;
    for _ in 0..20 {
        let points = world.draw_points(2, 0.03, &mut rng);
        let mut y = vec![0.0; 12];
        let mut forces = Vec::new();
        for point in &points {
            let [t1, t2] = skin.tangents(point);
            let force = (-skin.normal(point) + t1 * 0.15 - t2 * 0.1) * 20.0;
            for (y, g) in y.iter_mut().zip(world.map.vector(point)) {
                *y += g.dot(&force);
            }
            forces.push(force);
        }
        let starts: Vec<SkinPoint> = points
            .iter()
            .map(|p| {
                let step = skin.tangents(p)[0] * 0.002;
                skin.walk(p, &step, AtWall::Slide).point
            })
            .collect();
        let (found, chi2) = estimator.refine_shear(&y, &starts, 0.5).unwrap();
        assert!(chi2.is_finite() && found.len() == 2);
        let is_exact = found.iter().zip(&points).zip(&forces).all(|((c, p), f)| {
            (c.position_m - skin.position(p)).norm() < 1e-5 && (c.force_vector_n - f).norm() < 1e-2
        });
        n_exact += usize::from(is_exact);
        for c in &found {
            let inward = -skin.normal(&c.point);
            let along = c.force_vector_n.dot(&inward);
            let across = (c.force_vector_n - inward * along).norm();
            assert!(across <= 0.5 * along + 1e-9);
        }
    }
    assert_eq!(n_exact, 20, "of 20 frames");
}

/// With a map that is 4 % off, a third contact often hides in what the error of two explains: it is found
/// where a likely residual alone does not settle the count.
#[test]
fn a_contact_that_the_maps_error_may_hide_is_looked_for() {
    let world = World::new(16, 800, 5);
    let model_error = ModelError { relative: 0.04, ..ModelError::default() };
    let noise = NoiseParams { model_error, ..NoiseParams::uniform(16, SD) };
    let n_right = |settle_p: f64| {
        let params = EstimatorParams { settle_p, ..EstimatorParams::default() };
        let estimator = world.estimator(noise.clone(), params);
        let mut rng = ChaCha8Rng::seed_from_u64(77);
        let is_right = |_: &usize| {
            let mut contacts = draw(&world, 3, &mut rng);
            contacts[2].1 = 5.0;
            let mut y = world.readings(&contacts);
            for (point, force_n) in &contacts {
                let mut off = vec![0.0; y.len()];
                world::add_noise(&mut off, 0.04 * force_n, &mut rng);
                let g = world.map.normal(point);
                let errors = off.iter().zip(&g).map(|(off, g)| off * g);
                y.iter_mut().zip(errors).for_each(|(y, error)| *y += error);
            }
            world::add_noise(&mut y, SD, &mut rng);
            estimator.estimate(&y).unwrap().contacts.len() == 3
        };
        (0..60).filter(is_right).count()
    };
    let defaults = EstimatorParams::default();
    let [settled, accepted] = [defaults.settle_p, defaults.accept_p].map(n_right);
    assert!(settled > accepted, "{settled} of 60, not more than {accepted}");
}
