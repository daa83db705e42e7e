//! Contacts by superposition on a scene's limb: errors by number of contacts and time per frame.
//!
//! First the map is exact and readings carry 5 µε of noise; then the readings are those of the
//! simulated, perturbed limb, 1 µε, and the map is not calibrated.
//!
//! `cargo run --release --example inverse_accuracy -- [scene.json] [n_frames] [parts]`
#![allow(clippy::print_stdout, reason = "a table is what it is for")]

mod row;
#[path = "../shared/mod.rs"]
mod shared;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use hapdef::scene::RigSpec;
use hapdef::stages::real_limb;
use hapdef::touch::response_map;
use hapdef::{Limb, Profile, Progress, Run};
use hapdef_inverse::{
    ContactEstimate, ContactEstimator, EstimatorParams, ModelError, NoiseParams, ResponseMap,
    ScanSites, SkinPoint,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use row::{Response, Row};

const N_SITES: usize = 800;

/// The first of the rig's seeds, others than the scene's.
const RIG_SEED: u64 = 111;

fn main() -> Result<()> {
    let bundled = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/shin/scene.json");
    let mut args = std::env::args().skip(1);
    let path = PathBuf::from(args.next().unwrap_or_else(|| bundled.to_owned()));
    let n_frames = args.next().map_or(Ok(300), |n| n.parse())?;
    let parts = args.next().unwrap_or_else(|| "exact,rig".to_owned());
    let out = std::env::temp_dir();
    let mut run = Run::new(&path, Profile::quick(), &out, 2, Progress::silent())?;
    reseed(&mut run.scene.rig);
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let start = Instant::now();
    let tip_radius_m = run.scene.contact.tip_radius_m;
    let map = Arc::new(response_map(&limb, tip_radius_m, run.threads)?);
    let sites = Arc::new(ScanSites::farthest(map.skin(), N_SITES)?);
    println!(
        "map of {} gauges on {} nodes, {} faces, {} sites within {:.1} mm: {:.2} s",
        map.n_gauges(),
        map.skin().n_nodes(),
        map.skin().n_faces(),
        sites.len(),
        sites.spacing_m() * 1e3,
        start.elapsed().as_secs_f64()
    );
    let uniform = |sd| NoiseParams::uniform(map.n_gauges(), sd);
    if parts.contains("exact") {
        let exact = |p: &SkinPoint| Ok(map.normal(p));
        let title = "the map is exact, 5 µε";
        table(title, &map, &sites, &uniform(5.0), n_frames, &exact)?;
    }
    if parts.contains("rig") {
        let real = real_limb(&run, &limb, &limb.sites)?;
        let perturbed = |p: &SkinPoint| -> Result<Vec<f64>> {
            let skin = map.skin();
            Ok(real.response_ue_per_n(&skin.position(p), &-skin.normal(p))?)
        };
        let relative = relative_error(&map, &sites, &perturbed)?;
        println!("relative error of the map: {:.0} %", relative * 100.0);
        let model_error = ModelError { relative, ..ModelError::default() };
        let noise = NoiseParams { model_error, ..uniform(1.0) };
        let title = "simulated real limb, map not calibrated, 1 µε";
        table(title, &map, &sites, &noise, n_frames, &perturbed)?;
    }
    Ok(())
}

/// Root mean square of the map's error over that of the response, at the scan sites.
fn relative_error(map: &ResponseMap, sites: &ScanSites, truth: Response<'_>) -> Result<f64> {
    let (mut error, mut all) = (0.0, 0.0);
    for point in sites.points() {
        for (t, g) in truth(point)?.iter().zip(map.normal(point)) {
            error += (t - g).powi(2);
            all += t * t;
        }
    }
    Ok(f64::sqrt(error / all))
}

/// Another limb than the scene's: perturbed alike, with seeds of its own.
fn reseed(rig: &mut RigSpec) {
    (rig.stiffness.seed, rig.thickness.seed) = (RIG_SEED, RIG_SEED + 1);
    (rig.misplacement.seed, rig.gain.seed) = (RIG_SEED + 2, RIG_SEED + 3);
}

fn table(
    title: &str,
    map: &Arc<ResponseMap>,
    sites: &Arc<ScanSites>,
    noise: &NoiseParams,
    n_frames: usize,
    response: Response<'_>,
) -> Result<()> {
    println!(
        "\n{title}; forces 5–34 N, contacts at least 12 mm apart, {n_frames} frames a row\n{}",
        Row::HEAD
    );
    for k in 1..=3 {
        for known_count in [Some(k), None] {
            let params = EstimatorParams { known_count, ..EstimatorParams::default() };
            let estimator =
                ContactEstimator::new(map.clone(), sites.clone(), noise.clone(), params)?;
            let mut rng = ChaCha8Rng::seed_from_u64(900 + k as u64);
            let mut row = Row::default();
            let mut scratch = (estimator.scratch(), ContactEstimate::default());
            for _ in 0..n_frames {
                row.frame(&estimator, k, noise, response, &mut rng, &mut scratch)?;
            }
            let count = known_count.map_or("estimated", |_| "given");
            println!("{k:>2} {count:>9} {}", row.text(n_frames));
        }
    }
    Ok(())
}
