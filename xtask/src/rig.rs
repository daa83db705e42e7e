//! The virtual limb as a device on a port.

use std::path::PathBuf;

use anyhow::Result;

use crate::design::with_scene;
use crate::pipeline::finish;

/// Arguments of `rig`.
#[derive(clap::Args)]
pub(crate) struct RigArgs {
    /// The scene; the bundled shin with placed gauges if absent.
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Seed of the random presses.
    #[arg(long)]
    seed: Option<u64>,
    /// Everything else goes to `hapdef rig` as it is: `--link /tmp/limb`, `--tcp 127.0.0.1:7878`,
    /// `--script presses.json`.
    #[arg(last = true)]
    rest: Vec<String>,
}

/// `cargo xtask rig`.
pub(crate) fn run(args: &RigArgs) -> Result<()> {
    let scene = args.scene.as_deref();
    let mut command = with_scene("rig", scene, "fixtures/shin/placed.json")?;
    if let Some(seed) = args.seed {
        command.args(["--random", &seed.to_string()]);
    }
    finish(command.args(&args.rest))
}
