//! `hapdef`: from a limb to contacts on the command line.

/// Everything that is printed goes through one place.
macro_rules! println {
    ($($text:tt)*) => { hapdef_cli::print_line(format_args!($($text)*)) };
}

macro_rules! eprintln {
    ($($text:tt)*) => { hapdef_cli::note_line(format_args!($($text)*)) };
}

mod cli;

use std::process::ExitCode;

use clap::Parser;

/// Training allocates many buffers of one size; this allocator halves its time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let cli = match cli::Cli::try_parse() {
        Ok(cli) => cli,
        Err(refused) => refuse(refused),
    };
    match cli::run(&cli) {
        Err(error) if is_end_of_reader(&error) => ExitCode::SUCCESS,
        Err(error) => hapdef_cli::exit_code(Err(error.into())),
        Ok(()) => hapdef_cli::exit_code(hapdef_cli::check_printed().map_err(Into::into)),
    }
}

/// Says what is wrong with the arguments, or the help that they ask for. It shows arguments as it has them, so
/// it has them as they may be shown.
fn refuse(refused: clap::Error) -> ! {
    let words = std::env::args_os().map(|word| hapdef_contact::printable(&word.to_string_lossy()));
    cli::Cli::try_parse_from(words).err().unwrap_or(refused).exit()
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
