//! Solvers, nets, baselines and superposition at their extremes.

use std::process::Command;

use anyhow::{Result, bail};
use clap::ValueEnum;

use crate::pipeline::finish;
use crate::tool::{release_binary, root, target_dir};

/// Arguments of `stability`.
#[derive(clap::Args)]
pub(crate) struct StabilityArgs {
    /// What is tried.
    #[arg(value_enum, default_value = "fe")]
    part: Part,
    /// Write the table in docs/.
    #[arg(long)]
    write: bool,
    /// Fail where the table in docs/ says something else.
    #[arg(long)]
    check: bool,
    /// Rows as JSON; `fe` only.
    #[arg(long)]
    json: bool,
    /// Draws which elements are stiff where they are scattered at random; the file has seed 0;
    /// `fe` only.
    #[arg(long)]
    seed: Option<u64>,
}

/// What is tried at its extremes.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// The elasticity solver.
    Fe,
    /// Training, baselines and inference.
    Nets,
    /// Contacts by superposition.
    Inverse,
}

/// `cargo xtask stability`.
pub(crate) fn run(args: &StabilityArgs) -> Result<()> {
    if args.part != Part::Fe && (args.json || args.seed.is_some()) {
        bail!("--json and --seed are for `stability fe`");
    }
    let mut command = args.part.command()?;
    for (flag, on) in [("--write", args.write), ("--check", args.check)] {
        if on {
            command.arg(flag).arg(root().join(args.part.document()));
        }
    }
    if args.json {
        command.arg("--json");
    }
    if let Some(seed) = args.seed {
        command.args(["--seed", &seed.to_string()]);
    }
    finish(&mut command)
}

/// All tables, compared with docs/.
pub(crate) fn check() -> Result<()> {
    for part in [Part::Fe, Part::Nets, Part::Inverse] {
        let mut command = part.command()?;
        crate::tool::run(command.arg("--check").arg(root().join(part.document())))?;
    }
    Ok(())
}

impl Part {
    fn document(self) -> &'static str {
        match self {
            Self::Fe => "docs/stability-fe.md",
            Self::Nets => "docs/stability-nets.md",
            Self::Inverse => "docs/stability-inverse.md",
        }
    }

    fn command(self) -> Result<Command> {
        let (program, words): (_, &[&str]) = match self {
            Self::Fe => ("hapdef-verify", &["stability", "fe"]),
            Self::Nets => ("hapdef-repro", &["stability"]),
            Self::Inverse => ("hapdef-repro", &["stability-inverse"]),
        };
        let mut command = Command::new(release_binary(program)?);
        command.args(words);
        if self == Self::Inverse {
            command.arg(root().join("fixtures/shin/placed.json"));
        }
        command
            .arg("--metrics")
            .arg(target_dir()?.join("hapdef/metrics.json"));
        Ok(command)
    }
}
