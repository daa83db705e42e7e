//! Acquisition and recording at length, and what a stream's answers are worth.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::pipeline::finish;
use crate::tool::{cargo, release_binary, release_example, results, root, run as run_tool};

/// Arguments of `soak`.
#[derive(clap::Args)]
pub(crate) struct SoakArgs {
    /// Half a minute instead of a quarter of an hour.
    #[arg(long)]
    short: bool,
    /// Seed of the damage.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Taken for the sake of scripts and not used: acquisition knows no limb.
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Everything else goes to the program as it is: `--seconds 600`, `--kills 200`.
    #[arg(last = true)]
    rest: Vec<String>,
}

/// `cargo xtask soak`.
pub(crate) fn run(args: &SoakArgs) -> Result<()> {
    if let Some(scene) = &args.scene {
        eprintln!("{} is not used: acquisition knows no limb", scene.display());
    }
    let mut soak = command(args)?;
    if !args.short {
        run_tool(&mut stalled_client())?;
    }
    run_tool(&mut trust(args)?)?;
    run_tool(&mut scripts(args)?)?;
    finish(&mut soak)
}

/// A client of the live server that does not read for a minute.
fn stalled_client() -> Command {
    let words = ["test", "--quiet", "--release", "--test", "it", "--", "stalled_client"];
    let mut command = cargo(&words);
    command.env("HAPDEF_SOAK", "1");
    command
}

/// What claims a time, in the short form that CI runs or the long one of its nightly run, whose tests have had
/// the stalled client.
pub(crate) fn of_ci(short: bool) -> Result<()> {
    let args = of_seed_1(short);
    run_tool(&mut scripts(&args)?)?;
    run_tool(&mut command(&args)?)
}

/// What claims none: a limb's stream in simulated time.
pub(crate) fn trust_of_ci(short: bool) -> Result<()> {
    run_tool(&mut trust(&of_seed_1(short))?)
}

fn of_seed_1(short: bool) -> SoakArgs {
    SoakArgs { short, seed: 1, scene: None, rest: Vec::new() }
}

/// What a limb's stream says while its zeros drift and when a hidden press lets go, in simulated time.
fn trust(args: &SoakArgs) -> Result<Command> {
    std::fs::create_dir_all(results())?;
    let bundle = results().join("trust.hapdef");
    let mut command = Command::new(release_binary("hapdef")?);
    command.arg("bundle").arg(root().join("fixtures/shin/demo.json")).arg("-o").arg(&bundle);
    run_tool(&mut command)?;
    let mut command = Command::new(release_example("trust")?);
    command.arg(&bundle).args((!args.short).then_some("--long"));
    command.args(["--seed", &args.seed.to_string(), "--metrics"]);
    command.arg(results().join("metrics.json"));
    Ok(command)
}

/// What it says of random scripts on the simulated rig; at length on every limb of the fixtures that is there.
fn scripts(args: &SoakArgs) -> Result<Command> {
    let mut command = Command::new(release_example("scripts")?);
    let mut scenes = vec!["fixtures/shin/demo.json"];
    if args.short {
        command.args(["--scripts", "4", "--seconds", "12", "--replay-s", "4", "--stop-s", "12"]);
    } else {
        scenes.push("fixtures/shin/placed.json");
        let deck = root().join("../shared/inputs/hapdef-shin/02_skin_ds.dat.gz");
        scenes.extend(deck.exists().then_some("fixtures/paper-shin/placed.json"));
    }
    command.args(scenes.into_iter().map(|scene| root().join(scene)));
    command.args(["--seed", &args.seed.to_string(), "--results"]).arg(results()).arg("--metrics");
    command.arg(results().join("metrics.json"));
    Ok(command)
}

/// Builds the program and says how it is started.
fn command(args: &SoakArgs) -> Result<Command> {
    let mut command = Command::new(release_example("soak")?);
    command.args(args.short.then_some("--short"));
    command.args(["--seed", &args.seed.to_string()]);
    command.arg("--metrics").arg(results().join("metrics.json"));
    command.args(&args.rest);
    Ok(command)
}
