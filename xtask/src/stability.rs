//! Solvers at their extremes.

use std::process::Command;

use anyhow::Result;
use clap::ValueEnum;

use crate::pipeline::finish;
use crate::tool::{release_binary, root, target_dir};

/// Arguments of `stability`.
#[derive(clap::Args)]
pub(crate) struct StabilityArgs {
    /// What is tried.
    #[arg(value_enum, default_value = "fe")]
    part: Part,
    /// Write docs/stability-fe.md.
    #[arg(long)]
    write: bool,
    /// Fail where docs/stability-fe.md says something else.
    #[arg(long)]
    check: bool,
    /// Rows as JSON.
    #[arg(long)]
    json: bool,
    /// Draws which elements are stiff where they are scattered at random; the file has seed 0.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// What is tried at its extremes.
#[derive(Clone, Copy, ValueEnum)]
enum Part {
    /// The elasticity solver.
    Fe,
}

/// `cargo xtask stability`.
pub(crate) fn run(args: &StabilityArgs) -> Result<()> {
    let Part::Fe = args.part;
    let mut command = fe()?;
    for (flag, on) in [("--write", args.write), ("--check", args.check)] {
        if on {
            command.arg(flag).arg(root().join(DOCUMENT));
        }
    }
    if args.json {
        command.arg("--json");
    }
    command.args(["--seed", &args.seed.to_string()]);
    finish(&mut command)
}

/// The table, compared with docs/stability-fe.md.
pub(crate) fn check() -> Result<()> {
    crate::tool::run(fe()?.arg("--check").arg(root().join(DOCUMENT)))
}

const DOCUMENT: &str = "docs/stability-fe.md";

fn fe() -> Result<Command> {
    let mut command = Command::new(release_binary("hapdef-verify")?);
    command
        .args(["stability", "fe", "--metrics"])
        .arg(target_dir()?.join("hapdef/metrics.json"));
    Ok(command)
}
