//! What can go wrong in a verification run.

use std::path::{Path, PathBuf};

use hapdef_mesh::MeshError;
use hapdef_sim::SimError;

/// Why a case has no value, or a run could not be reported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// A case that can't be run here; not a failure.
    #[error("not run: {reason}")]
    NotRun {
        /// Why, in one line.
        reason: String,
    },
    /// A mesh that could not be made or read.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A model that could not be built or solved.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A figure or metric that could not be reported.
    #[error(transparent)]
    Report(#[from] hapdef_report::ReportError),
    /// A case whose own set-up is wrong.
    #[error("{what}: expected {expected}, found {found}")]
    Setup {
        /// What is wrong.
        what: &'static str,
        /// What was expected.
        expected: String,
        /// What was found.
        found: String,
    },
    /// A file that could not be read or written.
    #[error("{action} {}: {cause}", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's answer.
        cause: std::io::Error,
    },
}

impl VerifyError {
    /// The case can't be run here, for `reason`.
    pub fn not_run(reason: impl Into<String>) -> Self {
        Self::NotRun { reason: reason.into() }
    }

    /// `what` should be `expected` and is `found`.
    pub(crate) fn setup(
        what: &'static str,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::Setup { what, expected: expected.into(), found: found.into() }
    }

    /// The system refused `action` on `path`.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl Fn(std::io::Error) -> Self {
        move |cause| Self::Io { action, path: path.to_owned(), cause }
    }
}
