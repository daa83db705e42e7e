//! The integration tests of hapdef-inverse: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod calibration;
mod conditioning;
mod confidence_regions;
mod examples;
mod limb;
mod other_loads;
mod placement;
mod recalibration;
mod recovery;
mod response;
mod search;
mod stability;
mod tracking;
mod tracking_allocations;
mod wide;
mod world;
