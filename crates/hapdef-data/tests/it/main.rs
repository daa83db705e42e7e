//! The integration tests of hapdef-data: one program.

mod dataset;
mod standardiser;
