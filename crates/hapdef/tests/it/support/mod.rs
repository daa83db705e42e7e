//! What several tests need.

use std::path::{Path, PathBuf};

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
