//! What several tests share.

pub mod page;

use std::path::{Path, PathBuf};

use hapdef_mesh::{GltfParams, SurfaceMesh, read_gltf};

/// A file or folder of the shared ones, if that is there; else it says what is skipped.
pub fn shared(name: &str) -> Option<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let path = std::env::var_os("HAPDEF_SHARED").map_or(here, PathBuf::from).join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: {} is not there (set HAPDEF_SHARED)", path.display());
    None
}

/// A surface in metres.
pub fn surface(path: &Path) -> SurfaceMesh {
    read_gltf(path, &GltfParams::default()).unwrap().mesh
}
