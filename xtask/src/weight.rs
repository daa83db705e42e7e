//! What somebody compiles who takes one layer alone.

mod build;
mod layers;
mod shared;
mod table;

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};

use crate::metrics;
use crate::tool::{results, root};

use build::Built;
use layers::{LAYERS, Layers};

/// Arguments of `weight`.
#[derive(clap::Args)]
pub(crate) struct WeightArgs {
    /// Build every layer, not the robot's alone, in release, one after the other, each from nothing in a
    /// folder of its own, and write the table in ARCHITECTURE.md after each (minutes).
    #[arg(long)]
    build: bool,
    /// Fail where the table in ARCHITECTURE.md says something else.
    #[arg(long, conflicts_with = "build")]
    check: bool,
    /// Taken for the sake of scripts and not used: what is compiled knows no limb.
    #[arg(long)]
    scene: Option<PathBuf>,
    /// The seed that the metrics carry; nothing is drawn.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// A robot's build that reads by TCP has fewer crates than this; serial ports come on top.
const MAX_ROBOT_CRATES: usize = 60;

/// The layer that is built unless all are or the table is checked.
const ROBOT: &str = "robot";

/// The layer that CI builds: the lightest, seconds.
const BUILT_IN_CI: &str = "kmax";

/// How far its bytes may be from those in the table, as a share of those: compilers differ.
const BYTES_TOLERANCE: f64 = 0.25;

/// A layer and what it weighs.
struct Row {
    layers: &'static Layers,
    /// Its own included.
    n_crates: usize,
    /// What a build showed, if there was one.
    built: Option<Built>,
}

/// `cargo xtask weight`.
pub(crate) fn run(args: &WeightArgs) -> Result<()> {
    if let Some(scene) = &args.scene {
        eprintln!("{} is not used: what is compiled knows no limb", scene.display());
    }
    let mut rows = counted()?;
    check_robot(&rows)?;
    if args.check {
        shared::check()?;
        check(&rows)?;
    }
    for i in 0..rows.len() {
        let is_wanted = args.build || (rows[i].layers.name == ROBOT && !args.check);
        if !is_wanted {
            continue;
        }
        eprintln!("── {}", rows[i].layers.shown());
        rows[i].built = Some(build::measure(rows[i].layers)?);
        if args.build {
            write(&rows)?;
        }
    }
    println!("{}", table::text(&rows));
    report(&rows, args.seed);
    Ok(())
}

/// What CI checks: nothing is compiled twice, the crates of every layer, the robot's limit, and the bytes of the
/// lightest layer.
pub(crate) fn check_table() -> Result<()> {
    shared::check()?;
    let mut rows = counted()?;
    check_robot(&rows)?;
    check(&rows)?;
    let is_built = |row: &&mut Row| row.layers.name == BUILT_IN_CI;
    for row in rows.iter_mut().filter(is_built) {
        let built = build::measure(row.layers)?;
        check_bytes(row, &built)?;
    }
    Ok(())
}

/// Every layer with its crates, as Cargo.lock has them.
fn counted() -> Result<Vec<Row>> {
    let row = |layers: &'static Layers| {
        let n_crates = layers.crates()?.len();
        Ok(Row { layers, n_crates, built: None })
    };
    LAYERS.iter().map(row).collect()
}

/// The figures as METRIC lines, those that were measured in metrics.json, too.
fn report(rows: &[Row], seed: u64) {
    let mut figures = Vec::new();
    for row in rows {
        let of = |what: &str| format!("weight.{}_{what}", row.layers.name);
        figures.push((of("crates"), row.n_crates as f64, "1"));
        match &row.built {
            Some(built) => {
                figures.push((of("build_s"), built.seconds, "s"));
                figures.push((of("bytes"), built.bytes as f64, "B"));
            }
            None => {
                for what in ["build_s", "bytes"] {
                    println!("METRIC:{}:skipped:--build not given", of(what));
                }
            }
        }
    }
    let figures: Vec<(&str, f64, &str)> =
        figures.iter().map(|(name, value, unit)| (name.as_str(), *value, *unit)).collect();
    metrics::report(&figures, seed, Some(&results().join("metrics.json")));
}

fn check_robot(rows: &[Row]) -> Result<()> {
    for row in rows.iter().filter(|row| row.layers.is_limited) {
        if row.n_crates >= MAX_ROBOT_CRATES {
            bail!(
                "a robot's build of {} is {} crates, expected less than {MAX_ROBOT_CRATES}: \
                 cargo tree --no-default-features shows which came",
                row.layers.shown(),
                row.n_crates
            );
        }
    }
    Ok(())
}

fn check(rows: &[Row]) -> Result<()> {
    let faults = table::faults(&architecture()?, rows)?;
    if faults.is_empty() {
        return Ok(());
    }
    bail!(
        "ARCHITECTURE.md, Weight; `cargo xtask weight --build` writes it, if the difference is wanted:\n  {}",
        faults.join("\n  ")
    )
}

fn check_bytes(row: &Row, built: &Built) -> Result<()> {
    let name = row.layers.name;
    let Some(expected) = table::megabytes(&architecture()?, name)? else {
        return Ok(());
    };
    let found = built.megabytes();
    if (found - expected).abs() > BYTES_TOLERANCE * expected {
        bail!(
            "{name}: {found:.1} MB of rlibs, ARCHITECTURE.md says {expected}, and {:.0} % from that is allowed",
            BYTES_TOLERANCE * 100.0
        );
    }
    Ok(())
}

fn write(rows: &[Row]) -> Result<()> {
    let text = table::replaced(&architecture()?, rows, &build::made()?)?;
    fs::write(root().join("ARCHITECTURE.md"), text).context("writing ARCHITECTURE.md")
}

fn architecture() -> Result<String> {
    fs::read_to_string(root().join("ARCHITECTURE.md")).context("reading ARCHITECTURE.md")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robots_build_that_is_too_heavy_fails() {
        let rows = |n_crates| {
            let row = |layers| Row { layers, n_crates, built: None };
            LAYERS.iter().map(row).collect::<Vec<_>>()
        };
        assert!(check_robot(&rows(MAX_ROBOT_CRATES - 1)).is_ok());
        let error = check_robot(&rows(MAX_ROBOT_CRATES)).unwrap_err();
        assert!(error.to_string().contains("hapdef-live"), "{error}");
        let mut serial_only = rows(1);
        for row in &mut serial_only {
            row.n_crates += MAX_ROBOT_CRATES * usize::from(!row.layers.is_limited);
        }
        assert!(check_robot(&serial_only).is_ok(), "serial ports come on top");
    }
}
