//! What known touches are worth where gauges' gains drift, on the simulated rig of a calibrated scene.
//!
//!     cargo run --release --example recalibration
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

mod study;

use std::path::{Path, PathBuf};

use anyhow::Result;

fn main() -> Result<()> {
    let scene = std::env::args_os().nth(1).map(PathBuf::from);
    let scene = scene.unwrap_or_else(|| "fixtures/shin/demo.json".into());
    let rows = study::study(&scene, Path::new("target/hapdef"), 300)?;
    println!("simulated; every tenth touch is declared at the place of another one\n");
    println!(
        "| known touches | wrong ones refused | right ones refused | wrong ones taken | gains off, % | in their sd | \
         contact off, mm | count right, % | two contacts off, mm | count right, % |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for row in rows {
        println!("{row}");
    }
    Ok(())
}
