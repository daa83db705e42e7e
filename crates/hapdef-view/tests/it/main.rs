//! The integration tests of hapdef-view: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod browser;
mod browser_looks;
mod browser_reads;
mod browser_simulated;
mod feed;
mod robot;
mod security;
mod support;
