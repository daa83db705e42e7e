//! The integration tests of the program hapdef.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod bad_input;
mod calibrate_command;
mod deck;
mod json;
mod live;
mod live_browser;
mod live_device;
mod live_page;
mod live_robot;
mod mesh_command;
mod new_limb;
mod person;
mod printed;
mod recalibrate_command;
mod recording_commands;
mod shell_limb_command;
#[path = "../../../hapdef/tests/it/shell_limb_common/mod.rs"]
mod shell_limb_common;
mod support;
mod wire;
