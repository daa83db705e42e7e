//! The integration tests of hapdef-live: one program.

mod allocations;
mod bundle;
mod doubt;
mod runtime;
mod sinks;
mod stalled_client;
mod support;
mod wire;
