//! `hapdef-repro`: the paper's tables and figures for a scene.
#![expect(clippy::print_stdout, reason = "a command line program prints")]

mod bench;
mod run;

use std::process::ExitCode;

use clap::Parser;

/// Training allocates many buffers of one size; this allocator halves its time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    hapdef::exit_code(run::run(&run::Cli::parse()).map_err(Into::into))
}
