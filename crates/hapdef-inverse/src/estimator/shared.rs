//! What a contact's place and force are worth where it may be two.

use std::f64::consts::PI;

use crate::estimator::explanation::Explanation;
use crate::estimator::output::IfTwo;
use crate::estimator::refine::Refiner;
use crate::walk::AtWall;

/// Directions in which a contact is taken apart.
const N_DIRECTIONS: u32 = 4;

/// The largest standard deviations of two contacts in place of contact `i` of `e`, half of its force
/// each, `apart_m` to both sides of it. `joint` is a buffer.
pub(super) fn if_two(
    refiner: &mut Refiner<'_>,
    e: &Explanation,
    i: usize,
    apart_m: f64,
    joint: &mut Vec<f64>,
) -> IfTwo {
    let skin = refiner.model.skin();
    let [t1, t2] = skin.tangents(&e.points[i]);
    let mut largest = IfTwo::default();
    for turn in 0..N_DIRECTIONS {
        let (sin, cos) = (f64::from(turn) / f64::from(N_DIRECTIONS) * PI).sin_cos();
        let step = (t1 * cos + t2 * sin) * apart_m;
        let [one, other] =
            [step, -step].map(|step| skin.walk(&e.points[i], &step, AtWall::Slide).point);
        let mut pair = *e;
        pair.points[i] = one;
        pair.push(other);
        pair.forces[i] = 0.5 * e.forces[i];
        pair.forces[e.n] = pair.forces[i];
        refiner.linear.inform(refiner.model, &mut pair);
        refiner.covariance(&pair, joint);
        let found = of_pair(joint, 3 * pair.n, [i, e.n]);
        largest.force_sd_n = largest.force_sd_n.max(found.force_sd_n);
        largest.position_sd_m = largest.position_sd_m.max(found.position_sd_m);
    }
    largest
}

/// Of two contacts' covariance among others `[width, width]`.
fn of_pair(joint: &[f64], width: usize, pair: [usize; 2]) -> IfTwo {
    let at = |p: usize, q: usize| joint[p * width + q];
    let forces = pair.map(|i| pair.map(|j| at(3 * i + 2, 3 * j + 2)));
    let place_sd_m = |i: usize| (at(3 * i, 3 * i) + at(3 * i + 1, 3 * i + 1)).sqrt();
    IfTwo {
        force_sd_n: forces.as_flattened().iter().sum::<f64>().sqrt(),
        position_sd_m: place_sd_m(pair[0]).max(place_sd_m(pair[1])),
    }
}
