//! Whether a baseline, a net, superposition or a part around them is ever silently wrong: data and
//! settings at their extremes.
//!
//! Rows draw their data by a seed, of which 0 is that of the tables.
//!
//! Every row says what must hold. It is `accurate` where that holds, `refused` where the method
//! gave a typed error, and wrong where neither is so.

mod cases;
mod inverse;
mod parts;
mod plant;
mod quantised;
mod table;

use std::convert::Infallible;
use std::sync::Arc;

use hapdef_report::robustness::{Row, Table};

pub use inverse::InverseWorld;
pub use table::{INVERSE_TABLE, NETS_TABLE, PARTS_TABLE};

/// Runs every row of docs/stability-nets.md in its order; each goes to `progress` as it comes.
pub fn nets_rows(seed: u64, progress: impl FnMut(&Row)) -> Vec<Row> {
    let all = cases::trials(seed).into_iter().chain(quantised::trials(seed)).collect();
    rows(&NETS_TABLE, all, progress)
}

/// Runs every row of docs/stability-parts.md in its order; each goes to `progress` as it comes.
pub fn parts_rows(seed: u64, progress: impl FnMut(&Row)) -> Vec<Row> {
    rows(&PARTS_TABLE, parts::trials(seed), progress)
}

/// Runs every row of docs/stability-inverse.md in its order; each goes to `progress` as it comes.
pub fn inverse_rows(world: &Arc<InverseWorld>, progress: impl FnMut(&Row)) -> Vec<Row> {
    rows(&INVERSE_TABLE, inverse::trials(world), progress)
}

fn rows(table: &Table, trials: Vec<table::Trial>, progress: impl FnMut(&Row)) -> Vec<Row> {
    let refusal = |error| Ok::<_, Infallible>(table::refusal(&error));
    table.rows(trials, refusal, progress).unwrap_or_else(|never| match never {})
}
