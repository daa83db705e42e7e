//! Errors and times of every variant of a scene.

use std::hint::black_box;

use std::path::Path;

use anyhow::{Context, Result};
use hapdef::stages::NetKind;
use hapdef::{Limb, Pipeline, Run, Until};
use hapdef_bench::{Named, pareto_front};
use hapdef_nets::Scratch;
use serde::Serialize;

use super::clock::Quantiles;
use super::peers::Peers;
use super::testset::{Errors, N_DIRECT, TestSet};
use super::unscaled::without_scales;
use super::variants::{Family, Variant, variants};
use crate::run::chain::reconstruction;

/// A variant, measured.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Point {
    pub(super) name: String,
    pub(super) family: Family,
    #[serde(flatten)]
    pub(super) errors: Errors,
    /// From readings to the map.
    #[serde(flatten)]
    pub(super) times: Quantiles,
    /// Of the part behind F_T; not known of other programs.
    pub(super) training_s: Option<f64>,
    /// Bytes of both nets, or of what the method keeps; not known of other programs.
    pub(super) bytes: Option<usize>,
    /// No other method to the whole map is both faster and better: by the map, and by contacts.
    pub(super) on_map_front: bool,
    pub(super) on_contact_front: bool,
}

impl Named for Point {
    fn name(&self) -> &str {
        &self.name
    }
}

/// Every variant of a scene.
pub(super) struct Measured {
    pub(super) done: Pipeline,
    pub(super) points: Vec<Point>,
    /// Why rows of other programs are missing; empty if none is, or none was asked for.
    pub(super) missing: String,
}

/// Runs what is missing of the scene, then measures every variant in `rounds` rounds, with other
/// programs on the same weights if there is a Python, which works in a folder of its own.
pub(super) fn measure(
    run: &Run,
    rounds: usize,
    python: Option<(&Path, &Path)>,
) -> Result<Measured> {
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let done = Pipeline::run(run, &limb, Until::Train)?;
    let tests = TestSet::read(run, &limb, &done)?;
    let mut variants = variants(run, &limb, &done)?;
    run.say(&format!("{} variants: errors", variants.len()));
    let mut errors = Vec::with_capacity(variants.len());
    for variant in &mut variants {
        run.check_stop("the frontier")?;
        errors.push(match variant.passes.is_direct() {
            false => tests.errors(&mut variant.passes, variant.outputs.as_deref())?,
            true => tests.direct_errors(&mut variant.passes)?,
        });
    }
    let (mut peers, missing) = match python {
        Some(python) => start_peers(python, &done, &tests)?,
        None => (None, String::new()),
    };
    run.say("times, one core");
    time(run, &tests, &mut variants, peers.as_mut(), rounds)?;
    let mut points: Vec<Point> = variants.iter().zip(errors).map(point).collect();
    if let Some(peers) = &mut peers {
        points.extend(peer_points(peers, &tests)?);
    }
    mark_fronts(&mut points);
    Ok(Measured { done, points, missing })
}

/// All variants in turn, on one thread; each frame is another press.
fn time(
    run: &Run,
    tests: &TestSet,
    variants: &mut [Variant],
    mut peers: Option<&mut Peers>,
    rounds: usize,
) -> Result<()> {
    let mut map = vec![0.0; tests.n_surface];
    let presses = tests.presses();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut frame = 0;
    for _ in 0..rounds {
        run.check_stop("the frontier")?;
        for variant in &mut *variants {
            let n_outputs = match variant.family {
                Family::Direct => N_DIRECT,
                _ => variant.outputs.as_ref().map_or(map.len(), Vec::len),
            };
            let (passes, times, map) =
                (&mut variant.passes, &mut variant.times, &mut map[..n_outputs]);
            let work = || {
                let press = &presses[frame % presses.len()];
                frame += 1;
                passes.map(&press.readings, map)?;
                black_box(&*map);
                Ok(())
            };
            // the products of a baseline would spread over all threads
            alone.install(|| times.round(work))?;
        }
        if let Some(peers) = &mut peers {
            peers.round()?;
        }
    }
    Ok(())
}

/// Other programs on the scene's own F_T and F_R, or why there are none.
fn start_peers(
    (python, folder): (&Path, &Path),
    done: &Pipeline,
    tests: &TestSet,
) -> Result<(Option<Peers>, String)> {
    let nets = done.nets.as_ref().context("no nets")?;
    let transfer = without_scales(&nets.load(NetKind::Transfer)?)?;
    let map_net = without_scales(&reconstruction(done)?)?;
    let x = &tests.presses().first().context("no presses")?.readings;
    let (mut scratch, mut virtual_um) = (Scratch::default(), vec![0.0; tests.n_virtual]);
    let mut y = vec![0.0; tests.n_surface];
    transfer.forward(x, &mut scratch, &mut virtual_um)?;
    map_net.forward(&virtual_um, &mut scratch, &mut y)?;
    Ok(Peers::if_there(python, folder, [&transfer, &map_net], x, &y))
}

/// Their errors on the same presses, and their times.
fn peer_points(peers: &mut Peers, tests: &TestSet) -> Result<Vec<Point>> {
    let readings = tests.all_readings();
    let names: Vec<String> = peers.rows.keys().cloned().collect();
    let point = |name: &String| {
        let maps = peers.outputs(name, &readings)?;
        let row = &peers.rows[name];
        Ok(Point {
            name: format!("{name} ({})", row.program),
            family: Family::Peer,
            errors: tests.errors_of_maps(&maps)?,
            times: row.times.quantiles(),
            training_s: None,
            bytes: None,
            on_map_front: false,
            on_contact_front: false,
        })
    };
    names.iter().map(point).collect()
}

fn point((variant, errors): (&Variant, Errors)) -> Point {
    Point {
        name: variant.name.clone(),
        family: variant.family,
        errors,
        times: variant.times.quantiles(),
        training_s: Some(variant.training_s),
        bytes: Some(variant.passes.bytes()),
        on_map_front: false,
        on_contact_front: false,
    }
}

fn mark_fronts(points: &mut [Point]) {
    let whole = |p: &Point| !matches!(p.family, Family::Part | Family::Peer);
    let front = |error: fn(&Errors) -> Option<f64>| {
        let error = |p: &Point| error(&p.errors).filter(|_| whole(p)).unwrap_or(f64::NAN);
        pareto_front(&points.iter().map(|p| [p.times.p50_us, error(p)]).collect::<Vec<_>>())
    };
    let (of_map, of_contacts) = (front(|e| e.map_um), front(|e| e.contact_mm));
    for (point, is_on) in points.iter_mut().zip(of_map.into_iter().zip(of_contacts)) {
        (point.on_map_front, point.on_contact_front) = is_on;
    }
}

/// The fastest reduced method within 10 % of the whole f32 net's contact error; without any, that of
/// least error. And the ratio of its error to the whole net's; none where either found no contact.
pub(super) fn best_reduced(points: &[Point]) -> Option<(&Point, f64)> {
    let whole = points.iter().find(|p| p.family == Family::Whole && p.name.ends_with("f32"));
    let whole = whole?.errors.contact_mm?;
    let reduced = points.iter().filter(|p| matches!(p.family, Family::LowRank | Family::Narrow));
    let reduced = reduced.filter_map(|p| Some((p, p.errors.contact_mm? / whole)));
    let reduced: Vec<(&Point, f64)> = reduced.collect();
    let within = reduced.iter().filter(|(_, ratio)| *ratio <= 1.1);
    let fastest = within.min_by(|a, b| a.0.times.p50_us.total_cmp(&b.0.times.p50_us));
    let least = reduced.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    fastest.or(least).copied()
}
