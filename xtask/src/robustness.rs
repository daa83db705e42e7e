//! Every layer at its extremes.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

use crate::pipeline::finish;
use crate::tool::{add_document, day, release_binary, release_example, results, root};

/// Arguments of `robustness`.
#[derive(clap::Args, Default)]
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
struct Table {
    part: Part,
    /// Of its file in docs/, and of its folder beside the metrics.
    name: &'static str,
    program: &'static str,
    words: &'static [&'static str],
    /// What seeds the rows.
    seed: &'static str,
}

const TABLES: [Table; 4] = [
    Table {
        part: Part::Fe,
        name: "stability-fe",
        program: "hapdef-verify",
        words: &["robustness", "fe"],
        seed: "--seed",
    },
    of_repro(Part::Nets, "stability-nets", &["robustness"]),
    of_repro(Part::Inverse, "stability-inverse", &["robustness-inverse"]),
    of_repro(Part::Parts, "stability-parts", &["robustness-parts"]),
];

const fn of_repro(part: Part, name: &'static str, words: &'static [&'static str]) -> Table {
    Table { part, name, program: "hapdef-repro", words, seed: "--test-seed" }
}

/// `cargo xtask robustness`.
pub(crate) fn run(args: &RobustnessArgs) -> Result<()> {
    refuse_strangers(args)?;
    let Some(part) = args.part else {
        return all(args);
    };
    let Some(table) = TABLES.iter().find(|table| table.part == part) else {
        return finish(&mut scenes(args.minutes, args.seed)?);
    };
    let mut command = table.command(args)?;
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
    for table in &TABLES {
        println!("── {}", table.document());
        let page = results().join(table.name).join("rows.json");
        if page.exists() {
            std::fs::remove_file(&page).with_context(|| page.display().to_string())?;
        }
        if crate::tool::run(&mut table.command(args)?).is_err() {
            failed.push(table.document());
        }
    }
    println!("── all");
    let mut joined = Command::new(release_binary("hapdef-repro")?);
    crate::tool::run(joined.arg("robustness-all"))?;
    if !failed.is_empty() {
        bail!("rows failed in {}", failed.join(", "));
    }
    Ok(())
}

/// All tables, compared with docs/.
pub(crate) fn check() -> Result<()> {
    all(&RobustnessArgs { check: true, ..RobustnessArgs::default() })
}

impl Table {
    fn document(&self) -> String {
        format!("docs/{}.md", self.name)
    }

    fn command(&self, args: &RobustnessArgs) -> Result<Command> {
        let mut command = Command::new(release_binary(self.program)?);
        command.args(self.words);
        if self.part == Part::Inverse {
            let bundled = root().join("fixtures/shin/placed.json");
            command.arg(args.scene.as_ref().unwrap_or(&bundled));
        }
        if let Some(seed) = args.seed {
            command.args([self.seed, &seed.to_string()]);
        }
        add_document(&mut command, &self.document(), args.write, args.check);
        Ok(command)
    }
}
