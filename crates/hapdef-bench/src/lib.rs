//! What every experiment needs, whatever it measures.
//!
//! - [`stats`]: means, medians and quantiles.
//! - [`pareto_front`]: what is worth choosing where two costs count.
//! - [`table()`], [`terminal_table`]: rows under [`Column`]s, as Markdown, on a page and on a terminal.
//! - [`Metric`], [`Goal`]: figures of [`Measurements`] as METRIC lines and beside their targets.
//! - [`publish`]: the page of a study.

mod pareto;
pub mod stats;
mod study;
mod table;
mod target;

pub use pareto::pareto_front;
pub use study::{Figure, Goal, Measurements, Metric, goal_table, log_metrics, publish};
pub use table::{Column, or_dash, table, terminal_table, text_table};
pub use target::{Target, Wanted, target_table};
