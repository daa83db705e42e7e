//! `hapdef bundle`: one file with everything that a robot needs to find contacts.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use hapdef::Limb;
use hapdef::touch::{BundleRequest, make_bundle};
use hapdef_cli::{SceneArgs, TrainingArgs, print_json, shown};
use hapdef_live::Bundle;
use hapdef_mesh::atomic_write;
use serde_json::json;

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef bundle fixtures/shin/placed.json -o shin.hapdef\n  \
    hapdef live shin.hapdef --source serial:/dev/ttyACM0\n\n\
    The bundle has the scene, the skin, the response map with its error, the gauges and the \
    calibration that the scene names, and the trained nets if the scene chooses them; nothing else is needed to find contacts, and every part is \
    checked by its hash when it is read.")]
pub(crate) struct BundleArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    training: TrainingArgs,
    /// The file to write.
    #[arg(short, long, alias = "bundle", value_name = "FILE")]
    out: PathBuf,
    /// Add what may change the response, with that many stiffness modes of the limb, for a
    /// calibration on the robot; takes a solve for each mode and gauge.
    #[arg(long, value_name = "N")]
    modes: Option<usize>,
    /// Add the paper's trained nets, whatever the scene chooses; they are trained where they are not.
    #[arg(long)]
    nets: bool,
    /// Print what is in it as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &BundleArgs) -> Result<()> {
    let run = args.training.prepare(&args.scene)?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let path = &args.scene.scene;
    let text = std::fs::read_to_string(path).with_context(|| shown(path))?;
    let request = BundleRequest { n_stiffness: args.modes, has_nets: args.nets };
    let bundle = make_bundle(&run, &limb, text, &request)?;
    let bytes = bundle.to_bytes()?;
    atomic_write(&args.out, |file| file.write_all(&bytes))
        .with_context(|| format!("writing {}", shown(&args.out)))?;
    if args.json {
        print_json(&as_json(&bundle, bytes.len()), false)?;
    } else {
        println!(
            "{}: {} gauges, {} skin nodes, {:.1} MB{}{}{}",
            shown(&args.out),
            bundle.info.gauges.len(),
            bundle.skin().n_nodes(),
            bytes.len() as f64 * 1e-6,
            if bundle.calibration_json.is_some() { ", calibrated" } else { ", not calibrated" },
            if bundle.modes.is_empty() { "" } else { ", with modes" },
            if bundle.nets.is_empty() { "" } else { ", with nets" },
        );
    }
    Ok(())
}

fn as_json(bundle: &Bundle, n_bytes: usize) -> serde_json::Value {
    json!({
        "scene": bundle.info.scene,
        "made_by": bundle.info.made_by,
        "n_gauges": bundle.info.gauges.len(),
        "n_skin_nodes": bundle.skin().n_nodes(),
        "n_skin_faces": bundle.skin().n_faces(),
        "n_modes": bundle.modes.len(),
        "is_calibrated": bundle.calibration_json.is_some(),
        "estimator": bundle.info.estimator,
        "nets": bundle.nets.keys().collect::<Vec<_>>(),
        "n_bytes": n_bytes,
    })
}
