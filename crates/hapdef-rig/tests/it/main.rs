//! The integration tests of hapdef-rig: one program.

mod live_device;
mod live_electronics;
mod live_ports;
mod live_presses;
mod live_support;
mod real_limb;
