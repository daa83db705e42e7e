//! Robustness tables: methods at extremes of their data and settings, what must hold, and what came
//! out.
//!
//! - [`Trials`]: extremes to be tried; [`Table::rows`] runs them and gives [`Row`]s.
//! - [`Table::publish`]: rows as metrics, page, file in docs/, and the check of that file.
//! - [`publish_all`]: the rows of several tables as one page.

mod column;
mod document;
mod publish;
mod row;
mod trial;

pub use column::Column;
pub use document::Table;
pub use publish::{Inputs, Outputs, Published, publish_all};
pub use row::{Measured, Refusal, Row, SolverMetrics, Verdict};
pub use trial::{Expected, MustHold, Refused, Trials};

#[cfg(test)]
mod tests;
