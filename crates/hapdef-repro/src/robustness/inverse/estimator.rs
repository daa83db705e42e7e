//! Contacts in bad places, of bad sizes, in bad frames.

use hapdef_bench::robustness::MustHold;
use hapdef_inverse::{ContactEstimate, IfTwo, SkinPoint};

use super::super::table::Trials;
use super::world::{
    Answers, InverseWorld, SD, SURE_AND_WRONG, WRONG, add_noise, answers, is_unseen, sure, worst,
    worst_single,
};
use crate::error::ReproError;

pub(super) const IN_SDS: MustHold = ("sure answers are one contact within 5 sd", 5.0);
const N_FRAMES: usize = 40;

/// Enough to tell a share of 5 % from one of 8 %.
const N_NOISY_FRAMES: usize = 400;

const N_PAIRS: usize = 24;

/// No answer on two merging contacts has to be nearer than this to half their gap, m.
const LEAST_FAR_M: f64 = 3e-3;

pub(super) fn add(rows: &mut Trials<InverseWorld>) {
    merging(rows);
    borders(rows);
    forces(rows);
    noises(rows);
    bad_readings(rows);
}

/// Two contacts of 10 and 12 N ever nearer, anywhere and on the rim, where the limb is held included.
/// Where one explains the readings of two, its answer has to say what it is worth if it is two. A contact
/// that alone would not be seen at all is not asked for.
fn merging(rows: &mut Trials<InverseWorld>) {
    let metrics: [(MustHold, Metric); 2] = [
        (
            (
                "forces sum to those felt within 5 sd (one contact: its sd if it is two), 1 % each at least",
                5.0,
            ),
            |m| (m.sum_n - m.felt_n).abs() / m.sum_sd_n.max(0.22),
        ),
        (
            (
                "half the gap and 3 mm or 5 sd from a contact felt to the nearest found (one contact: its sd if it is two), \
                 in parts of 3 mm or 5 sd",
                1.0,
            ),
            |m| m.far,
        ),
    ];
    for gap_mm in [20.0, 10.0, 7.0, 5.0, 1.0, 1e-3, 1e-6, 0.0] {
        for (place, is_rim) in [("", false), (" on the rim", true)] {
            let extreme = format!("two contacts {gap_mm} mm apart{place}");
            for (holds, metric) in metrics {
                rows.either(extreme.clone(), holds, move |w| over_pairs(w, gap_mm, is_rim, metric));
            }
        }
    }
}

/// What a row measures.
type Metric = fn(&Merged) -> f64;

/// Forces of the two contacts, N.
const FORCES_N: [f64; 2] = [10.0, 12.0];

/// What is found of those of two contacts that are felt.
struct Merged {
    /// Sum of their forces.
    felt_n: f64,
    /// The largest distance of one of them to the nearest found beyond half the gap, in parts of 3 mm or
    /// of 5 of the found one's standard deviations, whichever is more.
    far: f64,
    /// Sum of the forces found, and its standard deviation.
    sum_n: f64,
    sum_sd_n: f64,
}

impl Merged {
    fn of(world: &InverseWorld, truth: &[SkinPoint; 2], found: &ContactEstimate) -> Self {
        let felt = felt(world, truth);
        let if_two = match found.if_two.as_slice() {
            [one] => *one,
            _ => IfTwo::default(),
        };
        let half_m = world.gap_m(&truth[0], &truth[1]) / 2.0;
        let far = |point: &SkinPoint| {
            let x = world.map.skin().position(point);
            let parts = found.contacts.iter().map(|c| {
                let own_sd_m = (c.covariance[(0, 0)] + c.covariance[(1, 1)]).sqrt();
                let allowed_m = LEAST_FAR_M.max(5.0 * own_sd_m.max(if_two.position_sd_m));
                ((c.position_m - x).norm() - half_m) / allowed_m
            });
            parts.fold(f64::INFINITY, f64::min)
        };
        let n = found.contacts.len();
        let forces = || (0..n).map(|i| 3 * i + 2);
        let covariance = |i: usize| forces().map(move |j| found.joint_covariance[3 * n * i + j]);
        let own_sd_n = forces().flat_map(covariance).sum::<f64>().sqrt();
        Self {
            felt_n: felt.iter().map(|(_, force_n)| force_n).sum(),
            far: felt.iter().map(|(p, _)| far(p)).fold(0.0, f64::max),
            sum_n: found.contacts.iter().map(|c| c.force_n).sum(),
            sum_sd_n: own_sd_n.max(if_two.force_sd_n),
        }
    }
}

