//! Rows of contacts that come one after another and are followed.

use anyhow::Result;
use hapdef_bench::stats::sorted;
use hapdef_inverse::{Searcher, TrackerParams};

use super::cells::Map;
use super::measured::Measured;
use super::sequence::{Followed, Script};
use super::setup::Bench;
use super::world::Draw;

/// Contacts of most scripts, and how far apart they are at least, m.
const N_CONTACTS: usize = 4;
const GAP_M: f64 = 0.02;

/// How a script is drawn, given the strongest force, N.
type Drawn = fn(&mut Draw<'_>, f64) -> Script;

/// Rows with the seeds of their contacts and of their noise.
const ROWS: [(&str, u64, u64, Drawn); 5] = [
    ("four arriving", 40, 1000, arriving),
    ("two arriving at once", 44, 5000, pair),
    ("four arriving, two at once", 41, 2000, two_pairs),
    ("four arriving, one released", 42, 3000, released),
    ("four arriving, one sliding", 43, 4000, sliding),
];

/// Follows the scripts of every row with the scene's gauges.
pub(super) fn add(bench: &Bench<'_>, map: &Map, measured: &mut Measured) -> Result<()> {
    let run = bench.run;
    run.say("following contacts that arrive one after another");
    let estimator = map.estimator(bench.params())?;
    let mut searcher = Searcher::for_tracker(estimator.clone(), TrackerParams::default())?;
    let strongest_n = run.scene.contact.force_range_n[1];
    let mut times_us = Vec::new();
    for (name, row, stream, drawn) in ROWS {
        let mut draw = bench.drawn().draw(row);
        let mut followed = Followed::default();
        for i in 0..bench.args.scripts as u64 {
            let script = drawn(&mut draw, strongest_n);
            let readings = script.readings(&bench.world, stream + i)?;
            followed.follow(&estimator, &mut searcher, &script, &readings)?;
        }
        measured.add(name, &followed.score);
        times_us.extend(followed.times_us);
    }
    measured.tracking_us = sorted(times_us);
    Ok(())
}

fn arriving(draw: &mut Draw<'_>, strongest_n: f64) -> Script {
    Script::draw(draw, N_CONTACTS, GAP_M, strongest_n)
}

fn pair(draw: &mut Draw<'_>, strongest_n: f64) -> Script {
    Script::draw(draw, 2, GAP_M, strongest_n).two_at_once()
}

fn two_pairs(draw: &mut Draw<'_>, strongest_n: f64) -> Script {
    arriving(draw, strongest_n).two_at_once()
}

fn released(draw: &mut Draw<'_>, strongest_n: f64) -> Script {
    arriving(draw, strongest_n).with_release(draw)
}

fn sliding(draw: &mut Draw<'_>, strongest_n: f64) -> Script {
    loop {
        if let Some(script) = arriving(draw, strongest_n).with_slide(draw) {
            return script;
        }
    }
}
