//! The integration tests of hapdef-nets: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

#[cfg(feature = "candle")]
mod candle;
mod infer;
mod infer_allocations;
mod lean;
#[cfg(feature = "train")]
mod output_modes;
#[cfg(feature = "train")]
mod resume;
#[cfg(feature = "train")]
mod training;
#[cfg(feature = "train")]
mod training_common;
