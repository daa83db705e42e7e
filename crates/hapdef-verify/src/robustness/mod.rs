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

pub(crate) use field::{bend, material, uniform};
pub(crate) use solid::{Block, grid, turn, wobble};
pub use table::{ROBUSTNESS_TABLE, RobustnessTrials};

/// Every row of docs/stability-fe.md in its order; `seed` draws the scattered jumps.
pub fn robustness_trials(seed: u64) -> RobustnessTrials {
    let mut rows = RobustnessTrials::new(());
    solids::add(&mut rows);
    jumps::add(&mut rows, seed);
    shells::add(&mut rows);
    refusals::add(&mut rows);
    rows
}

#[cfg(test)]
mod tests {
    use hapdef_bench::robustness::Row;

    use super::*;

    /// Whichever elements are stiff.
    #[test]
    fn no_row_is_silently_wrong() {
        let rows = ROBUSTNESS_TABLE.rows(robustness_trials(3), |row| println!("{}", row.line()));
        let failed: Vec<String> = rows.iter().filter(|row| row.failed).map(Row::line).collect();
        assert!(rows.len() > 150, "{} rows", rows.len());
        assert!(failed.is_empty(), "{failed:#?}");
    }
}
