//! The one error type of the crate.

use hapdef::HapdefError;

/// Why a run can't be prepared.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each variant's message says what it is")]
pub enum PrepareError {
    #[error(transparent)]
    Run(#[from] HapdefError),
    #[error("catching Ctrl-C: {0}; is there another handler in this process?")]
    Signal(ctrlc::Error),
}
