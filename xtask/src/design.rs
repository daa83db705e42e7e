//! What a scene's gauges can tell, and where to put them.

use std::path::{Path, PathBuf};
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
    let scene = args.scene.as_deref();
    let mut command = with_scene(verb, scene, "fixtures/shin/scene.json")?;
    if let Some(seed) = args.seed {
        command.args(["--seed", &seed.to_string()]);
    }
    finish(command.args(&args.rest))
}

/// `hapdef VERB SCENE`, with a scene in the tree if none is given.
pub(crate) fn with_scene(verb: &str, scene: Option<&Path>, bundled: &str) -> Result<Command> {
    let bundled = root().join(bundled);
    let mut command = Command::new(release_binary("hapdef")?);
    command.arg(verb).arg(scene.unwrap_or(&bundled));
    Ok(command)
}
