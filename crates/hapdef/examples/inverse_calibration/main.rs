//! Calibration on a simulated real limb: error of the map and of the contacts found, by number of
//! presses.
//!
//! `cargo run --release --example inverse_calibration -- [scene.json] [n_frames] [rig seed]`
#![allow(clippy::print_stdout, reason = "a table is what it is for")]

mod bench;
mod draw;
#[path = "../shared/mod.rs"]
mod shared;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use hapdef::scene::RigSpec;
use hapdef::stages::real_limb;
use hapdef::touch::{UncertainParams, UncertainResponse};
use hapdef::{Limb, Profile, Progress, Run};
use hapdef_inverse::{
    Calibrated, CalibrationParams, ModelError, NoiseParams, Press, ResponseMap, ScanSites,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use bench::Bench;
use draw::Hardware;

const N_SITES: usize = 800;
const N_STIFFNESS_MODES: usize = 32;

/// Presses held out for the error of the map.
const N_HELD_OUT: usize = 500;

/// The most presses of a calibration, and others that are tried.
const N_PRESSES: [usize; 2] = [300, 3000];

fn main() -> Result<()> {
    let bundled = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/shin/scene.json");
    let mut args = std::env::args().skip(1);
    let path = PathBuf::from(args.next().unwrap_or_else(|| bundled.to_owned()));
    let n_frames = args.next().map_or(Ok(300), |n| n.parse())?;
    let seed: u64 = args.next().map_or(Ok(111), |n| n.parse())?;
    let out = std::env::temp_dir();
    let mut run = Run::new(&path, Profile::quick(), &out, 2, Progress::silent())?;
    reseed(&mut run.scene.rig, seed);
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let start = Instant::now();
    let params = UncertainParams {
        tip_radius_m: run.scene.contact.tip_radius_m,
        refinements: run.scene.estimator.map_refinements(),
        n_stiffness: N_STIFFNESS_MODES,
        n_threads: run.threads,
    };
    let nominal = UncertainResponse::solve(&limb, &limb.sites, &limb.gauges, &params)?;
    let real = real_limb(&run, &limb, &limb.sites)?;
    let built_s = start.elapsed().as_secs_f64();
    println!("{}, rig seed {seed}: limbs and modes in {built_s:.0} s", run.scene.name);
    let mut hardware = Hardware::new(&real, nominal.map.skin(), seed + 20)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 30);
    let presses = hardware.presses(N_PRESSES[N_PRESSES.len() - 1], &mut rng)?;
    let held_out = hardware.presses(N_HELD_OUT, &mut rng)?;
    let sites = Arc::new(ScanSites::farthest(nominal.map.skin(), N_SITES)?);
    let modes = nominal.modes();
    let bench = Bench::new(&mut hardware, &sites, n_frames, seed + 40)?;
    let relative = relative_error(&nominal.map, &held_out, bench.hardware)?;
    println!("map as computed: error {:.2} %", relative.0 * 100.0);
    bench.tables(&Arc::new(nominal.map.clone()), uncalibrated(relative.0))?;
    for n in N_PRESSES {
        for (title, modes) in [("without modes", &modes[..0]), ("with modes", &modes[..])] {
            // the larger fit takes minutes
            if modes.is_empty() && n > N_PRESSES[0] {
                continue;
            }
            let noise = bench.hardware.noise(ModelError::default());
            let params = CalibrationParams::new(noise_sd(&noise));
            let start = Instant::now();
            let fitted = Calibrated::fit(&nominal.map, &sites, modes, &presses[..n], &params)?;
            let elapsed_s = start.elapsed().as_secs_f64();
            println!("\n{n} presses, {title}: {elapsed_s:.1} s");
            describe(&fitted, &held_out, bench.hardware)?;
            if !modes.is_empty() {
                bench.tables(&Arc::new(fitted.map), fitted.model_error)?;
            }
        }
    }
    Ok(())
}

/// Another limb than the scene's: perturbed alike, with the seeds `seed`, `seed` + 1, ….
fn reseed(rig: &mut RigSpec, seed: u64) {
    (rig.stiffness.seed, rig.thickness.seed) = (seed, seed + 1);
    (rig.misplacement.seed, rig.gain.seed) = (seed + 2, seed + 3);
}

fn uncalibrated(relative: f64) -> ModelError {
    ModelError { relative, ..ModelError::default() }
}

fn noise_sd(noise: &NoiseParams) -> Vec<f64> {
    let pairs = noise.gauge_sd.iter().zip(&noise.quantisation_step);
    pairs.map(|(sd, step)| (sd * sd + step * step / 12.0).sqrt()).collect()
}

/// Root mean square of the map's error over that of the response at `presses`, without noise, and
/// the median of its norm over the response's.
fn relative_error(map: &ResponseMap, presses: &[Press], rig: &Hardware<'_>) -> Result<(f64, f64)> {
    let (mut error, mut all, mut ratios) = (0.0, 0.0, Vec::new());
    for press in presses {
        let truth = rig.response(&press.point)?;
        let found = map.normal(&press.point);
        let e: f64 = truth.iter().zip(found).map(|(t, g)| (t - g).powi(2)).sum();
        let t: f64 = truth.iter().map(|t| t * t).sum();
        (error, all) = (error + e, all + t);
        ratios.push((e / t).sqrt());
    }
    Ok((f64::sqrt(error / all), shared::quantile(&mut ratios, 0.5)))
}

fn describe(fitted: &Calibrated, held_out: &[Press], rig: &Hardware<'_>) -> Result<()> {
    let info = &fitted.info;
    let (rms, median) = relative_error(&fitted.map, held_out, rig)?;
    let percent = |v: f64| v * 100.0;
    println!(
        "  map error {:.2} %, median {:.2} %; left out {:.2} % (before {:.1} %); {} rejected",
        percent(rms),
        percent(median),
        percent(info.relative_error),
        percent(info.relative_error_before),
        info.rejected.len()
    );
    let points = info.curve.iter();
    let curve: Vec<_> =
        points.map(|p| format!("{} {:.2} %", p.n_presses, percent(p.relative_error))).collect();
    let needed = info.presses_for(0.01).map_or(f64::NAN, f64::round);
    println!("  curve {}; 1 % at {needed} presses", curve.join(", "));
    println!(
        "  lengths {:.3?} m, sizes {:?}, variances × {:.2?}, gains {:.3?}",
        info.lengths_m, info.residual_sizes, info.variance_scales, info.gains
    );
    let mut sizes: Vec<f64> = info.held_out.iter().map(|h| h.mean_square_z).collect();
    println!(
        "  z²: median {:.2}, p90 {:.2}, p99 {:.2}",
        shared::quantile(&mut sizes, 0.5),
        shared::quantile(&mut sizes, 0.9),
        shared::quantile(&mut sizes, 0.99)
    );
    Ok(())
}
