//! Damaged inputs for every reader.

use std::process::Command;

use anyhow::Result;

use crate::pipeline::finish;
use crate::tool::{day, release_example, results};

/// Arguments of `fuzz`.
#[derive(clap::Args)]
pub(crate) struct FuzzArgs {
    /// How long each target is run, s.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// The same in minutes.
    #[arg(long, conflicts_with = "seconds")]
    minutes: Option<f64>,
    /// One target instead of all: decoder, hello, recover, scene, gltf, deck, safetensors.
    #[arg(long)]
    target: Option<String>,
    /// Seed of the mutations.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Each target in the nightly run of CI, minutes.
const NIGHTLY_MINUTES: f64 = 2.0;

/// `cargo xtask fuzz`.
pub(crate) fn run(args: &FuzzArgs) -> Result<()> {
    finish(&mut command(args)?)
}

/// Every target, with other damage on each day.
pub(crate) fn nightly() -> Result<()> {
    let (minutes, seed) = (Some(NIGHTLY_MINUTES), day());
    let args = FuzzArgs { seconds: 0.0, minutes, target: None, seed };
    crate::tool::run(&mut command(&args)?)
}

fn command(args: &FuzzArgs) -> Result<Command> {
    let mut command = Command::new(release_example("fuzz")?);
    let seconds = args.minutes.map_or(args.seconds, |minutes| 60.0 * minutes);
    command.args(["--seconds", &seconds.to_string()]);
    command.args(["--seed", &args.seed.to_string()]);
    if let Some(name) = &args.target {
        command.args(["--target", name]);
    }
    command.arg("--failures").arg(results().join("fuzz"));
    command.arg("--metrics").arg(results().join("metrics.json"));
    Ok(command)
}
