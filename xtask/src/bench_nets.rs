//! Times of the networks.

use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::pipeline::finish;
use crate::tool::{release_binary, root};

/// `cargo xtask bench nets`.
pub(crate) fn run(scene: Option<&Path>, seed: u64, rest: &[String]) -> Result<()> {
    let bundled = root().join("fixtures/shin/scene.json");
    let mut command = Command::new(release_binary("hapdef-repro")?);
    command.arg("bench-nets").arg("--scene").arg(scene.unwrap_or(&bundled));
    command.args(["--seed", &seed.to_string()]).args(rest);
    finish(&mut command)
}
