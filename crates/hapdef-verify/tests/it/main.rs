//! The integration tests of hapdef-verify: one program.

mod robustness;
mod shell_patch;
