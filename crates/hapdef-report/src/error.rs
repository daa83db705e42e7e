//! What can go wrong in this crate.

use std::path::{Path, PathBuf};

use crate::argument::ArgumentError;

/// Why something could not be drawn, printed or written. Each variant carries what was found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// An argument of a figure, a report or a metric.
    #[error(transparent)]
    Argument(#[from] ArgumentError),
    /// A value is NaN or infinite.
    #[error("{what}: value {index} is {value}; every value must be finite")]
    NotFinite {
        /// The argument.
        what: &'static str,
        /// Position in the slice.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// There is less than a figure needs.
    #[error("{what}: {found} values, at least {needed} are needed")]
    TooFew {
        /// The figure.
        what: &'static str,
        /// The least number that works.
        needed: usize,
        /// Values given.
        found: usize,
    },
    /// Results that don't say from what they were made.
    #[error(
        "report {title:?}: no hashes; say what it was made from, such as the scene's and the deck's"
    )]
    NoHashes {
        /// The report's heading.
        title: String,
    },
    /// A figure could not be drawn.
    #[error("drawing {figure}: {message}")]
    Draw {
        /// Which figure.
        figure: &'static str,
        /// What the drawing library said.
        message: String,
    },
    /// A file could not be read or written.
    #[error("{action} {path}: {source}", path = path.display())]
    Io {
        /// What was being done, such as "writing".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file that should hold JSON of a known form holds something else.
    #[error("{path}: {source}; move the file away or repair it", path = path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Where and why it does not fit.
        source: serde_json::Error,
    },
}

impl ReportError {
    /// [`ReportError::Io`] of what was being done with a file, such as "writing".
    pub fn io(action: &'static str, path: &Path) -> impl Fn(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Io { action, path: path.clone(), source }
    }

    /// [`ReportError::Json`] of a file.
    pub fn json(path: &Path) -> impl Fn(serde_json::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Json { path: path.clone(), source }
    }
}
