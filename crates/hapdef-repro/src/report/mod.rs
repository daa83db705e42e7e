//! What a report of this crate is compared with, and the short page made from it.

mod golden;
mod results;
mod stale;

pub use golden::Golden;
pub use results::results_markdown;
pub use stale::check_results;
