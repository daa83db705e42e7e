//! What a scene's gauges can tell, and where to put them.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::pipeline::finish;
use crate::tool::{release_binary, root};

/// Arguments of `limits` and `place`.
#[derive(clap::Args)]
pub(crate) struct DesignArgs {
    /// The scene; the bundled shin if absent.
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Seed of what is drawn at random instead of the scene's.
    #[arg(long)]
    seed: Option<u64>,
    /// Everything else goes to `hapdef limits` or `hapdef place` as it is, such as `--noise-ue 2`.
    #[arg(last = true)]
    rest: Vec<String>,
}

/// `cargo xtask limits` and `cargo xtask place`.
pub(crate) fn run(verb: &str, args: &DesignArgs) -> Result<()> {
    let bundled = root().join("fixtures/shin/scene.json");
    let mut command = Command::new(release_binary("hapdef")?);
    command
        .arg(verb)
        .arg(args.scene.as_ref().unwrap_or(&bundled));
    if let Some(seed) = args.seed {
        command.args(["--seed", &seed.to_string()]);
    }
    finish(command.args(&args.rest))
}
