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
