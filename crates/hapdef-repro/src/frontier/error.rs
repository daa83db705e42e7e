//! What makes a frontier wrong.

use std::path::PathBuf;

/// Why a frontier is not written, or one that was written no longer holds.
#[derive(Debug, thiserror::Error)]
pub(super) enum FrontierError {
    /// Leaving out what a scene does not need changes what is found.
    #[error(
        "{frames}: of {n_single} frames in which the scene that wants everything finds one contact, the \
         scene of single contacts finds the same in {n_equal}; what is left out must not change it"
    )]
    SkipsChangeContacts {
        /// Which frames.
        frames: &'static str,
        /// Frames in which the whole scene finds one contact.
        n_single: usize,
        /// Those of them in which the other scene finds the same to rounding.
        n_equal: usize,
    },
    /// The page in the docs is not what would be written now.
    #[error(
        "{path}: {}; find out why, then `cargo xtask frontier --write`",
        differences.join("; "),
        path = path.display()
    )]
    Stale {
        /// The page, or the figures beside it.
        path: PathBuf,
        /// What differs, each in words.
        differences: Vec<String>,
    },
}
