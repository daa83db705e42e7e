//! Whether the solver is ever silently wrong: problems with a known solution at extremes of shape,
//! stiffness, size and load, and problems without a solution.
//!
//! Every solution comes with a bound on its error. A row is `accurate` where the error against the
//! known solution is within that bound, `refused` where the solver gave a typed error, and wrong
//! where neither holds.

mod document;
mod field;
mod jumps;
mod refusals;
mod row;
mod shells;
mod solid;
mod solids;

pub use document::{STABILITY_DOCUMENT, stability_line};
pub use row::{StabilityFigures, StabilityRow};

use crate::VerifyError;

/// Solves every row of docs/stability-fe.md in its order; `seed` draws the scattered jumps. Each
/// row goes to `progress` as it comes.
///
/// # Errors
/// [`VerifyError::Setup`] and [`VerifyError::NotRun`] if a row's own set-up is broken.
pub fn stability_rows(
    seed: u64,
    mut progress: impl FnMut(&StabilityRow),
) -> Result<Vec<StabilityRow>, VerifyError> {
    let groups = [solids::trials(), jumps::trials(seed), shells::trials(), refusals::trials()];
    let mut rows = Vec::new();
    for trial in groups.into_iter().flatten() {
        let row = trial.row()?;
        progress(&row);
        rows.push(row);
    }
    Ok(rows)
}
