//! A tracker fed with what no contact makes.

use hapdef_bench::robustness::MustHold;
use hapdef_inverse::{
    ContactTracker, SearchOutcome, Searcher, TrackedFrame, TrackerParams, Verdict,
};
use rand::RngExt;

use super::super::table::Trials;
use super::world::{InverseWorld, SD, add_noise};
use crate::error::ReproError;

const FOUND: MustHold = ("mm from a held contact to the one found", 10.0);

/// What becomes of a frame, by its index.
type Change = fn(usize, &mut [f64]);

pub(super) fn add(rows: &mut Trials<InverseWorld>) {
    let nothing: Change = |_, _| ();
    let plays: [(&str, f64, f64, Change); 9] = [
        ("20 N, nothing else", SD, 20.0, nothing),
        ("20 N, noise assumed 10 × too large", 10.0 * SD, 20.0, nothing),
        ("20 N, noise assumed 10 × too small", 0.1 * SD, 20.0, nothing),
        ("1e5 N", SD, 1e5, nothing),
        ("20 N, one gauge NaN", SD, 20.0, |_, y| y[5] = f64::NAN),
        ("20 N, one gauge infinite now and then", SD, 20.0, |i, y| {
            y[i % 10] = if i % 3 == 0 { f64::INFINITY } else { y[i % 10] };
        }),
        ("20 N, all gauges but three NaN", SD, 20.0, |_, y| {
            y[3..].fill(f64::NAN);
        }),
        ("20 N, every 50th frame of 1e9", SD, 20.0, |i, y| {
            y.iter_mut().for_each(|y| *y = if i % 50 == 0 { 1e9 } else { *y });
        }),
        ("20 N, after 1000 frames of noise of 1e6", SD, 20.0, |i, y| {
            let wave = |g: usize| 1e6 * ((g + 1) as f64 * 0.7 * i as f64).sin();
            let is_garbage = i < 1000;
            y.iter_mut()
                .enumerate()
                .for_each(|(g, y)| *y += if is_garbage { wave(g) } else { 0.0 });
        }),
    ];
    for (extreme, assumed, force_n, change) in plays {
        rows.either(extreme, FOUND, move |w| held(w, assumed, force_n, change));
    }
    quiet(rows);
    garbage(rows);
    refusals(rows);
}

/// A tracker that assumes noise of this deviation, and what searches for it.
fn started(world: &InverseWorld, assumed: f64) -> Result<(Searcher, ContactTracker), ReproError> {
    let (estimator, params) = (world.estimator(assumed)?, TrackerParams::default());
    let tracker = ContactTracker::new(&estimator, params)?;
    Ok((Searcher::for_tracker(estimator, params)?, tracker))
}

/// Feeds a frame and does the search that is asked for.
fn step(
    searcher: &mut Searcher,
    tracker: &mut ContactTracker,
    y: &[f64],
) -> Result<TrackedFrame, ReproError> {
    let frame = tracker.step(y, None)?.clone();
    let mut outcome = SearchOutcome::default();
    let is_asked = match tracker.wanted_search() {
        Some(request) => searcher.search(&request, &mut outcome).map(|()| true)?,
        None => false,
    };
    if is_asked {
        tracker.adopt(&outcome);
    }
    Ok(frame)
}

/// A contact that comes after a second and a half and is held for another half: how far from it the
/// tracker's is then, mm.
fn held(
    world: &InverseWorld,
    assumed: f64,
    force_n: f64,
    change: Change,
) -> Result<f64, ReproError> {
    let (mut searcher, mut tracker) = started(world, assumed)?;
    let mut rng = world.rng(51);
    let point = world.draw(1, 0.0, &mut rng)[0];
    for index in 0..2000 {
        let part = (index as f64 - 1500.0) / 30.0;
        let mut y = world.readings(&[(point, force_n * part.clamp(0.0, 1.0))]);
        add_noise(&mut y, SD, &mut rng);
        change(index, &mut y);
        step(&mut searcher, &mut tracker, &y)?;
    }
    let found = tracker.last();
    if let Verdict::NotIdentifiable(why) = found.verdict {
        return Err(ReproError::NotIdentifiable { why });
    }
    let x = world.map.skin().position(&point);
    Ok(match found.contacts.as_slice() {
        [one] => (one.contact.position_m - x).norm() * 1e3,
        _ => f64::INFINITY,
    })
}

/// Nothing touches.
fn quiet(rows: &mut Trials<InverseWorld>) {
    for (words, assumed) in [("right", 1.0), ("10 × too large", 10.0), ("10 × too small", 0.1)] {
        let holds = ("at most 1 % of the frames have a contact and are sure", 0.01);
        rows.either(format!("nothing touches, noise assumed {words}"), holds, move |w| {
            let (mut searcher, mut tracker) = started(w, assumed * SD)?;
            let (mut rng, mut n_wrong) = (w.rng(52), 0);
            for _ in 0..2000 {
                let mut y = vec![0.0; w.n()];
                add_noise(&mut y, SD, &mut rng);
                let found = step(&mut searcher, &mut tracker, &y)?;
                let is_sure = !matches!(found.verdict, Verdict::NotIdentifiable(_));
                n_wrong += usize::from(is_sure && !found.contacts.is_empty());
            }
            Ok(n_wrong as f64 / 2000.0)
        });
    }
}

/// Noise whose size jumps by up to twelve decades.
fn garbage(rows: &mut Trials<InverseWorld>) {
    let holds = ("numbers are finite; work of a frame over what is allowed", 1.0);
    rows.accurate("noise of 1e-3 … 1e9, another size every 97 frames", holds, |w| {
        let (_, mut tracker) = started(w, SD)?;
        let (mut rng, mut size, mut most) = (w.rng(53), 1.0, 0);
        for index in 0..4000 {
            if index % 97 == 0 {
                size = 10.0_f64.powf(rng.random_range(-3.0..9.0));
            }
            let mut y = vec![0.0; w.n()];
            add_noise(&mut y, size, &mut rng);
            let found = tracker.step(&y, None)?;
            if !is_finite(found) {
                return Ok(f64::NAN);
            }
            let info = &found.info;
            most = most.max(info.n_trials + info.n_pair_rows + 8 * info.n_scans);
        }
        Ok(most as f64 / TrackerParams::default().steps_per_frame as f64)
    });
}

fn is_finite(found: &TrackedFrame) -> bool {
    let contacts = found.contacts.iter().all(|c| {
        let c = &c.contact;
        c.force_n.is_finite() && c.position_m.iter().all(|x| x.is_finite())
    });
    contacts && found.residual.iter().all(|r| r.is_finite()) && !found.chi2.is_nan()
}

fn refusals(rows: &mut Trials<InverseWorld>) {
    for (extreme, n_live) in [("a frame of NaN", 0), ("a frame with two gauges", 2)] {
        rows.refused(extreme, "the frame is refused", "gauges are alive", move |w| {
            let (_, mut tracker) = started(w, SD)?;
            let mut y = vec![0.0; w.n()];
            y[n_live..].fill(f64::NAN);
            tracker.step(&y, None)?;
            Ok(1.0)
        });
    }
    rows.either("a reading of 1e300", ("refused, or all numbers finite", 0.0), |w| {
        let (_, mut tracker) = started(w, SD)?;
        let mut n_bad = 0;
        for index in 0..500 {
            let mut y = vec![0.0; w.n()];
            y[7] = if index > 200 { 1e300 } else { 0.0 };
            n_bad += usize::from(!is_finite(tracker.step(&y, None)?));
        }
        Ok(n_bad as f64)
    });
}
