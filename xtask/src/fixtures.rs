//! The bundled limb, made by the generator in hapdef-mesh, and the calibration of the live demo.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use crate::tool::{release_binary, release_example, root, run, target_dir};

/// The bundled limb, calibrated by presses of its rig: what `demo` shows.
pub(crate) const DEMO: &str = "fixtures/shin/demo.json";

/// The scene that is pressed and calibrated, and the file that [`DEMO`] names.
const PRESSED: &str = "fixtures/shin/placed.json";
const CALIBRATION: &str = "fixtures/shin/demo_calibration.json.gz";
const N_PRESSES: &str = "300";

/// Writes fixtures/shin, or compares the limb with what the generator makes now. The calibration is not
/// compared: its last digits are a processor's own.
pub(crate) fn make(check: bool) -> Result<()> {
    let mut command = Command::new(release_example("make_shin")?);
    command.arg("fixtures/shin").current_dir(root());
    if check {
        command.arg("--check");
    }
    run(&mut command)?;
    if check {
        return Ok(());
    }
    calibrate(&target_dir()?.join("demo-presses.csv"))
}

/// Presses the simulated rig and calibrates with that.
fn calibrate(presses: &Path) -> Result<()> {
    let folder = presses.parent().context("target folder")?;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let hapdef = || -> Result<Command> {
        let mut command = Command::new(release_binary("hapdef")?);
        command.current_dir(root());
        Ok(command)
    };
    run(hapdef()?.args(["probe", PRESSED]).arg(presses).args(["--presses", N_PRESSES]))?;
    run(hapdef()?.args(["calibrate", PRESSED]).arg(presses).arg(CALIBRATION))
}
