//! The bundled limb, made by the generator in hapdef-mesh.

use std::process::Command;

use anyhow::Result;

use crate::tool::{release_example, root, run};

/// Writes fixtures/shin, or compares it with what the generator makes now.
pub(crate) fn make(check: bool) -> Result<()> {
    let mut command = Command::new(release_example("make_shin")?);
    command.arg("fixtures/shin").current_dir(root());
    if check {
        command.arg("--check");
    }
    run(&mut command)
}