/// Those of the two contacts that alone move the gauges by more than their noise, as one on the clamp
/// itself may not; both if only both together do.
fn felt(world: &InverseWorld, truth: &[SkinPoint; 2]) -> Vec<(SkinPoint, f64)> {
    let pressed: Vec<_> = truth.iter().copied().zip(FORCES_N).collect();
    let is_felt = |contact: &(SkinPoint, f64)| !is_unseen(&world.readings(&[*contact]));
    let alone: Vec<_> = pressed.iter().copied().filter(is_felt).collect();
    if alone.is_empty() && !is_unseen(&world.readings(&pressed)) {
        return pressed;
    }
    alone
}

/// The worst over pairs of a metric; the skin bends, and a pair is left out where its contacts are
/// nearer than three quarters of the gap.
fn over_pairs(
    world: &InverseWorld,
    gap_mm: f64,
    is_rim: bool,
    metric: Metric,
) -> Result<f64, ReproError> {
    let estimator = world.estimator(SD)?;
    let starts = match is_rim {
        true => spread(&world.rim()),
        false => world.draw(N_PAIRS, 0.0, &mut world.rng(31)),
    };
    let pairs =
        starts.into_iter().filter_map(|start| Some([start, world.beside(&start, gap_mm * 1e-3)?]));
    let one = |truth: [SkinPoint; 2]| {
        let y = world.readings(&[(truth[0], FORCES_N[0]), (truth[1], FORCES_N[1])]);
        let Some(found) = sure(&estimator, &y)? else {
            return Ok(f64::NAN);
        };
        Ok(metric(&Merged::of(world, &truth, &found)))
    };
    worst(pairs.map(one))
}

/// Some of the points, evenly.
fn spread(points: &[SkinPoint]) -> Vec<SkinPoint> {
    let stride = points.len().div_ceil(N_PAIRS).max(1);
    points.iter().copied().step_by(stride).collect()
}

fn borders(rows: &mut Trials<InverseWorld>) {
    for (extreme, at_clamp) in
        [("20 N on the free rim", false), ("20 N on the clamped border", true)]
    {
        rows.either(extreme, IN_SDS, move |w| {
            let rim = w.rim();
            let n = rim.len().min(20);
            let part = if at_clamp { &rim[..n] } else { &rim[rim.len() - n..] };
            worst_single(w, part, 20.0)
        });
    }
}

fn forces(rows: &mut Trials<InverseWorld>) {
    for exponent in -3..=5 {
        rows.either(format!("a force of 1e{exponent} N"), IN_SDS, move |w| {
            worst_single(w, &w.draw(12, 0.0, &mut w.rng(32)), 10.0_f64.powi(exponent))
        });
    }
}

fn noises(rows: &mut Trials<InverseWorld>) {
    type Share = fn(Answers) -> f64;
    // with noise assumed too small hardly any answer is sure, and those by chance
    let assumed: [(_, _, _, Share); 2] = [
        ("10 × too small", 0.1, SURE_AND_WRONG, Answers::sure_and_wrong_share),
        ("10 × too large", 10.0, WRONG, Answers::wrong_share),
    ];
    for (words, assumed, holds, share) in assumed {
        for k in 0..=2 {
            let extreme = format!("noise assumed {words}, {k} contacts of 20 N");
            rows.either(extreme, holds, move |w| {
                let mut rng = w.rng(33 + k as u64);
                let frames = (0..N_NOISY_FRAMES).map(|_| w.noisy(k, 20.0, &mut rng));
                Ok(share(answers(w, &w.estimator(assumed * SD)?, frames)?))
            });
        }
    }
}

fn bad_readings(rows: &mut Trials<InverseWorld>) {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let (holds, words) = ("the gauge is named", "the reading of gauge 7");
        rows.refused(format!("a reading of {bad:e}"), holds, words, move |w| {
            let mut y = vec![SD; w.n()];
            y[7] = bad;
            Ok(w.estimator(SD)?.estimate(&y)?.chi2)
        });
    }
    for size in [1e2, 1e4, 1e8] {
        let holds = ("at most 5 % of the answers are sure", 0.05);
        rows.either(format!("random readings of {size:.0e} µε"), holds, move |w| {
            let mut rng = w.rng(37);
            let nowhere = (0..N_FRAMES).map(|_| {
                let mut y = vec![0.0; w.n()];
                add_noise(&mut y, size, &mut rng);
                (vec![w.sites.points()[0]; 9], y)
            });
            let estimator = w.estimator(SD)?;
            let sure = nowhere.filter(|(_, y)| sure(&estimator, y).is_ok());
            Ok(sure.count() as f64 / N_FRAMES as f64)
        });
    }
}
