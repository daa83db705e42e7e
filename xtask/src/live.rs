//! How long it takes from a frame to its contacts, and what real-time priority changes about it.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::metrics;
use crate::pipeline::finish;
use crate::tool::{release_binary, release_example, results, root, run as run_tool};

/// Lines of a stream after which a program has touched what it uses, and has given back what it does not: without
/// real-time priority that took 8 to 20 s after a scene was solved.
const N_FRAMES: usize = 25_000;

/// `cargo xtask bench live`: bundles the scene, then a device on a pseudo-terminal plays presses.
pub(crate) fn bench(
    scene: Option<&Path>,
    seed: u64,
    seconds: Option<u64>,
    rest: &[String],
) -> Result<()> {
    let bundle = bundle(scene)?;
    let mut command = Command::new(release_example("latency")?);
    command.arg(&bundle).args(["--seed", &seed.to_string()]);
    if let Some(seconds) = seconds {
        command.args(["--seconds", &seconds.to_string()]);
    }
    command.arg("--metrics").arg(results().join("metrics.json"));
    finish(command.args(rest))
}

/// `cargo xtask bench realtime`: the memory that `--realtime` locks, then the same device with a busy loop for
/// each core beside it.
pub(crate) fn bench_realtime(
    scene: Option<&Path>,
    seed: u64,
    seconds: Option<u64>,
    rest: &[String],
) -> Result<()> {
    // What the first start solves the others find solved: it takes gigabytes.
    resident_mb(scene, &[])?;
    let extra_mb = resident_mb(scene, &["--realtime", "50"])? - resident_mb(scene, &[])?;
    let figures = [("trust.realtime_extra_mb", extra_mb, "MB")];
    metrics::report(&figures, seed, Some(&results().join("metrics.json")));
    bench(scene, seed, seconds, &[&["--busy".to_owned()], rest].concat())
}

/// The memory that a simulated limb's `hapdef live` has after that many frames; its peak would be that of solving.
fn resident_mb(scene: Option<&Path>, words: &[&str]) -> Result<f64> {
    let mut command = Command::new(release_binary("hapdef")?);
    command.arg("live").arg(scene.unwrap_or(&bundled())).args(["--sim", "--json"]).args(words);
    let mut live = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
    let mut lines = BufReader::new(live.stdout.take().context("its output")?).lines();
    let n_frames = lines.by_ref().take(N_FRAMES).map_while(std::io::Result::ok).count();
    let status = fs::read_to_string(format!("/proc/{}/status", live.id()))?;
    live.kill()?;
    live.wait()?;
    ensure!(n_frames == N_FRAMES, "hapdef live ended after {n_frames} lines");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kb =
        line.and_then(|line| line.split_whitespace().next()).context("no VmRSS in its status")?;
    Ok(kb.parse::<f64>()? / 1024.0)
}

fn bundle(scene: Option<&Path>) -> Result<PathBuf> {
    let folder = results();
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let bundle = folder.join("bench.hapdef");
    let mut command = Command::new(release_binary("hapdef")?);
    command.arg("bundle").arg(scene.unwrap_or(&bundled()));
    run_tool(command.arg("-o").arg(&bundle))?;
    Ok(bundle)
}

fn bundled() -> PathBuf {
    root().join("fixtures/shin/placed.json")
}
