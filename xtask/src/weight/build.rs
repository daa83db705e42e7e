//! Builds of layers from nothing.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};

use super::layers::Layers;
use crate::tool::{cargo, root, run, target_dir};

/// What a release build of a layer takes and leaves.
pub(super) struct Built {
    pub(super) seconds: f64,
    /// Of its rlib and of those of all crates that it is built with.
    pub(super) bytes: u64,
}

impl Built {
    /// Millions of bytes.
    pub(super) fn megabytes(&self) -> f64 {
        self.bytes as f64 * 1e-6
    }
}

/// Builds a layer in release from nothing, in a folder that is removed again.
pub(super) fn measure(layers: &Layers) -> Result<Built> {
    let folder = target_dir()?.join(format!("weight-{}", std::process::id()));
    let mut command = cargo(&["build", "--quiet", "--release", "--locked", "--lib"]);
    command.args(layers.words()).env("CARGO_TARGET_DIR", &folder);
    let start = Instant::now();
    let built = run(&mut command).map(|()| start.elapsed().as_secs_f64());
    let bytes = rlib_bytes(&folder.join("release/deps"));
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
    }
    Ok(Built { seconds: built?, bytes: bytes? })
}

fn rlib_bytes(folder: &Path) -> Result<u64> {
    let mut bytes = 0;
    let entries = fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))?;
    for entry in entries {
        let entry = entry.with_context(|| format!("reading {}", folder.display()))?;
        if entry.path().extension().is_some_and(|e| e == "rlib") {
            bytes += entry.metadata().context("size of an rlib")?.len();
        }
    }
    Ok(bytes)
}

/// Of which tree and on what the figures are.
pub(super) fn made() -> Result<String> {
    let output = Command::new("git")
        .args(["rev-parse", "--short", "HEAD"])
        .current_dir(root())
        .output()
        .context("starting git rev-parse")?;
    let commit = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(": "))
        .map_or(std::env::consts::ARCH, |(_, model)| model);
    let n_cores = std::thread::available_parallelism().context("number of cores")?;
    Ok(format!("Built by `cargo xtask weight --build` at {commit}, {n_cores} cores of {model}."))
}
