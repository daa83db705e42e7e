//! Contacts in bad places, of bad sizes, in bad frames.

use hapdef_report::StabilityWanted;
use std::sync::Arc;

use hapdef_inverse::{AtWall, SkinPoint};

use super::super::row::{Case, case};
use super::world::{InverseWorld, SD, add_noise, rng, single_sds, sure, worst, wrong_share};
use crate::ReproError;

const METHOD: &str = "estimator";
const IN_SDS: (&str, f64) = ("sure answers are one contact within 5 sd", 5.0);
const WRONG: (&str, f64) = (
    "at most 5 % of the sure answers are wrong in count or by over 10 mm",
    0.05,
);
const N_FRAMES: usize = 40;

pub(super) fn cases(all: &mut Vec<Case>, world: &Arc<InverseWorld>) {
    merging(all, world);
    borders(all, world);
    forces(all, world);
    noises(all, world);
    bad_readings(all, world);
}

/// Two contacts of 10 and 12 N ever nearer.
fn merging(all: &mut Vec<Case>, world: &Arc<InverseWorld>) {
    for gap_mm in [20.0, 5.0, 1.0, 1e-3, 1e-6, 0.0] {
        let extreme = format!("two contacts {gap_mm} mm apart");
        let w = world.clone();
        let holds = ("forces sum to those of both, relative error", 0.05);
        all.push(case(
            METHOD,
            extreme.clone(),
            holds,
            StabilityWanted::Either,
            move || over_pairs(&w, gap_mm, |_, sum_n, _| (sum_n / 22.0 - 1.0).abs()),
        ));
        let w = world.clone();
        let holds = (
            "mm beyond half the gap from a contact to the nearest found",
            3.0,
        );
        all.push(case(
            METHOD,
            extreme,
            holds,
            StabilityWanted::Either,
            move || over_pairs(&w, gap_mm, |far_m, _, gap_m| (far_m - gap_m / 2.0) * 1e3),
        ));
    }
}

/// The worst over pairs of `figure`(largest distance of a true contact to the nearest found, sum of
/// the forces found, the true gap).
fn over_pairs(
    world: &InverseWorld,
    gap_mm: f64,
    figure: impl Fn(f64, f64, f64) -> f64,
) -> Result<f64, ReproError> {
    let estimator = world.estimator(SD)?;
    let skin = world.map.skin();
    let one = |start: SkinPoint| {
        let step = skin.tangents(&start)[0] * (gap_mm * 1e-3);
        let other = skin.walk(&start, &step, AtWall::Slide).point;
        let y = world.readings(&[(start, 10.0), (other, 12.0)]);
        let Some(found) = sure(&estimator, &y)? else {
            return Ok(f64::NAN);
        };
        let far = |point: &SkinPoint| {
            let x = skin.position(point);
            let gaps = found.contacts.iter().map(|c| (c.position_m - x).norm());
            gaps.fold(f64::INFINITY, f64::min)
        };
        let sum_n = found.contacts.iter().map(|c| c.force_n).sum();
        Ok(figure(
            far(&start).max(far(&other)),
            sum_n,
            world.gap_m(&start, &other),
        ))
    };
    worst(world.draw(12, 0.0, &mut rng(31)).into_iter().map(one))
}

fn borders(all: &mut Vec<Case>, world: &Arc<InverseWorld>) {
    for (extreme, at_clamp) in [
        ("20 N on the free rim", false),
        ("20 N on the clamped border", true),
    ] {
        let w = world.clone();
        all.push(case(
            METHOD,
            extreme,
            IN_SDS,
            StabilityWanted::Either,
            move || {
                let estimator = w.estimator(SD)?;
                let rim = w.rim();
                let n = rim.len().min(20);
                let part = if at_clamp {
                    &rim[..n]
                } else {
                    &rim[rim.len() - n..]
                };
                let one = |point: &SkinPoint| {
                    let truth = (*point, 20.0);
                    single_sds(&w, &estimator, truth, &w.readings(&[truth]))
                };
                worst(part.iter().map(one))
            },
        ));
    }
}

fn forces(all: &mut Vec<Case>, world: &Arc<InverseWorld>) {
    for exponent in -3..=5 {
        let w = world.clone();
        let extreme = format!("a force of 1e{exponent} N");
        all.push(case(
            METHOD,
            extreme,
            IN_SDS,
            StabilityWanted::Either,
            move || {
                let estimator = w.estimator(SD)?;
                let one = |point| {
                    let truth = (point, 10.0_f64.powi(exponent));
                    single_sds(&w, &estimator, truth, &w.readings(&[truth]))
                };
                worst(w.draw(12, 0.0, &mut rng(32)).into_iter().map(one))
            },
        ));
    }
}

fn noises(all: &mut Vec<Case>, world: &Arc<InverseWorld>) {
    for (words, told) in [("10 × too small", 0.1), ("10 × too large", 10.0)] {
        for k in 0..=2 {
            let w = world.clone();
            let extreme = format!("noise told {words}, {k} contacts of 20 N");
            all.push(case(
                METHOD,
                extreme,
                WRONG,
                StabilityWanted::Either,
                move || {
                    let mut rng = rng(33 + k as u64);
                    let frames = (0..N_FRAMES).map(|_| {
                        let truth = w.draw(k, 0.02, &mut rng);
                        let contacts: Vec<_> = truth.iter().map(|p| (*p, 20.0)).collect();
                        let mut y = w.readings(&contacts);
                        add_noise(&mut y, SD, &mut rng);
                        (truth, y)
                    });
                    wrong_share(&w, &w.estimator(told * SD)?, frames)
                },
            ));
        }
    }
}

fn bad_readings(all: &mut Vec<Case>, world: &Arc<InverseWorld>) {
    let holds = ("the gauge is named", 0.0);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let w = world.clone();
        let wanted = StabilityWanted::saying("the reading of gauge 7");
        let extreme = format!("a reading of {bad:e}");
        all.push(case(METHOD, extreme, holds, wanted, move || {
            let mut y = vec![SD; w.n()];
            y[7] = bad;
            Ok(w.estimator(SD)?.estimate(&y)?.chi2)
        }));
    }
    for size in [1e2, 1e4, 1e8] {
        let w = world.clone();
        let holds = ("at most 5 % of the answers are sure", 0.05);
        let extreme = format!("random readings of {size:.0e} µε");
        all.push(case(
            METHOD,
            extreme,
            holds,
            StabilityWanted::Either,
            move || {
                let mut rng = rng(37);
                let nowhere = (0..N_FRAMES).map(|_| {
                    let mut y = vec![0.0; w.n()];
                    add_noise(&mut y, size, &mut rng);
                    (vec![w.sites.points()[0]; 9], y)
                });
                let estimator = w.estimator(SD)?;
                let sure = nowhere.filter(|(_, y)| sure(&estimator, y).is_ok());
                Ok(sure.count() as f64 / N_FRAMES as f64)
            },
        ));
    }
}
