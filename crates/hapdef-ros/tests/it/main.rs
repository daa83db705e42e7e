//! The integration tests of hapdef-ros: one program.

#[cfg(feature = "foxglove")]
mod foxglove;
mod readers;
mod recording;
mod support;
#[cfg(feature = "zenoh")]
mod zenoh;
