//! The integration tests of the program hapdef.

mod bad_input;
mod calibrate_command;
mod deck;
mod live;
mod live_browser;
mod live_device;
mod live_page;
mod person;
mod recording_commands;
mod shell_limb_command;
#[path = "../../../hapdef/tests/it/shell_limb_common/mod.rs"]
mod shell_limb_common;
mod support;
mod wire;
