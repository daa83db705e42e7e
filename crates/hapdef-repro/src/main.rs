//! `hapdef-repro`: the paper's tables and figures for a scene.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a command line program prints"
)]

mod run;

use std::process::ExitCode;

use clap::Parser;

/// Training allocates many buffers of one size; this allocator halves its time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Exit code for everything that a person can correct.
const FAILED: u8 = 2;

fn main() -> ExitCode {
    match run::run(&run::Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", hapdef::error_text(error.as_ref()));
            ExitCode::from(FAILED)
        }
    }
}
