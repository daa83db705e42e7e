//! Contacts by superposition: against the paper's pipeline, and their time.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::pipeline::finish;
use crate::tool::{release_binary, root};

/// Arguments of `compare`.
#[derive(clap::Args)]
pub(crate) struct CompareArgs {
    /// The scene; the bundled limb with its gauges placed if absent.
    #[arg(long)]
    scene: Option<PathBuf>,
    /// The paper's nets with short training: minutes instead of a quarter of an hour.
    #[arg(long)]
    quick: bool,
    /// Seed of presses and frames.
    #[arg(long)]
    seed: Option<u64>,
    /// Everything else goes to `hapdef-repro compare` as it is, such as `--without-paper`.
    #[arg(last = true)]
    rest: Vec<String>,
}

/// `cargo xtask compare`.
pub(crate) fn run(args: &CompareArgs) -> Result<()> {
    let profile = if args.quick { "quick" } else { "full" };
    let mut command = Command::new(release_binary("hapdef-repro")?);
    command.arg("compare").arg(scene_or_placed(args.scene.as_deref())).args(["--profile", profile]);
    if let Some(seed) = args.seed {
        command.args(["--test-seed", &seed.to_string()]);
    }
    finish(command.args(&args.rest))
}

/// `cargo xtask bench inverse`.
pub(crate) fn bench(scene: Option<&Path>, seed: u64, rest: &[String]) -> Result<()> {
    let mut command = Command::new(release_binary("hapdef-repro")?);
    command.arg("bench-inverse").arg(scene_or_placed(scene));
    command.args(["--test-seed", &seed.to_string()]).args(rest);
    finish(&mut command)
}

fn scene_or_placed(scene: Option<&Path>) -> PathBuf {
    let placed = root().join("fixtures/shin/placed.json");
    scene.map_or(placed, Path::to_path_buf)
}
