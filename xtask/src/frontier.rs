//! Error against run time.

use std::process::Command;

use anyhow::{Result, bail};
use clap::ValueEnum;

use crate::pipeline::{PipelineArgs, common, finish};
use crate::tool::{add_document, release_binary, root};

/// The scene of the whole chain: the bundled limb with its gauges placed, and a rig whose mesh is not the
/// limb's, so that none is measured with its own discretisation error.
const PLACED_ANEW: &str = "fixtures/shin/placed_anew.json";

const LIMITS: &str = "docs/limits.md";

/// Arguments of `frontier`.
#[derive(clap::Args)]
pub(crate) struct FrontierArgs {
    /// What is compared; the whole chain if nothing is said.
    what: Option<Subject>,
    /// No new configuration is begun after so many minutes (20); whole chain only.
    #[arg(long)]
    minutes: Option<f64>,
    /// `--quick` takes the quick run's data and nets; this is also the default. `--full` takes the
    /// paper's amounts.
    #[arg(long, conflicts_with = "quick")]
    full: bool,
    /// Write docs/limits.md and docs/limits.json; whole chain only.
    #[arg(long)]
    write: bool,
    /// Fail where docs/limits.md is stale: the usual configuration is measured again; whole chain only.
    #[arg(long, conflicts_with = "write")]
    check: bool,
    #[command(flatten)]
    pipeline: PipelineArgs,
}

/// What `frontier` can compare.
#[derive(Clone, Copy, ValueEnum)]
enum Subject {
    /// Networks and the paper's baselines.
    Nets,
    /// Contacts by superposition: effort of the search, with the paper's nets and the bound.
    Inverse,
}

/// `cargo xtask frontier`.
pub(crate) fn run(args: &FrontierArgs) -> Result<()> {
    let program = match args.what {
        None => "frontier",
        Some(Subject::Nets) => "frontier-nets",
        Some(Subject::Inverse) => "frontier-inverse",
    };
    let mut pipeline = args.pipeline.clone();
    pipeline.quick = !args.full;
    if args.what.is_none() && pipeline.scene.is_none() {
        pipeline.scene = Some(root().join(PLACED_ANEW));
    }
    let mut command = Command::new(release_binary("hapdef-repro")?);
    command.arg(program).args(common(&pipeline));
    if args.what.is_some() && (args.minutes.is_some() || args.write || args.check) {
        bail!("--minutes, --write and --check are for the whole chain: `cargo xtask frontier`");
    }
    if let Some(minutes) = args.minutes {
        command.args(["--minutes", &minutes.to_string()]);
    }
    add_document(&mut command, LIMITS, args.write, args.check);
    finish(&mut command)
}

/// Whether docs/limits.md still holds.
pub(crate) fn check() -> Result<()> {
    let mut command = Command::new(release_binary("hapdef-repro")?);
    command.arg("frontier").arg(root().join(PLACED_ANEW));
    command.args(["--profile", "quick", "--check"]);
    crate::tool::run(command.arg(root().join(LIMITS)))
}
