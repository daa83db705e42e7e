//! Channels that saturate, die or give no number.

use hapdef_bench::robustness::MustHold;
use hapdef_inverse::{Conditioned, Conditioner, ConditionerParams, TouchPhase};

use super::super::table::Trials;
use super::world::{InverseWorld, add_noise};
use crate::error::ReproError;

const N: usize = 10;
const PERIOD_S: f64 = 1e-3;

/// The tare's mean of 200 frames and the row's own of 500 leave 0.08.
const KEPT: MustHold = ("µε that live gauges miss of a contact; bad ones are not live", 0.5);
const TOUCHED: usize = 1000;
const N_FRAMES: usize = 3000;

/// What becomes of gauge `.1`'s value in frame `.0`; `None` where nothing.
type Fault = fn(usize, usize) -> Option<f64>;

pub(super) fn add(rows: &mut Trials<InverseWorld>) {
    let of: [(&str, f64, Fault); 11] = [
        ("no fault", 1.0, |_, _| None),
        ("noise assumed 10 × too small", 0.1, |_, _| None),
        ("noise assumed 10 × too large", 10.0, |_, _| None),
        ("four gauges saturated while touched", 1.0, |i, g| {
            (i >= TOUCHED && g < 4).then_some(500.0)
        }),
        ("four gauges saturated from the start", 1.0, |_, g| (g < 4).then_some(-500.0)),
        ("seven gauges saturated while touched", 1.0, |i, g| {
            (i >= TOUCHED && g < 7).then_some(500.0)
        }),
        ("three gauges repeat a value from the start", 1.0, |_, g| (g < 3).then_some(17.0)),
        ("three gauges repeat a value while touched", 1.0, |i, g| {
            (i >= TOUCHED && g < 3).then_some(17.0)
        }),
        ("one gauge NaN from frame 500 on", 1.0, |i, g| (i >= 500 && g == 2).then_some(f64::NAN)),
        ("one gauge infinite from frame 500 on", 1.0, |i, g| {
            (i >= 500 && g == 2).then_some(f64::INFINITY)
        }),
        ("one gauge NaN from the start", 1.0, |_, g| (g == 2).then_some(f64::NAN)),
    ];
    for (extreme, assumed, fault) in of {
        rows.either(extreme, KEPT, move |w| Ok(play(w, assumed, fault)?.0));
    }
    // converters that hang
    let extreme = "all gauges repeat their values from frame 500 on";
    rows.either(extreme, ("gauges that are still live", 0.0), |w| {
        let (_, out) = play(w, 1.0, |i, _| (i >= 500).then_some(3.0))?;
        Ok(out.live.iter().filter(|live| **live).count() as f64)
    });
    // beyond any converter, without declared limits: refused or masked, never passed on
    rows.either("one gauge at 1e300", ("readings that are not finite", 0.0), |w| {
        let (_, out) = play(w, 1.0, |i, g| (i >= 500 && g == 2).then_some(1e300))?;
        let numbers = out.readings.iter().chain(&out.baseline_sd);
        Ok(numbers.filter(|v| !v.is_finite()).count() as f64)
    });
}

/// Three seconds, touched after the first: what live gauges miss of the contact on average over the
/// last half second, infinite where a bad gauge is live; and the last frame.
fn play(
    world: &InverseWorld,
    assumed: f64,
    fault: Fault,
) -> Result<(f64, Conditioned), ReproError> {
    let params = ConditionerParams {
        rails: vec![(-500.0, 500.0); N],
        ..ConditionerParams::new(vec![assumed; N], PERIOD_S)
    };
    let mut conditioner = Conditioner::new(params)?;
    let mut out = conditioner.output();
    let (mut rng, mut sums) = (world.rng(71), vec![0.0; N]);
    for index in 0..N_FRAMES {
        let signal = |g: usize| {
            let contact = if index < TOUCHED { 0.0 } else { contact(g) };
            100.0 - 20.0 * g as f64 + contact
        };
        let mut raw: Vec<f64> = (0..N).map(signal).collect();
        add_noise(&mut raw, 1.0, &mut rng);
        for (g, raw) in raw.iter_mut().enumerate() {
            *raw = fault(index, g).unwrap_or(*raw);
        }
        conditioner.step_into(&raw, None, &mut out)?;
        if index >= N_FRAMES - 500 {
            sums.iter_mut().zip(&out.readings).for_each(|(s, r)| *s += r / 500.0);
        }
    }
    if out.phase == TouchPhase::Taring {
        return Err(ReproError::Taring { frames: N_FRAMES });
    }
    let missed = (0..N).filter(|&g| out.live[g]).map(|g| match fault(N_FRAMES - 1, g) {
        Some(_) => f64::INFINITY,
        None => (sums[g] - contact(g)).abs(),
    });
    Ok((missed.fold(0.0, f64::max), out))
}

/// A contact of some tens of µε, on some gauges hardly seen.
fn contact(gauge: usize) -> f64 {
    40.0 * (1.3 * gauge as f64).cos()
}
