//! The integration tests of hapdef-ros: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

#[cfg(feature = "foxglove")]
mod foxglove;
mod readers;
mod recording;
mod support;
#[cfg(feature = "zenoh")]
mod zenoh;
#[cfg(feature = "zenoh")]
mod zenoh_source;
