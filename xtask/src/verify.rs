//! The verification table, and single decks.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::pipeline::finish;
use crate::tool::{add_document, release_binary, root};

const DOCUMENT: &str = "docs/verification.md";

/// Arguments of `verify`.
#[derive(clap::Args)]
pub(crate) struct VerifyArgs {
    /// This deck's own load against known results, instead of the table.
    #[arg(long)]
    deck: Option<PathBuf>,
    /// CalculiX displacements of that load.
    #[arg(long, requires = "deck")]
    reference: Option<PathBuf>,
    /// The solid deck of this scene, instead of the table.
    #[arg(long, conflicts_with = "deck")]
    scene: Option<PathBuf>,
    /// Write docs/verification.md.
    #[arg(long)]
    write: bool,
    /// Fail where docs/verification.md has other numbers.
    #[arg(long)]
    check: bool,
    /// Rows as JSON.
    #[arg(long)]
    json: bool,
    /// The seed the metrics carry; nothing is drawn at random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Everything else goes to `hapdef-verify` as it is, such as `--only le10`.
    #[arg(last = true)]
    rest: Vec<String>,
}

/// `cargo xtask verify`.
pub(crate) fn run(args: &VerifyArgs) -> Result<()> {
    let mut command = Command::new(release_binary("hapdef-verify")?);
    let deck = match &args.scene {
        Some(scene) => Some(deck_of(scene)?),
        None => args.deck.clone(),
    };
    if let Some(deck) = deck {
        command.arg("deck").arg(deck);
        if let Some(reference) = &args.reference {
            command.arg("--reference").arg(reference);
        }
    } else {
        command.arg("verify");
        add_document(&mut command, DOCUMENT, args.write, args.check);
        if args.json {
            command.arg("--json");
        }
    }
    command.args(["--seed", &args.seed.to_string()]).args(&args.rest);
    finish(&mut command)
}

/// The table, compared with docs/verification.md.
pub(crate) fn check() -> Result<()> {
    let mut command = Command::new(release_binary("hapdef-verify")?);
    crate::tool::run(command.args(["verify", "--check"]).arg(root().join(DOCUMENT)))
}

/// The solid deck that a scene names.
pub(crate) fn deck_of(scene: &PathBuf) -> Result<PathBuf> {
    let text = std::fs::read(scene).with_context(|| format!("reading {}", scene.display()))?;
    let json: serde_json::Value =
        serde_json::from_slice(&text).with_context(|| scene.display().to_string())?;
    let name = json["geometry"]["solid_deck"]
        .as_str()
        .with_context(|| format!("{}: no geometry.solid_deck", scene.display()))?;
    Ok(scene.parent().map_or_else(|| name.into(), |folder| folder.join(name)))
}
