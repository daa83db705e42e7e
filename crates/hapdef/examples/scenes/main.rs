//! Looks for scenes that are silently wrong, seed after seed: `cargo xtask robustness scenes`.
//!
//!     cargo run --release --example scenes -- --minutes 5 --seed 1
#![expect(clippy::print_stdout, reason = "a program that prints")]
#![expect(clippy::unwrap_used, reason = "it ends where it can't go on")]

mod judge;
mod limb;
#[path = "../../../hapdef-daq/examples/soak/metrics.rs"]
mod metrics;
mod pressed;
mod trial;

use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Parser;
use proptest::test_runner::{Config, RngSeed, TestCaseError, TestError, TestRunner};

use judge::{Honest, tried};
use trial::{Trial, trials};

/// Scenes tried while a failing one is made simpler.
const MAX_SHRINKS: u32 = 40;

/// Scenes at random until the time is over; ends with exit code 1 if one is silently wrong.
#[derive(Parser)]
struct Args {
    /// How long, minutes; one scene at least.
    #[arg(long, default_value_t = 2.0)]
    minutes: f64,
    /// Seed of the first scene; the next has the next.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Failing scenes are written to this file, in the form of tests/it/scene_search.json.
    #[arg(long, default_value = "target/hapdef/scenes.json")]
    failures: PathBuf,
    /// Figures are added to this file.
    #[arg(long)]
    metrics: Option<PathBuf>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let (start, time) = (Instant::now(), Duration::from_secs_f64(60.0 * args.minutes));
    let (mut n_scenes, mut failures) = (0_u64, Vec::new());
    let mut ends = BTreeMap::new();
    while n_scenes == 0 || start.elapsed() < time {
        let seed = args.seed.wrapping_add(n_scenes);
        match scene(seed) {
            Ok(honest) => *ends.entry(format!("{honest:?}")).or_insert(0) += 1,
            Err(failure) => {
                let (why, trial) = *failure;
                println!("seed {seed}: {why}\n  {}", serde_json::to_string(&trial).unwrap());
                failures.push(trial);
            }
        }
        n_scenes += 1;
    }
    println!("{n_scenes} scenes from seed {}: {ends:?}", args.seed);
    if !failures.is_empty() {
        std::fs::create_dir_all(args.failures.parent().unwrap()).unwrap();
        std::fs::write(&args.failures, serde_json::to_vec_pretty(&failures).unwrap()).unwrap();
        println!("failing scenes: {}", args.failures.display());
    }
    let figures = [
        ("stability.scenes", n_scenes as f64, "1"),
        ("stability.scene_failures", failures.len() as f64, "1"),
    ];
    metrics::report(&figures, args.seed, args.metrics.as_deref());
    ExitCode::from(u8::from(!failures.is_empty()))
}

/// The scene of a seed; a failing one is made as simple as it fails still.
fn scene(seed: u64) -> Result<Honest, Box<(String, Trial)>> {
    let config = Config {
        cases: 1,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        max_shrink_iters: MAX_SHRINKS,
        ..Config::default()
    };
    let end = Cell::new(Honest::Refused);
    let outcome = TestRunner::new(config).run(&trials(), |trial| {
        let honest = tried(&trial).map_err(|wrong| TestCaseError::fail(wrong.to_string()))?;
        end.set(honest);
        Ok(())
    });
    match outcome {
        Ok(()) => Ok(end.get()),
        Err(TestError::Fail(why, trial)) => Err(Box::new((why.to_string(), trial))),
        Err(TestError::Abort(why)) => panic!("no scene was drawn: {why}"),
    }
}
