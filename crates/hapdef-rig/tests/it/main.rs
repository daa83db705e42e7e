//! The integration tests of hapdef-rig: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod live_device;
mod live_electronics;
mod live_hands;
mod live_ports;
mod live_presses;
mod live_support;
mod real_limb;
