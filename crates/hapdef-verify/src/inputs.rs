//! Files that are shared between workplaces and never committed.

use std::path::{Path, PathBuf};

use crate::VerifyError;

/// The file `path` in the shared inputs: under `HAPDEF_SHARED`, or `shared` beside the workspace.
pub(crate) fn shared(path: &str) -> Result<PathBuf, VerifyError> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let root = std::env::var_os("HAPDEF_SHARED").map_or(beside, PathBuf::from);
    let file = root.join("inputs").join(path);
    if file.exists() {
        Ok(file)
    } else {
        let reason = format!("inputs/{path} is not in the shared inputs (set HAPDEF_SHARED)");
        Err(VerifyError::not_run(reason))
    }
}
