//! The integration tests of hapdef-sim: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod authors_limb;
mod common;
mod conditioning;
mod convergence;
mod element;
mod examples;
mod gauges;
mod iterative;
mod loads;
mod shell_element;
mod shell_model;
mod statics;
mod supports;
mod ties;
mod wanted_rows;
