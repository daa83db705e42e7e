//! Whether a baseline or a net is ever silently wrong: data and settings at their extremes.
//!
//! Every row says what must hold. It is `accurate` where that holds, `refused` where the method
//! gave a typed error, and wrong where neither is so.

mod cases;
mod document;
mod plant;
mod row;

pub use document::{nets_differences, nets_line, nets_markdown};
pub use row::{NetsFigure, NetsRefusal, NetsRow, NetsVerdict, NetsWanted};

/// Runs every row of docs/stability-nets.md in its order; each goes to `progress` as it comes.
pub fn nets_rows(mut progress: impl FnMut(&NetsRow)) -> Vec<NetsRow> {
    let rows = cases::cases().into_iter().map(|case| {
        let row = case.row();
        progress(&row);
        row
    });
    rows.collect()
}
