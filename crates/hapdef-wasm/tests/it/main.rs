//! The integration tests of hapdef-wasm: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod model;
mod session;
mod static_page;
mod support;
