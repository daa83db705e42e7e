//! Recordings read by other programs: Python's mcap, mcap-ros2-support and rosbags, and rerun.

use anyhow::Result;

use crate::python::{environment, install, usable};
use crate::tool::{cargo, run, target_dir};

const PACKAGES: [&str; 4] = ["mcap", "mcap-ros2-support", "rosbags", "rerun-sdk"];

/// Tests that compare what they read with what was written.
const TESTS: [&str; 2] = ["readers::", "wire::"];

/// Without Python, or outside CI without a network, it says so and does nothing.
pub(crate) fn check() -> Result<()> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    if let Err(reason) = usable(&python) {
        println!("skipped: {reason}");
        return Ok(());
    }
    let python = environment(&python, &target_dir()?.join("python/readers"), false)?;
    match install(&python, &PACKAGES) {
        Err(error) if std::env::var("CI").is_ok_and(|ci| ci == "true") => return Err(error),
        Err(error) => {
            println!("skipped: pip has no readers here: {error:#}");
            return Ok(());
        }
        Ok(()) => {}
    }
    let mut command = cargo(&["test", "--release", "--test", "it"]);
    command.arg("--").args(TESTS).arg("--nocapture");
    run(command.env("HAPDEF_PYTHON", python))
}
