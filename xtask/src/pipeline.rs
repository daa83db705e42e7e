//! The main job, and what the tasks that run a program over a scene share.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::Result;

use crate::fixtures::DEMO;
use crate::tool::{into_results, release_binary, results, root, shown, status, target_dir};
use crate::{browser, metrics};

/// Arguments of the tasks that run the pipeline.
#[derive(clap::Args, Clone)]
pub(crate) struct PipelineArgs {
    /// The scene; the bundled shin if absent, for demo and frontier with its gauges placed.
    #[arg(long)]
    pub(crate) scene: Option<PathBuf>,
    /// Less of everything: fewer presses, samples and steps of training.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Seed of the training side instead of the scene's.
    #[arg(long)]
    seed: Option<u64>,
    /// Everything else goes to `hapdef` as it is, such as `--threads 2` (see the help of its commands).
    #[arg(last = true)]
    rest: Vec<String>,
}

/// Arguments of `demo`.
#[derive(clap::Args, Clone)]
pub(crate) struct DemoArgs {
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// The live page instead of errors and their page: the virtual limb is pressed, and the contacts appear.
    /// What comes after `--` goes to `hapdef live`.
    #[arg(long)]
    live: bool,
}

/// `cargo xtask demo`.
pub(crate) fn demo(args: &DemoArgs) -> Result<()> {
    if args.live {
        return live(&args.pipeline);
    }
    contacts(&args.pipeline)
}

/// Presses of each number of contacts with `--quick`.
const N_QUICK: &str = "25";

/// Calibrates the limb on its simulated rig, and finds contacts.
fn contacts(args: &PipelineArgs) -> Result<()> {
    let is_first = !target_dir()?.join("release/hapdef").exists();
    eprintln!("building (the first time takes some minutes) …");
    let start = Instant::now();
    let mut command = Command::new(release_binary("hapdef")?);
    let build_s = start.elapsed().as_secs_f64();
    command.arg("demo").arg(args.scene.clone().unwrap_or_else(|| root().join(DEMO)));
    if args.quick {
        command.args(["--scored", N_QUICK]);
    }
    if let Some(seed) = args.seed {
        command.args(["--seed", &seed.to_string()]);
    }
    if is_first {
        let figures = [("first.build_s", build_s, "s")];
        metrics::report(&figures, 0, Some(&results().join("metrics.json")));
    }
    finish(into_results(command.args(&args.rest)))
}

/// The virtual limb on the live page. Contacts are followed by superposition unless another estimator is
/// asked for here: the paper's nets, which a scene may choose, take an hour first.
fn live(args: &PipelineArgs) -> Result<()> {
    eprintln!("building (the first time takes some minutes) …");
    let mut command = live_command(args.scene.as_deref(), args.seed, browser::opener()?)?;
    if !args.rest.iter().any(|word| word.starts_with("--estimator")) {
        command.args(["--estimator", "tracking"]);
    }
    if args.quick {
        command.args(["--profile", "quick"]);
    }
    finish(command.args(&args.rest))
}

/// What puts the virtual limb, the bundled one without a scene, on the live page, and opens that.
pub(crate) fn live_command(
    scene: Option<&Path>,
    seed: Option<u64>,
    opener: Option<PathBuf>,
) -> Result<Command> {
    let bundled = root().join(DEMO);
    let mut command = Command::new(release_binary("hapdef")?);
    command.arg("live").arg(scene.unwrap_or(&bundled));
    command.args(["--sim", "--view", "--view-first"]);
    if let Some(seed) = seed {
        command.args(["--sim-seed", &seed.to_string()]);
    }
    if let Some(opener) = opener {
        command.arg("--view-with").arg(opener);
    }
    Ok(command)
}

/// Hands the program's own exit code on: it has said what is wrong.
pub(crate) fn finish(command: &mut Command) -> Result<()> {
    let status = status(command)?;
    match status.code() {
        Some(0) => Ok(()),
        Some(code) => std::process::exit(code),
        None => anyhow::bail!("{} was killed: {status}", shown(command)),
    }
}

/// The words that every program over a scene takes.
pub(crate) fn common(args: &PipelineArgs) -> Vec<String> {
    let bundled = root().join("fixtures/shin/scene.json");
    let scene = args.scene.clone().unwrap_or(bundled);
    let profile = if args.quick { "quick" } else { "full" };
    let mut words = vec![scene.display().to_string(), "--profile".to_owned(), profile.to_owned()];
    if let Some(seed) = args.seed {
        words.extend(["--seed".to_owned(), seed.to_string()]);
    }
    words.extend(args.rest.iter().cloned());
    words
}
