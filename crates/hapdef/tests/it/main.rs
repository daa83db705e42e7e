//! The integration tests of hapdef: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod bundle;
mod bundle_nets;
mod demo_scene;
mod examples;
mod fuzz_short;
mod moving;
mod phantom;
mod plan;
mod print;
mod recalibration;
mod robot;
mod saturation;
mod scene_search;
mod session;
mod shell_limb;
mod shell_limb_common;
mod shell_response;
mod skin_scene;
mod skin_solver;
mod skips;
mod support;
mod touch;
mod touch_sensor;
