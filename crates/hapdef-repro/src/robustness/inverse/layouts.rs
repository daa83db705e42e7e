//! Gauges that are the same, dead, blind or of very different gain.

use hapdef_inverse::{NoiseParams, SkinPoint};

use super::super::table::Trials;
use super::estimator::IN_SDS;
use super::world::{InverseWorld, SD, WRONG, add_noise, answers, sure, worst, worst_single};

/// Which gauge stands in a gauge's place, and its factor.
type Layout = fn(usize) -> (usize, f64);

pub(super) fn add(rows: &mut Trials<InverseWorld>) {
    let of: [(&str, Layout); 6] = [
        ("every gauge twice", |i| (i / 2, 1.0)),
        ("one gauge, all alike", |_| (0, 1.0)),
        ("one gauge blind", |i| (i, if i == 4 { 0.0 } else { 1.0 })),
        ("half of the gauges blind", |i| (i, (i % 2) as f64)),
        ("all but three gauges blind", |i| (i, f64::from(u8::from(i % 4 == 0)))),
        ("gains 1e-6 … 1e6, noise the same", |i| (i, gain(i))),
    ];
    for (extreme, of) in of {
        rows.either(format!("{extreme}; 20 N"), IN_SDS, move |w| {
            let world = w.regauged(of)?;
            worst_single(&world, &world.draw(12, 0.0, &mut world.rng(41)), 20.0)
        });
        rows.either(format!("{extreme}; 2 × 20 N"), WRONG, move |w| {
            let (world, mut rng) = (w.regauged(of)?, w.rng(42));
            let frames = (0..30).map(|_| world.noisy(2, 20.0, &mut rng));
            Ok(answers(&world, &world.estimator(SD)?, frames)?.wrong_share())
        });
    }
    blind(rows);
    gains(rows);
    dead(rows);
}

fn gain(gauge: usize) -> f64 {
    10.0_f64.powf(-6.0 + 4.0 * (gauge % 4) as f64)
}

/// All columns zero: readings of 30 µε are no contact's, and not nothing either.
fn blind(rows: &mut Trials<InverseWorld>) {
    let extreme = "all gauges blind, readings of 30 µε";
    rows.refused(extreme, "no answer is sure", "not identifiable", |w| {
        let blind = w.regauged(|i| (i, 0.0))?;
        sure(&blind.estimator(SD)?, &vec![30.0; w.n()])?;
        Ok(1.0)
    });
}

/// Gains that the noise has, too, change nothing.
fn gains(rows: &mut Trials<InverseWorld>) {
    let holds = ("mm that the answer differs from that with gains of 1", 1e-3);
    rows.accurate("gains 1e-6 … 1e6, noise alike; 20 N", holds, |w| {
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
    });
}

fn dead(rows: &mut Trials<InverseWorld>) {
    for n_live in [3, 4, 6] {
        rows.either(format!("all gauges but {n_live} dead; 20 N"), WRONG, move |w| {
            let live: Vec<bool> = (0..w.n()).map(|i| i < n_live).collect();
            let mut rng = w.rng(45);
            let frames = (0..40).map(|_| {
                let (truth, mut y) = w.noisy(1, 20.0, &mut rng);
                y[n_live..].fill(f64::NAN);
                (truth, y)
            });
            Ok(answers(w, &w.estimator(SD)?.masked(&live)?, frames)?.wrong_share())
        });
    }
    let (holds, words) = ("two gauges are refused", "2 gauges are alive");
    rows.refused("all gauges but 2 dead", holds, words, |w| {
        let live: Vec<bool> = (0..w.n()).map(|i| i < 2).collect();
        w.estimator(SD)?.masked(&live)?;
        Ok(1.0)
    });
}
