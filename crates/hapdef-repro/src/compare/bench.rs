//! `bench-inverse`: time and allocations of a frame by superposition.

use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, ensure};
use clap::Args;
use hapdef::Limb;
use hapdef::touch::{estimator_params, response_map};
use hapdef_bench::stats::{median, quantile, sorted};
use hapdef_cli::SceneArgs;
use hapdef_inverse::{
    BackgroundSearch, ContactEstimate, ContactEstimator, ContactTracker, EstimatorParams,
    ModelError, NoiseParams, ResponseMap, ScanSites, Searcher, TrackerParams,
};
use rand_distr::{Distribution, StandardNormal};

use super::cells;
use super::sequence::Script;
use super::world::{Draw, TrueContact};
use crate::allocations::allocations;
use crate::run::facts;

/// Sites of the scans.
const N_SITES: usize = 800;

/// Relative error of the map that the estimator assumes, as after a calibration with 3,000 presses.
const MAP_ERROR: f64 = 0.01;

/// Arguments of `bench-inverse`.
#[derive(Args, Clone, Debug)]
pub(crate) struct BenchInverseArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scripts of four contacts that arrive one after another.
    #[arg(long, default_value_t = 60)]
    scripts: usize,
    /// Cold pairs.
    #[arg(long, default_value_t = 200)]
    pairs: usize,
    /// Seed of what is pressed.
    #[arg(long, default_value_t = 8000)]
    test_seed: u64,
}

/// Measures and prints METRIC lines.
pub(crate) fn run(args: &BenchInverseArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let contact = &run.scene.contact;
    let map = Arc::new(response_map(&limb, contact.tip_radius_m, run.threads)?);
    let noise_ue = run.scene.rig.electronics.noise_ue;
    ensure!(noise_ue > 0.0, "rig.electronics.noise_ue: expected above 0");
    let estimator = estimator(&map, noise_ue, estimator_params(&run.scene))?;
    let presses = Presses { map: &map, noise_ue };
    let mut log = facts::log_of(&run, args.test_seed);
    let mut draw = Draw::new(map.skin(), args.test_seed);
    let mut frames = Vec::new();
    for _ in 0..args.scripts {
        let script = Script::draw(&mut draw, 4, 0.02, contact.force_range_n[1]);
        frames.push(presses.frames(&script, &mut draw));
    }
    let tracked = track(&estimator, &TrackerParams::default(), &frames)?;
    let times = sorted(tracked.times_us.iter().copied());
    log.value("inverse.track_p50_us", quantile(&times, 0.5), "µs")?;
    log.value("inverse.track_p99_us", quantile(&times, 0.99), "µs")?;
    log.value("inverse.frame_max_us", quantile(&times, 0.9999), "µs")?;
    let drawn = cells::sets(&mut draw, args.pairs, 2, [[5.0, 34.0]; 4], [0.012, f64::MAX], 0.0);
    let cold_ms = cold_pair_ms(&estimator, &presses, &drawn, &mut draw)?;
    log.value("inverse.cold_pair_ms", cold_ms, "ms")?;
    let per_frame = tracked.n_allocations as f64 / times.len() as f64;
    log.value("inverse.allocs_per_frame", per_frame, "1")?;
    println!("{} frames, {} full searches on a second thread", times.len(), tracked.n_searches);
    Ok(log.append_to(&args.scene.results.join("metrics.json"))?)
}

/// An estimator on a map that is taken to be as near as after a calibration, under white noise.
pub(crate) fn estimator(
    map: &Arc<ResponseMap>,
    noise_ue: f64,
    params: EstimatorParams,
) -> Result<ContactEstimator> {
    let sites = Arc::new(ScanSites::farthest(map.skin(), N_SITES)?);
    let noise = NoiseParams {
        model_error: ModelError { relative: MAP_ERROR, ..ModelError::default() },
        ..NoiseParams::uniform(map.n_gauges(), noise_ue)
    };
    Ok(ContactEstimator::new(map.clone(), sites, noise, params)?)
}

/// Readings on the map itself, with noise.
pub(crate) struct Presses<'a> {
    pub(crate) map: &'a ResponseMap,
    pub(crate) noise_ue: f64,
}

impl Presses<'_> {
    fn reading(&self, contacts: &[TrueContact], forces_n: &[f64], draw: &mut Draw<'_>) -> Vec<f64> {
        let mut sum = vec![0.0; self.map.n_gauges()];
        for (contact, force_n) in contacts.iter().zip(forces_n) {
            for (sum, g) in sum.iter_mut().zip(self.map.normal(&contact.point)) {
                *sum += force_n * g;
            }
        }
        for sum in &mut sum {
            let noise: f64 = StandardNormal.sample(&mut draw.rng);
            *sum += self.noise_ue * noise;
        }
        sum
    }

    /// Readings of every frame of a script.
    pub(crate) fn frames(&self, script: &Script, draw: &mut Draw<'_>) -> Vec<Vec<f64>> {
        (0..script.n_frames())
            .map(|frame| self.reading(&script.contacts, &script.forces_n(frame), draw))
            .collect()
    }
}

/// What following scripts took.
pub(crate) struct Tracked {
    /// Of every frame of every script, µs.
    pub(crate) times_us: Vec<f64>,
    n_allocations: u64,
    n_searches: usize,
}

/// Follows every script with the full searches on a second thread, as a robot would.
pub(crate) fn track(
    estimator: &ContactEstimator,
    params: &TrackerParams,
    scripts: &[Vec<Vec<f64>>],
) -> Result<Tracked> {
    let n_frames = scripts.iter().map(Vec::len).sum();
    let mut tracked =
        Tracked { times_us: Vec::with_capacity(n_frames), n_allocations: 0, n_searches: 0 };
    let mut background =
        BackgroundSearch::start(Searcher::for_tracker(estimator.clone(), *params)?)?;
    for frames in scripts {
        let mut tracker = ContactTracker::new(estimator, *params)?;
        for readings in frames {
            let (before, start) = (allocations(), Instant::now());
            background.poll(|outcome| {
                tracker.adopt(outcome);
            })?;
            tracker.step(readings, None)?;
            if let Some(request) = tracker.wanted_search() {
                tracked.n_searches += usize::from(background.submit(&request));
            }
            let time_us = start.elapsed().as_secs_f64() * 1e6;
            tracked.n_allocations += allocations() - before;
            tracked.times_us.push(time_us);
        }
    }
    Ok(tracked)
}

/// Median time of a pair that nothing is known of.
fn cold_pair_ms(
    estimator: &ContactEstimator,
    presses: &Presses<'_>,
    drawn: &[Vec<TrueContact>],
    draw: &mut Draw<'_>,
) -> Result<f64> {
    let mut scratch = estimator.scratch();
    let mut estimate = ContactEstimate::default();
    let mut times_ms = Vec::with_capacity(drawn.len());
    for contacts in drawn {
        let forces: Vec<f64> = contacts.iter().map(|c| c.force_n).collect();
        let readings = presses.reading(contacts, &forces, draw);
        let time_us = cells::estimate_us(estimator, &readings, &mut scratch, &mut estimate)?;
        times_ms.push(time_us * 1e-3);
    }
    Ok(median(times_ms))
}
