//! The integration tests of hapdef-live: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod allocations;
mod bundle;
mod doubt;
mod drift_laws;
mod runtime;
mod sinks;
mod stalled_client;
mod steps;
mod support;
mod tare;
mod tare_laws;
mod trust_laws;
mod wire;
