//! Writes the limb of `fixtures/shin` and the other mesh of it that its simulated rig is solved on,
//! or checks that they are what the generator makes.
//!
//! ```text
//! cargo run --release --example make_shin -- fixtures/shin
//! cargo run --release --example make_shin -- fixtures/shin --check
//! cargo run --release --example make_shin -- fixtures/shin --gauges sites.json
//! ```
//!
//! With `--gauges` it also writes ten places for gauges on the inner wall: JSON, metres, each with
//! the direction the gauge measures in.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command reports to its user")]

use std::error::Error;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use hapdef_mesh::{
    Shin, ShinParams, atomic_write, clear_nodes, farthest_nodes, gauge_patch, shin, wall,
    write_glb, write_inp,
};
use nalgebra::{Point3, Vector3};

const DECK: &str = "shin.inp.gz";
const SKIN: &str = "shin_skin.glb";
const RIG_DECK: &str = "shin_rig.inp.gz";
const FILES: [&str; 3] = [DECK, SKIN, RIG_DECK];

/// A gauge keeps this from rims and ribs: an 8 × 5 mm gauge then fits.
const CLEARANCE_M: f64 = 5e-3;
const N_GAUGES: usize = 10;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("make_shin: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = PathBuf::from(arguments.first().ok_or("name the folder, such as fixtures/shin")?);
    let limb = shin(&ShinParams::default())?;
    match arguments.get(1).map(String::as_str) {
        None => write(&limb, &folder)?,
        Some("--check") => return check(&limb, &folder),
        Some("--gauges") => {
            write(&limb, &folder)?;
            let path = arguments.get(2).ok_or("--gauges needs a file name")?;
            write_gauges(&limb, Path::new(path))?;
        }
        Some(other) => return Err(format!("unknown option {other}").into()),
    }
    let mesh = &limb.deck.mesh;
    println!(
        "{}: {} FE nodes, {} elements, {} surface nodes, {} clamped",
        folder.display(),
        mesh.nodes().len(),
        mesh.elements().len(),
        limb.skin.nodes.len(),
        limb.deck.fixed_nodes.len()
    );
    Ok(())
}

fn write(limb: &Shin, folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    write_inp(&folder.join(DECK), &limb.deck)?;
    write_glb(&folder.join(SKIN), &limb.skin.surface(&limb.deck.mesh)?, None)?;
    write_inp(&folder.join(RIG_DECK), &shin(&ShinParams::meshed_anew())?.deck)?;
    Ok(())
}

/// Compares the decompressed contents: compressors may differ.
fn check(limb: &Shin, folder: &Path) -> Result<(), Box<dyn Error>> {
    let fresh = std::env::temp_dir().join(format!("make_shin-{}", std::process::id()));
    write(limb, &fresh)?;
    let same = FILES.map(|name| -> Result<bool, std::io::Error> {
        Ok(contents(&fresh.join(name))? == contents(&folder.join(name))?)
    });
    fs::remove_dir_all(&fresh)?;
    for (name, same) in FILES.into_iter().zip(same) {
        if !same? {
            let path = folder.join(name);
            return Err(format!(
                "{} is not what the generator makes: run it again",
                path.display()
            )
            .into());
        }
    }
    println!("{}: up to date", folder.display());
    Ok(())
}

fn contents(path: &Path) -> std::io::Result<Vec<u8>> {
    let stored = fs::read(path)?;
    if path.extension().is_none_or(|ending| ending != "gz") {
        return Ok(stored);
    }
    let mut plain = Vec::new();
    flate2::read::GzDecoder::new(stored.as_slice()).read_to_end(&mut plain)?;
    Ok(plain)
}

/// Every third gauge measures along the limb, the others around it.
fn write_gauges(limb: &Shin, path: &Path) -> Result<(), Box<dyn Error>> {
    let mesh = &limb.deck.mesh;
    let inside = wall(mesh, &mesh.boundary(), &limb.skin, 1.5 * ShinParams::default().wall_m)?;
    let clear = clear_nodes(mesh, &inside.inner_faces, CLEARANCE_M);
    let mut gauges = Vec::new();
    for (i, node) in farthest_nodes(mesh, &clear, N_GAUGES).into_iter().enumerate() {
        let position = mesh.position(node);
        let patch = gauge_patch(mesh, &inside.inner_faces, &position, 24, 1e-4)?;
        let axis = gauge_axis(&patch.normal, i % 3 == 2).ok_or("a wall across the limb's axis")?;
        gauges.push(serde_json::json!({
            "name": format!("g{i}"),
            "position_m": micrometres(&position),
            "axis": axis.map(|c| (c * 1e6).round() / 1e6).as_slice(),
        }));
    }
    let text = serde_json::to_string_pretty(&gauges)? + "\n";
    atomic_write(path, |file| std::io::Write::write_all(file, text.as_bytes()))?;
    Ok(())
}

/// A unit tangent of the wall, along the limb (y) or around it.
fn gauge_axis(normal: &Vector3<f64>, along: bool) -> Option<Vector3<f64>> {
    let around = Vector3::y().cross(normal).try_normalize(1e-6)?;
    Some(if along { normal.cross(&around) } else { around })
}

fn micrometres(position: &Point3<f64>) -> [f64; 3] {
    position.coords.map(|c| (c * 1e6).round() / 1e6).into()
}
