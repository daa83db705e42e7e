//! The integration tests of hapdef-nets: one program.

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
