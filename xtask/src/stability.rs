//! Every layer at its extremes.

use std::process::Command;

use anyhow::{Result, bail};
use clap::ValueEnum;

use crate::pipeline::finish;
use crate::tool::{release_binary, results, root};

/// Arguments of `stability`.
#[derive(clap::Args)]
pub(crate) struct StabilityArgs {
    /// What is tried; everything if nothing is said.
    #[arg(value_enum)]
    part: Option<Part>,
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
    /// Contacts by superposition, and the calibration.
    Inverse,
    /// Meshes, datasets, k-Max, decoder, clock, recordings.
    Parts,
}

/// `cargo xtask stability`.
pub(crate) fn run(args: &StabilityArgs) -> Result<()> {
    let Some(part) = args.part else {
        if args.json || args.seed.is_some() {
            bail!("--json and --seed are for `stability fe`");
        }
        return all(args);
    };
    if part != Part::Fe && (args.json || args.seed.is_some()) {
        bail!("--json and --seed are for `stability fe`");
    }
    let mut command = part.with_files(args)?;
    if args.json {
        command.arg("--json");
    }
    if let Some(seed) = args.seed {
        command.args(["--seed", &seed.to_string()]);
    }
    finish(&mut command)
}

/// Every layer; then which failed.
fn all(args: &StabilityArgs) -> Result<()> {
    let mut failed = Vec::new();
    for part in Part::ALL {
        println!("── {}", part.document());
        if crate::tool::run(&mut part.with_files(args)?).is_err() {
            failed.push(part.document());
        }
    }
    if !failed.is_empty() {
        bail!("rows failed in {}", failed.join(", "));
    }
    Ok(())
}

/// All tables, compared with docs/.
pub(crate) fn check() -> Result<()> {
    for part in Part::ALL {
        let mut command = part.command()?;
        crate::tool::run(command.arg("--check").arg(root().join(part.document())))?;
    }
    Ok(())
}

impl Part {
    const ALL: [Self; 4] = [Self::Fe, Self::Nets, Self::Inverse, Self::Parts];

    fn with_files(self, args: &StabilityArgs) -> Result<Command> {
        let mut command = self.command()?;
        for (flag, on) in [("--write", args.write), ("--check", args.check)] {
            if on {
                command.arg(flag).arg(root().join(self.document()));
            }
        }
        Ok(command)
    }

    fn document(self) -> &'static str {
        match self {
            Self::Fe => "docs/stability-fe.md",
            Self::Nets => "docs/stability-nets.md",
            Self::Inverse => "docs/stability-inverse.md",
            Self::Parts => "docs/stability-parts.md",
        }
    }

    fn command(self) -> Result<Command> {
        let (program, words): (_, &[&str]) = match self {
            Self::Fe => ("hapdef-verify", &["stability", "fe"]),
            Self::Nets => ("hapdef-repro", &["stability"]),
            Self::Inverse => ("hapdef-repro", &["stability-inverse"]),
            Self::Parts => ("hapdef-repro", &["stability-parts"]),
        };
        let mut command = Command::new(release_binary(program)?);
        command.args(words);
        if self == Self::Inverse {
            command.arg(root().join("fixtures/shin/placed.json"));
        }
        command.arg("--metrics").arg(results().join("metrics.json"));
        Ok(command)
    }
}
