//! Calibration from too few, too bad and badly placed presses.

use hapdef_bench::robustness::MustHold;
use hapdef_inverse::{Calibrated, CalibrationParams, Press, ResponseMap};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::super::table::Trials;
use super::world::{InverseWorld, SD, add_noise};
use crate::error::ReproError;

const STATED: MustHold = ("map error over the larger of that before and the stated one", 1.2);

/// Makes presses worse.
type Spoil = fn(&InverseWorld, &mut [Press], &mut ChaCha8Rng);

pub(super) fn add(rows: &mut Trials<InverseWorld>) {
    let spoilt: [(&str, usize, f64, Spoil); 9] = [
        ("150 good presses", 150, 0.0, |_, _, _| ()),
        ("the fewest presses, 2 per gauge", 20, 0.0, |_, _, _| ()),
        ("half of the presses with another's readings", 150, 0.0, swap_half),
        ("half of the presses with 10 × the force", 150, 0.0, |_, presses, _| {
            presses.iter_mut().step_by(2).for_each(|p| p.force_n *= 10.0);
        }),
        ("presses 20 mm off, declared 0", 150, 0.0, move_all),
        ("presses 20 mm off, declared 20 mm", 150, 0.02, move_all),
        ("all readings zero", 150, 0.0, |_, presses, _| {
            presses.iter_mut().for_each(|p| p.readings.fill(0.0));
        }),
        ("all readings × 1e6", 150, 0.0, |_, presses, _| {
            let each = presses.iter_mut().flat_map(|p| &mut p.readings);
            each.for_each(|y| *y *= 1e6);
        }),
        ("all readings of one gauge negated", 150, 0.0, |_, presses, _| {
            presses.iter_mut().for_each(|p| p.readings[3] *= -1.0);
        }),
    ];
    for (extreme, n, declared_m, spoil) in spoilt {
        rows.either(extreme, STATED, move |w| {
            let fitted = fit(w, &spoilt_presses(w, n, spoil), declared_m)?;
            Ok(error(w, &fitted.map) / error(w, &w.map).max(fitted.info.relative_error))
        });
    }
    refusals(rows);
}

fn refusals(rows: &mut Trials<InverseWorld>) {
    let spoilt: [(&str, &'static str, usize, Spoil); 5] = [
        ("one press", "1 usable presses", 1, |_, _, _| ()),
        ("all presses in one spot", "within", 60, |w, presses, _| {
            let point = presses[0].point;
            for press in presses {
                press.point = point;
                press.readings = w.readings(&[(point, press.force_n)]);
            }
        }),
        ("a reading of NaN", "press 7, gauge 2", 60, |_, presses, _| {
            presses[7].readings[2] = f64::NAN;
        }),
        ("an infinite reading", "press 7, gauge 2", 60, |_, presses, _| {
            presses[7].readings[2] = f64::INFINITY;
        }),
        ("a force of 0", "press 3 has a force of 0 N", 60, |_, presses, _| {
            presses[3].force_n = 0.0;
        }),
    ];
    for (extreme, words, n, spoil) in spoilt {
        rows.refused(extreme, "refused", words, move |w| {
            fit(w, &spoilt_presses(w, n, spoil), 0.0)?;
            Ok(1.0)
        });
    }
}

fn spoilt_presses(world: &InverseWorld, n: usize, spoil: Spoil) -> Vec<Press> {
    let mut rng = world.rng(61);
    let mut presses = draw(world, n, &mut rng);
    spoil(world, &mut presses, &mut rng);
    presses
}

fn fit(world: &InverseWorld, presses: &[Press], declared_m: f64) -> Result<Calibrated, ReproError> {
    let params = CalibrationParams {
        position_sd_m: declared_m,
        ..CalibrationParams::new(vec![SD; world.n()])
    };
    Ok(Calibrated::fit(&world.map, &world.sites, &[], presses, &params)?)
}

/// The limb that is pressed: gains off by 3 %, and a smooth change of 5 %.
fn truth(world: &InverseWorld, press: &hapdef_inverse::SkinPoint) -> Vec<f64> {
    let x = world.map.skin().position(press);
    let bump = 1.0 + 0.05 * (60.0 * x.x + 35.0 * x.y).sin() * (45.0 * x.z).cos();
    let gain = |i: usize| 1.0 + 0.03 * (2.0 * i as f64).sin();
    let g = world.map.normal(press).into_iter().enumerate();
    g.map(|(i, g)| g * bump * gain(i)).collect()
}

fn draw(world: &InverseWorld, n: usize, rng: &mut ChaCha8Rng) -> Vec<Press> {
    let press = |_| {
        let point = world.draw(1, 0.0, rng)[0];
        let force_n = rng.random_range(5.0..34.0);
        let mut readings: Vec<f64> = truth(world, &point).iter().map(|g| g * force_n).collect();
        add_noise(&mut readings, SD, rng);
        Press { point, force_n, readings }
    };
    (0..n).map(press).collect()
}

/// Root mean square error of `map` over that of the limb, at places of its own.
fn error(world: &InverseWorld, map: &ResponseMap) -> f64 {
    let (mut error, mut all) = (0.0, 0.0);
    for point in world.draw(200, 0.0, &mut world.rng(62)) {
        for (t, g) in truth(world, &point).iter().zip(map.normal(&point)) {
            error += (t - g).powi(2);
            all += t * t;
        }
    }
    f64::sqrt(error / all)
}

fn swap_half(_: &InverseWorld, presses: &mut [Press], _: &mut ChaCha8Rng) {
    for i in (0..presses.len() - 2).step_by(4) {
        let other = presses[i + 2].readings.clone();
        presses[i + 2].readings = std::mem::replace(&mut presses[i].readings, other);
    }
}

fn move_all(world: &InverseWorld, presses: &mut [Press], rng: &mut ChaCha8Rng) {
    let skin = world.map.skin();
    for press in presses {
        let turn = rng.random_range(0.0..std::f64::consts::TAU);
        let [a, b] = skin.tangents(&press.point);
        let far = (a * turn.cos() + b * turn.sin()) * 0.02;
        press.point = skin.walk(&press.point, &far, hapdef_inverse::AtWall::Slide).point;
    }
}
