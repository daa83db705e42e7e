//! `hapdef page`: the live page of a scene's virtual limb as static files.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use hapdef::touch::{BundleRequest, make_bundle};
use hapdef::{Limb, Run, VirtualRigParams, live_limb, virtual_chain, virtual_hands};
use hapdef_cli::{SceneArgs, print_json, shown};
use hapdef_mesh::atomic_write;
use hapdef_view::{STATIC_MODEL, STATIC_MODULE, static_files};
use hapdef_wasm::PageModel;
use serde_json::json;

use super::view::{press_offer, scene_picture};

#[derive(Args)]
#[command(after_help = "Example:\n  \
    cargo xtask wasm --out page\n  \
    hapdef page my-limb/scene.json --module page/hapdef.wasm -o my-page\n  \
    python3 -m http.server --directory my-page\n\n\
    The folder has the page, the program's module and the scene's limb with its virtual rig; any web server \
    shows it, and nothing else is needed to press the limb and to see what its gauges tell. The module is \
    the same for every limb; cargo xtask wasm builds it.")]
pub(crate) struct PageArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The program's module (hapdef.wasm).
    #[arg(long, value_name = "FILE")]
    module: PathBuf,
    /// The folder to write; what is in it stays unless it has the same name.
    #[arg(short, long, value_name = "FOLDER")]
    out: PathBuf,
    /// Seed of the presses that the limb gets while nobody presses it.
    #[arg(long, default_value_t = 1)]
    sim_seed: u64,
    /// Print what was written as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &PageArgs) -> Result<()> {
    let module = std::fs::read(&args.module).with_context(|| shown(&args.module))?;
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let path = &args.scene.scene;
    let text = std::fs::read_to_string(path).with_context(|| shown(path))?;
    let model = model(&run, &limb, text, args.sim_seed)?.to_bytes()?;
    let mut n_bytes = 0;
    for file in static_files() {
        n_bytes += write(&args.out.join(file.path), file.text.as_bytes())?;
    }
    n_bytes += write(&args.out.join(STATIC_MODULE), &module)?;
    n_bytes += write(&args.out.join(STATIC_MODEL), &model)?;
    if args.json {
        let written = json!({
            "folder": args.out,
            "n_bytes": n_bytes,
            "n_model_bytes": model.len(),
            "n_module_bytes": module.len(),
        });
        print_json(&written, false)?;
        return Ok(());
    }
    println!(
        "{}: {:.2} MB, {:.2} of them the limb and {:.2} the program",
        shown(&args.out),
        n_bytes as f64 * 1e-6,
        model.len() as f64 * 1e-6,
        module.len() as f64 * 1e-6,
    );
    Ok(())
}

/// The scene's limb, as `hapdef live --sim --view` shows it.
fn model(run: &Run, limb: &Limb, scene_json: String, seed: u64) -> Result<PageModel> {
    let bundle = make_bundle(run, limb, scene_json, &BundleRequest::default())?;
    let real = live_limb(run, limb)?;
    let (electronics, device) = virtual_chain(&run.scene, &VirtualRigParams::default());
    let hands = virtual_hands(&run.scene, seed);
    let picture = scene_picture(run, limb)?;
    let press = press_offer(&run.scene);
    Ok(PageModel::new(bundle, &real, (&electronics, &device), (press, &hands), picture)?)
}

/// Writes a file, whose folder is made; its bytes.
fn write(path: &Path, bytes: &[u8]) -> Result<usize> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).with_context(|| shown(folder))?;
    }
    atomic_write(path, |file| file.write_all(bytes))
        .with_context(|| format!("writing {}", shown(path)))?;
    Ok(bytes.len())
}
