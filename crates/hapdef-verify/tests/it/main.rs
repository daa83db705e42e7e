//! The integration tests of hapdef-verify: one program.

mod shell_patch;
mod stability;
