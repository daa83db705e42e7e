//! The main job: the pipeline's binaries in order.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Instant, SystemTime};

use anyhow::Result;

use crate::browser;
use crate::fixtures::DEMO_LIVE;
use crate::tool::{release_binary, root, shown, status};

/// Arguments of the tasks that run the pipeline.
#[derive(clap::Args, Clone)]
pub(crate) struct PipelineArgs {
    /// The scene; the bundled shin if absent, for the whole frontier with its gauges placed.
    #[arg(long)]
    pub(crate) scene: Option<PathBuf>,
    /// Fewer samples and short training: minutes instead of hours.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Seed of the training side instead of the scene's.
    #[arg(long)]
    seed: Option<u64>,
    /// Everything else goes to `hapdef` as it is, such as `--steps 2000` (see `hapdef --help`).
    #[arg(last = true)]
    rest: Vec<String>,
}

/// Arguments of `demo`.
#[derive(clap::Args, Clone)]
pub(crate) struct DemoArgs {
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// The live page instead of the report: the virtual limb is pressed, and the contacts appear.
    /// What comes after `--` goes to `hapdef live`.
    #[arg(long)]
    live: bool,
}

/// `cargo xtask demo`.
pub(crate) fn demo(args: &DemoArgs) -> Result<()> {
    if args.live {
        return live(&args.pipeline);
    }
    report(&args.pipeline)
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
    let bundled = root().join(DEMO_LIVE);
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

/// From the limb to the report.
fn report(args: &PipelineArgs) -> Result<()> {
    eprintln!("building (the first time takes some minutes) …");
    let hapdef = release_binary("hapdef")?;
    let repro = release_binary("hapdef-repro")?;
    let start = Instant::now();
    let began_unix_s = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH)?.as_secs_f64();
    for (program, verb) in [(&hapdef, "eval"), (&repro, "report")] {
        let mut command = Command::new(program);
        command.env("HAPDEF_DEMO_BEGAN_UNIX_S", began_unix_s.to_string());
        finish(command.arg(verb).args(common(args)))?;
    }
    eprintln!("demo: {:.0} s after the build", start.elapsed().as_secs_f64());
    Ok(())
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
