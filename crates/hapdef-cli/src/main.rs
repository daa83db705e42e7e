//! `hapdef`: from a limb to contacts on the command line.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command line program prints")]

mod cli;

use std::process::ExitCode;

use clap::Parser;

/// Training allocates many buffers of one size; this allocator halves its time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    match cli::run(&cli::Cli::parse()) {
        Err(error) if is_end_of_reader(&error) => ExitCode::SUCCESS,
        result => hapdef_cli::exit_code(result.map_err(Into::into)),
    }
}

/// Whether who reads the output has closed it, as `head` does.
fn is_end_of_reader(error: &anyhow::Error) -> bool {
    let io = |cause: &(dyn std::error::Error + 'static)| {
        let io = cause.downcast_ref::<std::io::Error>();
        io.map(std::io::Error::kind)
    };
    let mut kinds = error.chain().filter_map(io);
    kinds.any(|kind| kind == std::io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_that_has_enough_is_no_error() {
        let error = |kind| anyhow::Error::from(std::io::Error::from(kind)).context("line 3");
        assert!(is_end_of_reader(&error(std::io::ErrorKind::BrokenPipe)));
        assert!(!is_end_of_reader(&error(std::io::ErrorKind::StorageFull)));
    }
}
