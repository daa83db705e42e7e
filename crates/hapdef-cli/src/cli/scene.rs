//! `hapdef scene`: a scene with its defaults.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use hapdef::Limb;
use hapdef::scene::read_scene;
use hapdef_cli::{print_json, scene_path};

#[derive(Args)]
#[command(after_help = "Example:\n  hapdef scene fixtures/shin/scene.json --full")]
pub(crate) struct SceneCommandArgs {
    /// The scene file, or the folder of a `scene.json`.
    #[arg(value_parser = scene_path())]
    scene: PathBuf,
    /// Read the limb, too, and fill in what depends on it: axis, material, what counts as wall.
    #[arg(long)]
    full: bool,
}

pub(crate) fn run(args: &SceneCommandArgs) -> Result<()> {
    let mut scene = read_scene(&args.scene)?;
    if args.full {
        let folder = args.scene.parent().unwrap_or(Path::new("."));
        scene = Limb::load(&scene, folder)?.filled(&scene);
    }
    Ok(print_json(&scene, true)?)
}
