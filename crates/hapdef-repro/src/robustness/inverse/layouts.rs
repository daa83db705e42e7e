//! Gauges that are the same, dead, blind or of very different gain.

use hapdef_report::robustness::Expected;
use std::sync::Arc;

use hapdef_inverse::{NoiseParams, SkinPoint};

use super::super::table::{Trial, trial};
use super::world::{InverseWorld, SD, WRONG, add_noise, answers, single_sds, sure, worst};
use crate::ReproError;

const METHOD: &str = "estimator";
const IN_SDS: (&str, f64) = ("sure answers are one contact within 5 sd", 5.0);

/// Which gauge stands in a gauge's place, and its factor.
type Layout = fn(usize) -> (usize, f64);

pub(super) fn trials(all: &mut Vec<Trial>, world: &Arc<InverseWorld>) {
    let of: [(&str, Layout); 6] = [
        ("every gauge twice", |i| (i / 2, 1.0)),
        ("one gauge, all alike", |_| (0, 1.0)),
        ("one gauge blind", |i| (i, if i == 4 { 0.0 } else { 1.0 })),
        ("half of the gauges blind", |i| (i, (i % 2) as f64)),
        ("all but three gauges blind", |i| (i, f64::from(u8::from(i % 4 == 0)))),
        ("gains 1e-6 … 1e6, noise the same", |i| (i, gain(i))),
    ];
    for (extreme, of) in of {
        let w = world.clone();
        all.push(trial(METHOD, format!("{extreme}; 20 N"), IN_SDS, Expected::Either, move || {
            singles(&w.regauged(of)?)
        }));
        let w = world.clone();
        let extreme = format!("{extreme}; 2 × 20 N");
        all.push(trial(METHOD, extreme, WRONG, Expected::Either, move || {
            doubles(&w.regauged(of)?)
        }));
    }
    blind(all, world);
    gains(all, world);
    dead(all, world);
}

fn gain(gauge: usize) -> f64 {
    10.0_f64.powf(-6.0 + 4.0 * (gauge % 4) as f64)
}

/// The worst of 12 contacts, readings exact.
fn singles(world: &InverseWorld) -> Result<f64, ReproError> {
    let estimator = world.estimator(SD)?;
    let one = |point| {
        let truth = (point, 20.0);
        single_sds(world, &estimator, truth, &world.readings(&[truth]))
    };
    worst(world.draw(12, 0.0, &mut world.rng(41)).into_iter().map(one))
}

fn doubles(world: &InverseWorld) -> Result<f64, ReproError> {
    let mut rng = world.rng(42);
    let frames = (0..30).map(|_| {
        let truth = world.draw(2, 0.02, &mut rng);
        let contacts: Vec<_> = truth.iter().map(|p| (*p, 20.0)).collect();
        let mut y = world.readings(&contacts);
        add_noise(&mut y, SD, &mut rng);
        (truth, y)
    });
    Ok(answers(world, &world.estimator(SD)?, frames)?.wrong_share())
}

/// All columns zero: readings of 30 µε are no contact's, and not nothing either.
fn blind(all: &mut Vec<Trial>, world: &Arc<InverseWorld>) {
    let w = world.clone();
    let holds = ("no answer is sure", 0.0);
    let extreme = "all gauges blind, readings of 30 µε";
    all.push(trial(METHOD, extreme, holds, Expected::saying("not identifiable"), move || {
        let blind = w.regauged(|i| (i, 0.0))?;
        sure(&blind.estimator(SD)?, &vec![30.0; w.n()])?;
        Ok(1.0)
    }));
}

/// Gains that the noise has, too, change nothing.
fn gains(all: &mut Vec<Trial>, world: &Arc<InverseWorld>) {
    let w = world.clone();
    let holds = ("mm that the answer differs from that with gains of 1", 1e-3);
    let extreme = "gains 1e-6 … 1e6, noise alike; 20 N";
    all.push(trial(METHOD, extreme, holds, Expected::Result, move || {
        let changed = w.regauged(|i| (i, gain(i)))?;
        let noise = NoiseParams {
            gauge_sd: (0..w.n()).map(|i| SD * gain(i)).collect(),
            ..NoiseParams::uniform(w.n(), SD)
        };
        let (plain, other) = (w.estimator(SD)?, changed.estimator_with(noise)?);
        let mut rng = w.rng(43);
        let one = |point: SkinPoint| {
            let mut y = w.readings(&[(point, 20.0)]);
            add_noise(&mut y, SD, &mut rng);
            let scaled: Vec<f64> = y.iter().enumerate().map(|(i, y)| y * gain(i)).collect();
            let (Some(a), Some(b)) = (sure(&plain, &y)?, sure(&other, &scaled)?) else {
                return Ok(f64::NAN);
            };
            if a.contacts.len() != b.contacts.len() {
                return Ok(f64::INFINITY);
            }
            let pairs = a.contacts.iter().zip(&b.contacts);
            let far = pairs.map(|(a, b)| (a.position_m - b.position_m).norm() * 1e3);
            Ok(far.fold(0.0, f64::max))
        };
        let points = w.draw(12, 0.0, &mut w.rng(44));
        worst(points.into_iter().map(one))
    }));
}

fn dead(all: &mut Vec<Trial>, world: &Arc<InverseWorld>) {
    for n_live in [3, 4, 6] {
        let w = world.clone();
        let extreme = format!("all gauges but {n_live} dead; 20 N");
        all.push(trial(METHOD, extreme, WRONG, Expected::Either, move || {
            let live: Vec<bool> = (0..w.n()).map(|i| i < n_live).collect();
            let mut rng = w.rng(45);
            let frames = (0..40).map(|_| {
                let truth = w.draw(1, 0.0, &mut rng);
                let mut y = w.readings(&[(truth[0], 20.0)]);
                add_noise(&mut y, SD, &mut rng);
                y[n_live..].fill(f64::NAN);
                (truth, y)
            });
            Ok(answers(&w, &w.estimator(SD)?.masked(&live)?, frames)?.wrong_share())
        }));
    }
    let w = world.clone();
    let expected = Expected::saying("2 gauges are alive");
    let holds = ("two gauges are refused", 0.0);
    all.push(trial(METHOD, "all gauges but 2 dead", holds, expected, move || {
        let live: Vec<bool> = (0..w.n()).map(|i| i < 2).collect();
        w.estimator(SD)?.masked(&live)?;
        Ok(1.0)
    }));
}
