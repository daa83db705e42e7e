//! Rows of contacts that come one after another and are followed.

use anyhow::Result;
use hapdef_bench::stats::sorted;
use hapdef_inverse::{ContactEstimator, Searcher, TrackerParams};

use super::figures::Measured;
use super::sequence::{Followed, Script};
use super::setup::Bench;
use super::world::Draw;

/// How far apart contacts are at least, m.
const GAP_M: f64 = 0.02;

/// A script drawn, given the strongest force, N.
type Drawn = fn(&mut Draw<'_>, f64) -> Script;

/// Rows with the seeds of their contacts and of their noise.
const ROWS: [(&str, u64, u64, Drawn); 5] = [
    ("four arriving", 40, 1000, four),
    ("two arriving at once", 44, 5000, |draw, strongest_n| {
        Script::draw(draw, 2, GAP_M, strongest_n).two_at_once()
    }),
    ("four arriving, two at once", 41, 2000, |draw, strongest_n| {
        four(draw, strongest_n).two_at_once()
    }),
    ("four arriving, one released", 42, 3000, |draw, strongest_n| {
        four(draw, strongest_n).with_release(draw)
    }),
    ("four arriving, one sliding", 43, 4000, |draw, strongest_n| {
        loop {
            if let Some(script) = four(draw, strongest_n).with_slide(draw) {
                return script;
            }
        }
    }),
];

fn four(draw: &mut Draw<'_>, strongest_n: f64) -> Script {
    Script::draw(draw, 4, GAP_M, strongest_n)
}

/// Follows the scripts of every row with the scene's gauges.
pub(super) fn add(
    bench: &Bench<'_>,
    estimator: &ContactEstimator,
    measured: &mut Measured,
) -> Result<()> {
    let run = bench.run;
    run.say("following contacts that arrive one after another");
    let mut searcher = Searcher::for_tracker(estimator.clone(), TrackerParams::default())?;
    let strongest_n = run.scene.contact.force_range_n[1];
    let mut times_us = Vec::new();
    for (name, row, stream, drawn) in ROWS {
        let mut draw = bench.drawn().draw(row);
        let mut followed = Followed::default();
        for i in 0..bench.args.scripts as u64 {
            let script = drawn(&mut draw, strongest_n);
            let readings = script.readings(&bench.rig.world, stream + i)?;
            followed.follow(estimator, &mut searcher, &script, &readings)?;
        }
        measured.rows.push(followed.score.row(name));
        times_us.extend(followed.times_us);
    }
    measured.tracking_us = sorted(times_us);
    Ok(())
}
