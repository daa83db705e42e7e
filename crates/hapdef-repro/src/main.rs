//! `hapdef-repro`: the paper's tables and figures for a scene.
#![expect(clippy::print_stdout, reason = "a command line program prints")]

mod allocations;
mod baselines;
mod bench;
mod compare;
mod error;
mod frontier;
mod report;
mod robustness;
mod run;
mod search;
mod tables;
mod tactile;

use std::process::ExitCode;

use clap::Parser;

#[global_allocator]
static ALLOCATOR: allocations::Counting = allocations::Counting;

fn main() -> ExitCode {
    hapdef_cli::exit_code(run::run(&run::Cli::parse()).map_err(Into::into))
}
