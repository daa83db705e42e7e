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
        Err(error) if hapdef_cli::is_end_of_reader(error.as_ref()) => ExitCode::SUCCESS,
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
