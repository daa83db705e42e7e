//! What a stream says of a limb that random scripts press on the simulated rig: whether a force is ever beyond
//! what the scene allows, how many frames nothing explains and for how long, how soon a press is reported and let
//! go, whether a replay of the same readings finds the same, and how soon a controller is told to stop.
//!
//! `cargo xtask soak` runs this on the bundled limbs and keeps its figures.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a measurement that prints, and ends where something is not as it has to be"
)]

mod causes;
mod judge;
#[path = "../../../hapdef-daq/examples/soak/metrics.rs"]
mod metrics;
mod play;
mod stop_signal;

use std::path::{Path, PathBuf};

use clap::Parser;
use hapdef::{OpenParams, OpenScene};
use rayon::prelude::*;

use judge::Seen;
use play::{Limb, replay_equal};
use stop_signal::stops;

/// The first script's seed is so many times the seed: those below were looked at when the tracker was mended.
const FIRST: u64 = 1000;

/// A controller is told of a touch of 1 N within this, ms.
const STOP_MS: f64 = 5.0;

/// Random scripts on the simulated rig.
#[derive(Parser)]
struct Args {
    /// Scene files.
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Scripts on each limb.
    #[arg(long, default_value_t = 100)]
    scripts: u64,
    /// Length of each, s.
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// How long a stream runs that is replayed, on the first limb, s.
    #[arg(long, default_value_t = 60.0)]
    replay_s: f64,
    /// How long the first limb is pressed in real time for the stop signal, s.
    #[arg(long, default_value_t = 60.0)]
    stop_s: f64,
    /// Seed of the scripts.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints each script's figures, too.
    #[arg(long)]
    verbose: bool,
    /// Folder of results, the cache in it.
    #[arg(long, default_value = "target/hapdef")]
    results: PathBuf,
    /// Figures are added to this file.
    #[arg(long)]
    metrics: Option<PathBuf>,
}

fn main() {
    let args = Args::parse();
    let limbs: Vec<Limb> = args.scenes.iter().map(|scene| opened(scene, &args.results)).collect();
    let (mut all, mut worst_pct) = (Seen::default(), 0.0_f64);
    for limb in &limbs {
        let seen = pressed(limb, &args);
        println!("{}, {} scripts of {} s: {seen}", limb.name(), args.scripts, args.seconds);
        print!("{}", seen.causes);
        worst_pct = worst_pct.max(seen.misfit_pct());
        all.add(seen);
    }
    let (n_equal, n) = replay_equal(&limbs[0], args.seed, args.replay_s);
    println!("live and replayed: {n_equal} of {n} frames alike");
    let stops = stops(&limbs[0], FIRST * args.seed, args.stop_s);
    let [stop_p50, stop_p99] = stops.to_stop_ms.quantiles();
    let [_, any_p99] = stops.to_any_ms.quantiles();
    println!(
        "stop signal: {} touches of 1 N and more, {} stops without one",
        stops.n_touches, stops.n_false
    );
    let [detect_p50, detect_p99] = all.detect_ms.quantiles();
    let [let_go_p50, let_go_p99] = all.let_go_ms.quantiles();
    let [off_p50, _] = all.off_mm.quantiles();
    let figures = [
        ("trust.phantom_frames", all.n_beyond as f64, "1"),
        ("trust.misfit_pct", worst_pct, "%"),
        ("trust.misfit_longest_ms", all.longest_misfit_ms as f64, "ms"),
        ("trust.detect_lag_p50_ms", detect_p50, "ms"),
        ("trust.detect_lag_p99_ms", detect_p99, "ms"),
        ("trust.let_go_lag_p50_ms", let_go_p50, "ms"),
        ("trust.let_go_lag_p99_ms", let_go_p99, "ms"),
        ("trust.off_p50_mm", off_p50, "mm"),
        ("trust.ghosts_pct", all.ghosts_pct(), "%"),
        ("robot.stop_signal_p50_ms", stop_p50, "ms"),
        ("robot.stop_signal_p99_ms", stop_p99, "ms"),
        ("robot.stop_within_5ms_pct", stops.to_stop_ms.within_pct(STOP_MS), "%"),
        ("robot.not_clear_p99_ms", any_p99, "ms"),
        ("robot.not_clear_within_5ms_pct", stops.to_any_ms.within_pct(STOP_MS), "%"),
        ("robot.stop_signal_false", stops.n_false as f64, "1"),
        ("trust.replay_equal_pct", 100.0 * n_equal as f64 / n as f64, "%"),
    ];
    metrics::report(&figures, args.seed, args.metrics.as_deref());
}

fn opened(scene: &Path, results: &Path) -> Limb {
    let params = OpenParams { results: results.to_owned(), ..OpenParams::default() };
    let shown = scene.display();
    let scene = OpenScene::with_params(scene, params).unwrap_or_else(|e| panic!("{shown}: {e}"));
    Limb::new(scene)
}

/// All scripts on one limb, each on a core of its own; what was seen does not depend on how many there are.
fn pressed(limb: &Limb, args: &Args) -> Seen {
    let seeds: Vec<u64> = (0..args.scripts).map(|i| FIRST * args.seed + i).collect();
    let each: Vec<Seen> =
        seeds.par_iter().map(|seed| limb.press(*seed, args.seconds).seen).collect();
    let mut all = Seen::default();
    for (seed, seen) in seeds.iter().zip(each) {
        if args.verbose {
            println!("script {seed}: {seen}");
        }
        all.add(seen);
    }
    all
}
