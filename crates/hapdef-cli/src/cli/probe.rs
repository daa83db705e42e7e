//! `hapdef probe`: presses of known places and forces on the scene's simulated rig.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use clap::builder::RangedU64ValueParser;
use hapdef::Limb;
use hapdef::touch::{ProbeParams, ProbedRig};
use hapdef_cli::{SceneArgs, print_json, shown};
use serde_json::json;

use super::table::contact_columns;

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef probe fixtures/shin/placed.json presses.csv --presses 300\n\n\
    Simulated: the scene's rig is pressed, not hardware. Columns: x_m, y_m, z_m, force_n of each contact, \
    then the tared reading of each gauge in µε.")]
pub(crate) struct ProbeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The table to write.
    table: PathBuf,
    /// Number of presses.
    #[arg(long, default_value_t = 300)]
    presses: usize,
    /// Places pressed at a time, as far apart as the scene's contacts are; a calibration takes one.
    #[arg(long, default_value_t = 1, value_parser = RangedU64ValueParser::<usize>::new().range(1..=8))]
    contacts: usize,
    /// Seed of places and forces.
    #[arg(long, default_value_t = 1)]
    press_seed: u64,
    /// Print what was made as JSON.
    #[arg(long)]
    json: bool,
}

/// Presses the scene's simulated rig and writes the table.
pub(crate) fn run(args: &ProbeArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let params = ProbeParams {
        n_presses: args.presses,
        n_contacts: args.contacts,
        seed: args.press_seed,
        n_rising: 0,
    };
    let mut text = header(args.contacts, limb.gauges.len());
    for press in ProbedRig::new(&run, &limb)?.presses(&params)? {
        let contacts = press.contacts.iter().flat_map(|([x, y, z], force_n)| [x, y, z, force_n]);
        let numbers = contacts.chain(press.frames_ue.iter().flatten());
        let words: Vec<String> = numbers.map(f64::to_string).collect();
        writeln!(text, "{}", words.join(","))?;
    }
    std::fs::write(&args.table, text).with_context(|| format!("writing {}", shown(&args.table)))?;
    if args.json {
        let made = json!({
            "table": args.table,
            "is_simulated": true,
            "n_presses": args.presses,
            "n_contacts": args.contacts,
            "n_gauges": limb.gauges.len(),
            "seed": args.press_seed,
        });
        return Ok(print_json(&made, false)?);
    }
    println!("{} simulated presses: {}", args.presses, shown(&args.table));
    Ok(())
}

fn header(n_contacts: usize, n_gauges: usize) -> String {
    let contacts = (0..n_contacts).flat_map(contact_columns);
    let names: Vec<String> = contacts.chain((0..n_gauges).map(|g| format!("g{g}_ue"))).collect();
    names.join(",") + "\n"
}
