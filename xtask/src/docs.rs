//! The commands that the docs show, run as a reader would.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::tool::{root, run};

/// Commands that are not run here, and why.
const LEFT_OUT: [(&str, &str); 2] = [
    ("cargo xtask ci", "this is what is running"),
    ("cargo xtask demo --quick", "run by its own step"),
];

/// Words that begin a command.
const PROGRAMS: [&str; 8] = [
    "cargo ",
    "hapdef ",
    "python ",
    "python3 ",
    "pip ",
    "maturin ",
    "target/",
    "import hapdef",
];

/// Arguments of `docs`.
#[derive(clap::Args)]
pub(crate) struct DocsArgs {
    /// These pages only.
    pages: Vec<PathBuf>,
}

/// `cargo xtask docs`.
pub(crate) fn run_some(args: &DocsArgs) -> Result<()> {
    match args.pages.as_slice() {
        [] => run_commands(),
        pages => run_of(pages),
    }
}

/// Runs every line of every `sh` block in README.md and docs/.
pub(crate) fn run_commands() -> Result<()> {
    let mut files = vec![root().join("README.md")];
    let folder = fs::read_dir(root().join("docs")).context("reading docs/")?;
    for entry in folder {
        files.push(entry.context("reading docs/")?.path());
    }
    files.retain(|file| file.extension().is_some_and(|e| e == "md"));
    files.sort();
    run_of(&files)
}

fn run_of(files: &[PathBuf]) -> Result<()> {
    let mut n_run = 0;
    for file in files {
        let text = fs::read_to_string(file).with_context(|| file.display().to_string())?;
        for line in commands(&text) {
            if LEFT_OUT.iter().any(|(command, _)| *command == line) {
                continue;
            }
            eprintln!("   $ {line}");
            run(Command::new("sh").args(["-c", line]).current_dir(root()))
                .with_context(|| format!("{}: {line}", file.display()))?;
            n_run += 1;
        }
    }
    if n_run == 0 {
        bail!("the docs show no command: expected ```sh blocks in README.md and docs/");
    }
    Ok(())
}

/// Lines of the fenced `sh` blocks.
fn commands(text: &str) -> Vec<&str> {
    let mut inside = false;
    let mut found = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with("```") {
            inside = line == "```sh";
        } else if inside && !line.is_empty() && !line.starts_with('#') {
            found.push(line);
        }
    }
    found
}

/// Commands in blocks that are neither run, ```sh, nor say why not, ```sh (a device).
pub(crate) fn unexplained(text: &str) -> Vec<&str> {
    let mut fence = None;
    let mut found = Vec::new();
    for line in text.lines().map(str::trim) {
        match (line.strip_prefix("```"), fence) {
            (Some(words), None) => fence = Some(words),
            (Some(_), Some(_)) => fence = None,
            (None, Some(words)) => {
                let is_command = PROGRAMS.iter().any(|program| line.starts_with(program));
                if is_command && words != "sh" && !gives_reason(words) {
                    found.push(line);
                }
            }
            (None, None) => {}
        }
    }
    found
}

/// `language (reason)`.
fn gives_reason(fence: &str) -> bool {
    let reason = fence
        .split_once(" (")
        .and_then(|(_, rest)| rest.strip_suffix(')'));
    reason.is_some_and(|reason| !reason.trim().is_empty())
}

#[cfg(test)]
mod tests {
    use super::{commands, unexplained};

    #[test]
    fn a_command_is_run_or_says_why_not() {
        let text = "```sh\ncargo a\n```\n```sh (a device)\nhapdef b\n```\n```text\nhapdef c\nwords\n\
                    ```\n```sh ()\npip d\n```\n```rust\nlet cargo = 1;\n```\ncargo e\n";
        assert_eq!(unexplained(text), ["hapdef c", "pip d"]);
        assert_eq!(commands(text), ["cargo a"]);
    }

    #[test]
    fn only_sh_blocks_count() {
        let text = "```sh\na b\n\n# note\nc\n```\nd\n```text\ne\n```\n";
        assert_eq!(commands(text), ["a b", "c"]);
    }
}
