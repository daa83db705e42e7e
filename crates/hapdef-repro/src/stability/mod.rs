//! Whether a baseline, a net, superposition or a part around them is ever silently wrong: data and
//! settings at their extremes.
//!
//! Rows draw their data by a seed, of which 0 is that of the tables.
//!
//! Every row says what must hold. It is `accurate` where that holds, `refused` where the method
//! gave a typed error, and wrong where neither is so.

mod cases;
mod document;
mod inverse;
mod parts;
mod plant;
mod quantised;
mod row;

use std::sync::Arc;

pub use document::{
    INVERSE as INVERSE_DOCUMENT, NETS as NETS_DOCUMENT, PARTS as PARTS_DOCUMENT, stability_line,
};
pub use inverse::InverseWorld;
pub use row::{StabilityFigure, StabilityRow};

/// Runs every row of docs/stability-nets.md in its order; each goes to `progress` as it comes.
pub fn nets_rows(seed: u64, progress: impl FnMut(&StabilityRow)) -> Vec<StabilityRow> {
    let mut all = cases::cases(seed);
    quantised::quantised(&mut all, seed);
    rows(all, progress)
}

/// Runs every row of docs/stability-parts.md in its order; each goes to `progress` as it comes.
pub fn parts_rows(seed: u64, progress: impl FnMut(&StabilityRow)) -> Vec<StabilityRow> {
    rows(parts::cases(seed), progress)
}

/// Runs every row of docs/stability-inverse.md in its order; each goes to `progress` as it comes.
pub fn inverse_rows(
    world: &Arc<InverseWorld>,
    progress: impl FnMut(&StabilityRow),
) -> Vec<StabilityRow> {
    rows(inverse::cases(world), progress)
}

fn rows(cases: Vec<row::Case>, mut progress: impl FnMut(&StabilityRow)) -> Vec<StabilityRow> {
    let rows = cases.into_iter().map(|case| {
        let row = case.row();
        progress(&row);
        row
    });
    rows.collect()
}
