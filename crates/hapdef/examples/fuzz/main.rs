//! Damaged inputs for every reader of hapdef, on stable Rust: `cargo xtask fuzz`.
//!
//!     cargo run --release --example fuzz -- --seconds 10 --target decoder
#![expect(clippy::print_stdout, reason = "a program that prints")]
#![expect(clippy::print_stderr, reason = "a program that prints")]
#![expect(clippy::unwrap_used, reason = "it ends where it can't go on")]

mod driver;
#[path = "../../../hapdef-daq/examples/soak/metrics.rs"]
mod metrics;
mod mutate;
#[path = "../../../../fuzz/src/targets.rs"]
mod targets;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use rustix::process::{Resource, Rlimit, setrlimit};

use driver::{corpus, fuzz};
use targets::TARGETS;

/// Address space that a run may have: what asks for more is refused and ends the program.
const MAX_BYTES: u64 = 4 << 30;

/// Damaged inputs for readers.
#[derive(Parser)]
struct Args {
    /// How long each target is run, s.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// One target instead of all.
    #[arg(long, value_parser = TARGETS.map(|target| target.name))]
    target: Option<String>,
    /// Seed of the mutations.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where inputs that panic are written.
    #[arg(long, default_value = "target/hapdef/fuzz")]
    failures: PathBuf,
    /// Figures are added to this file.
    #[arg(long)]
    metrics: Option<PathBuf>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let limit = Rlimit { current: Some(MAX_BYTES), maximum: Some(MAX_BYTES) };
    setrlimit(Resource::As, limit).unwrap();
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    let time = Duration::from_secs_f64(args.seconds);
    let (mut n_panics, mut n_executions) = (0, 0);
    for target in TARGETS {
        if args.target.as_deref().is_some_and(|name| name != target.name) {
            continue;
        }
        let seeds = corpus(&home.join(target.name));
        let outcome = fuzz(target, &seeds, args.seed, |_, elapsed| elapsed >= time, &args.failures);
        println!(
            "{:12} {:9} executions, {} panics, {:.1} ms for the slowest, {} MiB at most so far",
            target.name,
            outcome.n_executions,
            outcome.n_panics,
            outcome.slowest.as_secs_f64() * 1e3,
            peak_mib(),
        );
        n_panics += outcome.n_panics;
        n_executions += outcome.n_executions;
    }
    let figures = [
        ("fuzz.panics", n_panics as f64, "1"),
        ("fuzz.executions", n_executions as f64, "1"),
        ("fuzz.peak_rss_mib", peak_mib() as f64, "MiB"),
    ];
    metrics::report(&figures, args.seed, args.metrics.as_deref());
    ExitCode::from(u8::from(n_panics > 0))
}

/// Most memory that the program had, MiB.
fn peak_mib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    kib.unwrap_or(0) / 1024
}
