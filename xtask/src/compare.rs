//! Contacts by superposition against the paper's pipeline.

use std::path::PathBuf;
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
    let placed = || root().join("fixtures/shin/placed.json");
    let mut command = Command::new(release_binary("hapdef-repro")?);
    command.arg("compare").arg(args.scene.clone().unwrap_or_else(placed));
    command.args(["--profile", profile]);
    if let Some(seed) = args.seed {
        command.args(["--test-seed", &seed.to_string()]);
    }
    finish(command.args(&args.rest))
}
