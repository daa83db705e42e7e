//! How long it takes from a frame to its contacts.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use crate::pipeline::finish;
use crate::tool::{release_binary, release_example, results, root, run as run_tool};

/// `cargo xtask bench live`: bundles the scene, then a device on a pseudo-terminal plays presses.
pub(crate) fn bench(
    scene: Option<&Path>,
    seed: u64,
    seconds: Option<u64>,
    rest: &[String],
) -> Result<()> {
    let folder = results();
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let bundle = folder.join("bench.hapdef");
    let bundled = root().join("fixtures/shin/placed.json");
    let mut command = Command::new(release_binary("hapdef")?);
    command.arg("bundle").arg(scene.unwrap_or(&bundled));
    run_tool(command.arg("-o").arg(&bundle))?;
    let mut command = Command::new(release_example("latency")?);
    command.arg(&bundle).args(["--seed", &seed.to_string()]);
    if let Some(seconds) = seconds {
        command.args(["--seconds", &seconds.to_string()]);
    }
    command.arg("--metrics").arg(folder.join("metrics.json"));
    finish(command.args(rest))
}
