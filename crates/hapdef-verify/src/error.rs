//! What can go wrong in a verification run.

use hapdef_mesh::MeshError;
use hapdef_sim::SimError;

/// Why a case has no value, or a run could not be reported.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    #[error("not run: {reason}")]
    NotRun { reason: String },
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Sim(#[from] SimError),
    #[error(transparent)]
    Report(#[from] hapdef_report::ReportError),
    #[error("{what}: expected {expected}, found {found}")]
    Setup { what: &'static str, expected: String, found: String },
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
}
