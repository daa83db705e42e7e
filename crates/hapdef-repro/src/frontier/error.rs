//! What makes a frontier wrong.

use std::path::PathBuf;

/// Why a frontier is not written, or one that was written no longer holds.
#[derive(Debug, thiserror::Error)]
pub(super) enum FrontierError {
    #[error(
        "{frames}: of {n_single} frames in which the scene that wants everything finds one contact, the \
         scene of single contacts finds the same in {n_equal}; what is left out must not change it"
    )]
    SkipsChangeContacts { frames: &'static str, n_single: usize, n_equal: usize },
    #[error(
        "{path}: {}; find out why, then `cargo xtask frontier --write`",
        differences.join("; "),
        path = path.display()
    )]
    Stale { path: PathBuf, differences: Vec<String> },
}
