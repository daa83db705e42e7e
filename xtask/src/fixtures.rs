//! The bundled limb, made by the generator in hapdef-mesh.

use anyhow::Result;

use crate::tool::{cargo, run};

/// Writes fixtures/shin, or compares it with what the generator makes now.
pub(crate) fn make(check: bool) -> Result<()> {
    let mut words = vec![
        "run",
        "--quiet",
        "--release",
        "-p",
        "hapdef-mesh",
        "--example",
        "make_shin",
        "--",
    ];
    words.push("fixtures/shin");
    if check {
        words.push("--check");
    }
    run(&mut cargo(&words))
}
