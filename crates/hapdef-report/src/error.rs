//! What can go wrong in this crate.

use std::path::{Path, PathBuf};

use crate::argument::ArgumentError;

/// Why something could not be drawn, printed or written. Each variant carries what was found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum ReportError {
    #[error(transparent)]
    Argument(#[from] ArgumentError),
    #[error("{what}: value {index} is {value}; every value must be finite")]
    NotFinite { what: &'static str, index: usize, value: f64 },
    #[error("{what}: {found} values, at least {needed} are needed")]
    TooFew { what: &'static str, needed: usize, found: usize },
    #[error(
        "report {title:?}: no hashes; say what it was made from, such as the scene's and the deck's"
    )]
    NoHashes { title: String },
    #[error("drawing {figure}: {message}")]
    Draw { figure: &'static str, message: String },
    #[error("{action} {path}: {source}", path = path.display())]
    Io { action: &'static str, path: PathBuf, source: std::io::Error },
    #[error("{path}: {source}; move the file away or repair it", path = path.display())]
    Json { path: PathBuf, source: serde_json::Error },
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
