//! The integration tests of hapdef-kmax: one program.
#![cfg(feature = "points")]

mod examples;
mod laws;
