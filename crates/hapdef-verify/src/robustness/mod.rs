//! Whether the solver is ever silently wrong: problems with a known solution at extremes of shape,
//! stiffness, size and load, and problems without a solution.
//!
//! Every solution comes with a bound on its error. A row is `accurate` where the error against the
//! known solution is within that bound, `refused` where the solver gave a typed error, and wrong
//! where neither holds.

mod field;
mod jumps;
mod refusals;
mod shells;
mod solid;
mod solids;
mod table;

use hapdef_report::robustness::Row;

pub(crate) use field::{bend, material, uniform};
pub(crate) use solid::{Block, grid, turn, wobble};
pub use table::ROBUSTNESS_TABLE;

use crate::VerifyError;

/// Solves every row of docs/stability-fe.md in its order; `seed` draws the scattered jumps. Each
/// row goes to `progress` as it comes.
///
/// # Errors
/// [`VerifyError::Setup`] and [`VerifyError::NotRun`] if a row's own set-up is broken.
pub fn robustness_rows(seed: u64, progress: impl FnMut(&Row)) -> Result<Vec<Row>, VerifyError> {
    let trials = [solids::trials(), jumps::trials(seed), shells::trials(), refusals::trials()];
    ROBUSTNESS_TABLE.rows(trials.into_iter().flatten(), table::refusal, progress)
}
