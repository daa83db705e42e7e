//! Every layer at its extremes.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

use crate::pipeline::finish;
use crate::tool::{day, release_binary, release_example, results, root};

/// Arguments of `robustness`.
#[derive(clap::Args)]
pub(crate) struct RobustnessArgs {
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
    /// Seed of what is drawn; 0 is that of the tables in docs/. Of `scenes` the first scene's, the next
    /// has the next.
    #[arg(long)]
    seed: Option<u64>,
    /// How long scenes are tried, minutes; `scenes` only.
    #[arg(long)]
    minutes: Option<f64>,
    /// Another limb than the bundled one for the contacts by superposition; the other parts have no limb,
    /// or one of their own, and say so.
    #[arg(long, conflicts_with_all = ["write", "check"])]
    scene: Option<PathBuf>,
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
    /// Scenes at random, none of which may be silently wrong; a search, no table.
    Scenes,
}

/// A part with a table in docs/.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Table {
    Fe,
    Nets,
    Inverse,
    Parts,
}

/// `cargo xtask robustness`.
pub(crate) fn run(args: &RobustnessArgs) -> Result<()> {
    refuse_strangers(args)?;
    let Some(part) = args.part else {
        return all(args);
    };
    let Some(table) = part.table() else {
        return finish(&mut scenes(args.minutes, args.seed)?);
    };
    let mut command = table.with_files(args)?;
    if args.json {
        command.arg("--json");
    }
    finish(&mut command)
}

/// Refuses options of other parts.
fn refuse_strangers(args: &RobustnessArgs) -> Result<()> {
    let (is_fe, is_scenes) = (args.part == Some(Part::Fe), args.part == Some(Part::Scenes));
    if args.json && !is_fe {
        bail!("--json is for `robustness fe`");
    }
    let has_limb = matches!(args.part, None | Some(Part::Inverse));
    if args.scene.is_some() && !has_limb {
        eprintln!(
            "no scene's limb is tried here, so --scene changes nothing: see `robustness inverse`"
        );
    }
    let is_of_docs = args.seed.is_none_or(|seed| seed == 0);
    if !is_of_docs && (args.write || args.check) {
        bail!("the tables in docs/ are those of seed 0");
    }
    if args.minutes.is_some() && !is_scenes {
        bail!("--minutes is for `robustness scenes`");
    }
    if is_scenes && (args.write || args.check) {
        bail!("`robustness scenes` has no table: --write and --check are for the other parts");
    }
    Ok(())
}

/// Scenes at random in the nightly run of CI, minutes.
const NIGHTLY_MINUTES: f64 = 20.0;

/// Scenes at random; failing ones are left beside the results, for
/// crates/hapdef/tests/it/scene_search.json.
fn scenes(minutes: Option<f64>, seed: Option<u64>) -> Result<Command> {
    let mut command = Command::new(release_example("scenes")?);
    if let Some(minutes) = minutes {
        command.args(["--minutes", &minutes.to_string()]);
    }
    if let Some(seed) = seed {
        command.args(["--seed", &seed.to_string()]);
    }
    command.arg("--failures").arg(results().join("scenes.json"));
    command.arg("--metrics").arg(results().join("metrics.json"));
    Ok(command)
}

/// Scenes at random, others on each day.
pub(crate) fn nightly() -> Result<()> {
    // Seeds count up from the first one: those of two days are far apart.
    let seed = 100_000 * day();
    crate::tool::run(&mut scenes(Some(NIGHTLY_MINUTES), Some(seed))?)
}

/// Every layer; then all rows as one table, and which parts failed.
fn all(args: &RobustnessArgs) -> Result<()> {
    let mut failed = Vec::new();
    for table in Table::ALL {
        println!("── {}", table.document());
        let page = results().join(table.folder()).join("rows.json");
        if page.exists() {
            std::fs::remove_file(&page).with_context(|| page.display().to_string())?;
        }
        if crate::tool::run(&mut table.with_files(args)?).is_err() {
            failed.push(table.document());
        }
    }
    println!("── all");
    joined()?;
    if !failed.is_empty() {
        bail!("rows failed in {}", failed.join(", "));
    }
    Ok(())
}

/// All rows as one table.
fn joined() -> Result<()> {
    let mut command = Command::new(release_binary("hapdef-repro")?);
    command.arg("robustness-all");
    crate::tool::run(command.arg("--metrics").arg(results().join("metrics.json")))
}

/// All tables, compared with docs/.
pub(crate) fn check() -> Result<()> {
    for table in Table::ALL {
        let mut command = table.command(None)?;
        crate::tool::run(command.arg("--check").arg(root().join(table.document())))?;
    }
    joined()
}

impl Part {
    fn table(self) -> Option<Table> {
        match self {
            Self::Fe => Some(Table::Fe),
            Self::Nets => Some(Table::Nets),
            Self::Inverse => Some(Table::Inverse),
            Self::Parts => Some(Table::Parts),
            Self::Scenes => None,
        }
    }
}

impl Table {
    const ALL: [Self; 4] = [Self::Fe, Self::Nets, Self::Inverse, Self::Parts];

    fn with_files(self, args: &RobustnessArgs) -> Result<Command> {
        let mut command = self.command(args.scene.as_deref())?;
        if let Some(seed) = args.seed {
            let word = match self {
                Self::Fe => "--seed",
                _ => "--test-seed",
            };
            command.args([word, &seed.to_string()]);
        }
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

    /// Where its page is, beside the metrics.
    fn folder(self) -> &'static str {
        match self {
            Self::Fe => "stability-fe",
            Self::Nets => "stability-nets",
            Self::Inverse => "stability-inverse",
            Self::Parts => "stability-parts",
        }
    }

    fn command(self, scene: Option<&Path>) -> Result<Command> {
        let (program, words): (_, &[&str]) = match self {
            Self::Fe => ("hapdef-verify", &["robustness", "fe"]),
            Self::Nets => ("hapdef-repro", &["robustness"]),
            Self::Inverse => ("hapdef-repro", &["robustness-inverse"]),
            Self::Parts => ("hapdef-repro", &["robustness-parts"]),
        };
        let mut command = Command::new(release_binary(program)?);
        command.args(words);
        if self == Self::Inverse {
            let bundled = root().join("fixtures/shin/placed.json");
            command.arg(scene.unwrap_or(&bundled));
        }
        command.arg("--metrics").arg(results().join("metrics.json"));
        Ok(command)
    }
}
