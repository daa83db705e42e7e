//! What several tests share.

#[path = "../../../../hapdef-daq/tests/it/support/damage.rs"]
pub mod damage;
pub mod page;

use std::path::Path;

use hapdef_mesh::{GltfParams, SurfaceMesh, read_gltf};

#[path = "../../../../hapdef/tests/it/support/mod.rs"]
mod shared_files;
pub use shared_files::shared;

/// A surface in metres.
pub fn surface(path: &Path) -> SurfaceMesh {
    read_gltf(path, &GltfParams::default()).unwrap().mesh
}

/// Whether this is a long run (HAPDEF_SOAK=1); else it says what is skipped.
pub fn is_long_run() -> bool {
    let is_long = std::env::var_os("HAPDEF_SOAK").is_some();
    if !is_long {
        println!("skipped: a long run has it (HAPDEF_SOAK=1)");
    }
    is_long
}
