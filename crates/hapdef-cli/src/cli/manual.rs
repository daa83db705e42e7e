//! `hapdef completions` and `hapdef man`: what a shell and `man` know of the program.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use hapdef_cli::{StandardOutput, shown};
use hapdef_mesh::atomic_write;

use super::Cli;

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    hapdef completions bash\n  \
    hapdef completions zsh\n\n\
    bash reads them from a file ~/.local/share/bash-completion/completions/hapdef, fish from \
    ~/.config/fish/completions/hapdef.fish, zsh from a file _hapdef in a folder of its fpath.")]
pub(crate) struct CompletionsArgs {
    /// The shell that reads them.
    shell: Shell,
}

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    hapdef man -o man\n  \
    hapdef man | man -l -\n\n\
    `man man/hapdef-live.1` shows a page; man finds it by its name in a folder man1 of its MANPATH.")]
pub(crate) struct ManArgs {
    /// Folder for a page of the program and of each command; the program's page goes to standard
    /// output if nothing is named.
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// Prints what the shell reads.
pub(crate) fn completions(args: &CompletionsArgs) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "hapdef", &mut text);
    Ok(StandardOutput.write_all(&text)?)
}

/// Writes the pages, or prints the program's.
pub(crate) fn man(args: &ManArgs) -> Result<()> {
    let pages = pages();
    match &args.out {
        Some(folder) => write(&pages, folder),
        None => Ok(pages[0].render(&mut StandardOutput)?),
    }
}

fn write(pages: &[Man], folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("making {}", shown(folder)))?;
    for page in pages {
        let path = folder.join(page.get_filename());
        atomic_write(&path, |file| page.render(file))
            .with_context(|| format!("writing {}", shown(&path)))?;
    }
    println!("{} pages in {}", pages.len(), shown(folder));
    Ok(())
}

/// The program's page, then one of each command.
fn pages() -> Vec<Man> {
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    let source = format!("hapdef {}", program.get_version().unwrap_or_default());
    let page = |command: &clap::Command| Man::new(command.clone()).source(&source).manual("hapdef");
    std::iter::once(&program).chain(program.get_subcommands()).map(page).collect()
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;

    fn text(page: &Man) -> String {
        let mut text = Vec::new();
        page.render(&mut text).unwrap();
        String::from_utf8(text).unwrap()
    }

    /// As they are typed, and as roff has them.
    fn options(command: &clap::Command) -> Vec<String> {
        let long = command.get_arguments().filter(|arg| !arg.is_hide_set());
        let long = long.filter_map(clap::Arg::get_long);
        long.map(|name| format!("--{name}").replace('-', "\\-")).collect()
    }

    #[test]
    fn completions_name_every_command_and_its_options() {
        for &shell in Shell::value_variants() {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "hapdef", &mut script);
            let script = String::from_utf8(script).unwrap();
            for command in Cli::command().get_subcommands() {
                let name = command.get_name();
                let words = script.split(|c: char| !(c.is_alphanumeric() || c == '-' || c == '_'));
                assert!(words.into_iter().any(|word| word == name), "{shell}: {name}");
                for option in command.get_arguments().filter_map(clap::Arg::get_long) {
                    assert!(script.contains(option), "{shell}: {name} --{option}");
                }
            }
        }
    }

    #[test]
    fn a_page_has_a_name_and_every_option() {
        let mut program = Cli::command().disable_help_subcommand(true);
        program.build();
        let commands: Vec<_> = std::iter::once(&program).chain(program.get_subcommands()).collect();
        let pages = pages();
        assert_eq!(pages.len(), commands.len());
        for (page, command) in pages.iter().zip(commands) {
            let (text, name) = (text(page), command.get_name());
            let full = if name == "hapdef" { name.into() } else { format!("hapdef-{name}") };
            assert_eq!(page.get_filename(), format!("{full}.1"));
            let about = command.get_about().unwrap().to_string();
            let first = about.split_whitespace().next().unwrap();
            let begin = format!("\n.SH NAME\n{} \\- {first}", full.replace('-', "\\-"));
            assert!(text.contains(&begin), "{begin}: {text}");
            let options = options(command);
            assert!(options.contains(&"\\-\\-help".to_owned()), "{full}: {options:?}");
            for option in options {
                assert!(text.contains(&option), "{full}: {option}");
            }
        }
    }
}
