//! The integration tests of hapdef-view: one program.

mod browser;
mod browser_looks;
mod browser_reads;
mod feed;
mod security;
mod support;
