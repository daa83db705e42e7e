//! The integration tests of hapdef-repro: one program.

mod bench_nets;
mod determinism;
mod tactile;
