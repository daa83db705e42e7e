//! Contacts that come one by one, followed at 1 kHz on a scene's limb: errors, counts, times.
//!
//! First the map is exact and readings carry 5 µε of noise; then 1 µε, and the limb differs from the
//! map by 1.4 %, smoothly over the skin and anew in each scene. Errors are means over the contacts
//! found, within 10 mm of where they are; times are the least of several runs of each frame.
//!
//! `cargo run --release --example inverse_tracking -- [scene.json] [n_scenes] [seed] [rows]`
#![allow(clippy::print_stdout, reason = "a table is what it is for")]

mod limb_error;
mod play;
mod row;
mod script;
#[path = "../shared/mod.rs"]
mod shared;

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use hapdef::Limb;
use hapdef::scene::read_scene;
use hapdef::touch::response_map;
use hapdef_inverse::{ContactEstimator, EstimatorParams, ModelError, NoiseParams, ScanSites};

use play::Bench;
use row::Row;
use script::Kind;

const N_SITES: usize = 800;

/// Not used while the tracker's parameters were chosen.
const REPORT_SEED: u64 = 4000;

fn main() -> Result<()> {
    let bundled = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/shin/scene.json");
    let mut args = std::env::args().skip(1);
    let path = PathBuf::from(args.next().unwrap_or_else(|| bundled.to_owned()));
    let n_scenes = args.next().map_or(Ok(200), |n| n.parse())?;
    let seed = args.next().map_or(Ok(REPORT_SEED), |n| n.parse())?;
    let wanted = args.next().unwrap_or_default();
    let scene = read_scene(&path)?;
    let limb = Limb::load(&scene, path.parent().context("a scene lies in a folder")?)?;
    let map = Arc::new(response_map(&limb, scene.contact.tip_radius_m, 2)?);
    let sites = Arc::new(ScanSites::farthest(map.skin(), N_SITES)?);
    println!(
        "{}: {} gauges, {} faces, {} sites, {n_scenes} scenes a row, seed {seed}",
        path.display(),
        map.n_gauges(),
        map.skin().n_faces(),
        sites.len()
    );
    for (title, sd, relative) in
        [("the map is exact, 5 µε", 5.0, 0.0), ("the map is wrong by 1.4 %, 1 µε", 1.0, 0.014)]
    {
        let noise = NoiseParams {
            model_error: ModelError { relative, ..ModelError::default() },
            ..NoiseParams::uniform(map.n_gauges(), sd)
        };
        let params = EstimatorParams::default();
        let estimator = ContactEstimator::new(map.clone(), sites.clone(), noise, params)?;
        println!("\n{title}\n{}", Row::HEAD);
        let bench = Bench { estimator: &estimator, sites: &sites, sd, relative };
        for kind in Kind::ALL {
            if kind.name().contains(&wanted) {
                let mut row = Row::default();
                for index in 0..n_scenes {
                    bench.play(kind, seed + index, &mut row)?;
                }
                println!("{:>16} {}", kind.name(), row.text());
            }
        }
    }
    Ok(())
}
