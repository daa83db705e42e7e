//! The promises of acquisition and recording, at length: seeded damage, a device on a pty, kill -9.
//!
//! `cargo xtask soak [--short]` runs this and keeps its figures.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a measurement that prints, and ends where something is not as it has to be"
)]

mod kill;
mod metrics;
mod proc;
mod stream;
#[path = "../../tests/it/support/mod.rs"]
mod support;
mod wire;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

const USAGE: &str = "soak [--short] [--seed N] [--seconds N] [--kills N] [--frames N] \
     [--garbage-mib N] [--metrics FILE] [--realtime PRIORITY]";
/// Nothing older than this may be lost when the process is killed.
const MOST_LOST_MS: f64 = 150.0;
/// Packets lost for each one that was hit, and undamaged ones until packets come through again.
const MOST_LOSS_RATIO: f64 = 1.03;
const MOST_RELOCK: u64 = 2;
/// Memory that counts as flat.
const MOST_GROWTH_MIB: f64 = 4.0;
/// Share of a core that acquisition may take.
const MOST_CPU_PCT: f64 = 15.0;

/// How long.
struct Plan {
    is_short: bool,
    seed: u64,
    stream: Duration,
    n_kills: u32,
    n_frames: u32,
    n_garbage_mib: u32,
    metrics: Option<PathBuf>,
    realtime: Option<u8>,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [what, path] = &words[..]
        && what == kill::CHILD
    {
        kill::child(path.as_ref());
        return ExitCode::SUCCESS;
    }
    let plan = plan(&words);
    let wire = wire::run(plan.n_frames, plan.seed);
    println!("wire: {wire:?}");
    let garbage = wire::garbage(plan.n_garbage_mib, plan.seed);
    println!("garbage: {garbage:?}");
    let stream = stream::run(plan.stream, plan.realtime);
    println!("stream: {stream:?}");
    let kill9 = kill::run(plan.n_kills);
    println!("kill -9 × {}: {kill9:?}", plan.n_kills);
    let n_wrong = wire.n_wrong + garbage.n_wrong + stream.n_wrong + kill9.n_wrong;
    let n_unaccounted = wire.n_unaccounted + stream.n_unaccounted;
    let figures = [
        ("soak.wrong_frames", n_wrong as f64, "1"),
        ("soak.unaccounted", n_unaccounted as f64, "1"),
        ("soak.lost", stream.n_lost as f64, "1"),
        ("soak.kill9_worst_ms", kill9.worst_ms, "ms"),
        ("soak.rss_growth_mib", stream.rss_growth_mib, "MiB"),
        ("soak.cpu_pct", stream.reader_cpu_pct, "%"),
    ];
    metrics::report(&figures, plan.seed, plan.metrics.as_deref());
    let promises = [
        ("no wrong frame", n_wrong == 0),
        ("every loss counted", n_unaccounted == 0),
        ("no more lost than was hit", wire.worst_loss_ratio <= MOST_LOSS_RATIO),
        ("locked again at once", wire.worst_relock <= MOST_RELOCK),
        ("nothing old lost by kill -9", kill9.worst_ms <= MOST_LOST_MS),
        ("memory flat with garbage", garbage.rss_growth_mib <= MOST_GROWTH_MIB),
        ("memory flat at 1 kHz", stream.rss_growth_mib <= MOST_GROWTH_MIB),
    ];
    // These depend on what else the machine does: a short run, which shares it, only tells them.
    let targets = [
        ("nothing lost at 1 kHz", stream.n_lost == 0),
        ("acquisition below 15 % of a core", stream.reader_cpu_pct < MOST_CPU_PCT),
    ];
    for (what, is_met) in promises.iter().chain(&targets) {
        println!("{what}: {}", if *is_met { "met" } else { "not met" });
    }
    if promises.iter().any(|(_, is_kept)| !is_kept) {
        println!("a promise is broken: see the figures above");
        return ExitCode::FAILURE;
    }
    if !plan.is_short && targets.iter().any(|(_, is_met)| !is_met) {
        println!("a target is not met: see the figures above, and run it on a machine at rest");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

fn plan(words: &[String]) -> Plan {
    let is_short = words.iter().any(|word| word == "--short");
    let value = |name: &str| words.iter().skip_while(|word| *word != name).nth(1);
    let number = |name: &str, short: u64, long: u64| {
        let value = value(name);
        value.map_or(if is_short { short } else { long }, |v| v.parse().expect(USAGE))
    };
    Plan {
        is_short,
        seed: number("--seed", 1, 1),
        stream: Duration::from_secs(number("--seconds", 20, 600)),
        n_kills: number("--kills", 8, 200) as u32,
        n_frames: number("--frames", 40_000, 400_000) as u32,
        // 100 MB.
        n_garbage_mib: number("--garbage-mib", 10, 96) as u32,
        metrics: value("--metrics").map(PathBuf::from),
        realtime: value("--realtime").map(|v| v.parse().expect(USAGE)),
    }
}
