//! What every experiment needs, whatever it measures.
//!
//! - [`Study`]: what is taken from the rows of an experiment, and its page.
//! - [`stats`]: means, medians and quantiles.
//! - [`pareto_front`]: what is worth choosing where two costs count.
//! - [`table()`], [`page_table`], [`terminal_table`]: rows under [`Column`]s, as Markdown, on a page and on a terminal.
//! - [`Metric`], [`Goal`]: figures of [`Measurements`] as METRIC lines and beside their targets.
//! - [`against_time`], [`dotted_lines`]: charts.
//! - [`page_markdown`], [`write_made`], [`read_made`]: a page in the documentation, what a program makes of it below the
//!   words of people.
//! - [`robustness`]: tables of methods at their extremes.

mod chart;
mod page;
mod pareto;
pub mod robustness;
pub mod stats;
mod study;
mod summary;
mod table;
mod target;

pub use chart::{against_time, by_cost, dotted_lines};
pub use hapdef_report::text_table;
pub use page::{page_markdown, read_made, write_made};
pub use pareto::pareto_front;
pub use study::{Figure, Goal, Measurements, Metric, Named, Study};
pub use table::{Column, or_dash, page_table, table, terminal_table};
pub use target::Wanted;
