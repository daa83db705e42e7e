//! The integration tests of hapdef-report: one program.

mod browser;
mod figures;
mod page;
