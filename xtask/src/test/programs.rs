//! The programs of tests, and how they are run beside each other.

use std::collections::VecDeque;
use std::fmt;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::thread;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::tool::{cargo, shown};

/// Packages whose integration tests take longest: begun last, one core would wait for them. hapdef-view's, with their
/// browsers, come when nothing is built beside them any more.
const LONGEST: [&str; 5] =
    ["hapdef", "hapdef-cli", "hapdef-view", "hapdef-repro", "hapdef-inverse"];

/// A program of tests.
pub(super) struct Program {
    /// Its package's folder, where Cargo runs it, too.
    folder: PathBuf,
    path: PathBuf,
    /// The package's one program of integration tests, no unit tests.
    pub(super) is_integration: bool,
}

impl Program {
    /// What starts it, as `cargo test` would.
    pub(super) fn command(&self) -> Command {
        let mut command = Command::new(&self.path);
        command.current_dir(&self.folder).env("CARGO_MANIFEST_DIR", &self.folder);
        command
    }

    fn package(&self) -> &str {
        self.folder.file_name().and_then(|name| name.to_str()).unwrap_or_default()
    }

    fn rank(&self) -> usize {
        let place = LONGEST.iter().position(|name| *name == self.package());
        place.filter(|_| self.is_integration).unwrap_or(LONGEST.len())
    }
}

impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.is_integration { "integration" } else { "unit" };
        write!(f, "{kind} tests of {}", self.package())
    }
}

/// Builds all of them; no example is linked that no test starts. The longest come first.
pub(super) fn build() -> Result<Vec<Program>> {
    let mut command = cargo(&["test", "--release", "--no-run", "--lib", "--bins", "--test", "it"]);
    command.args(["--message-format", "json-render-diagnostics"]).stdout(Stdio::piped());
    let mut child = command.spawn().with_context(|| format!("starting {}", shown(&command)))?;
    let mut programs = Vec::new();
    for line in BufReader::new(child.stdout.take().context("cargo's output")?).lines() {
        let message = serde_json::from_str(&line?).context("a message of cargo")?;
        programs.extend(program(&message));
    }
    let status = child.wait()?;
    if !status.success() {
        bail!("{} ended with {status}", shown(&command));
    }
    programs.sort_by_key(Program::rank);
    Ok(programs)
}

/// The program of tests that a message of Cargo's is about.
fn program(message: &Value) -> Option<Program> {
    if message["profile"]["test"] != true {
        return None;
    }
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?.to_owned();
    let path = message["executable"].as_str()?.into();
    Some(Program { folder, path, is_integration: message["target"]["kind"][0] == "test" })
}

/// Runs commands, given with their names, to their ends, the first ones first, so many at a time. What one printed
/// comes in one piece. Fails after the last if any failed.
pub(super) fn run(commands: Vec<(String, Command)>, n_at_a_time: usize) -> Result<()> {
    let waiting = Mutex::new(VecDeque::from(commands));
    let failed = Mutex::new(Vec::new());
    let next = || waiting.lock().ok()?.pop_front();
    thread::scope(|scope| {
        for _ in 0..n_at_a_time {
            scope.spawn(|| {
                while let Some((name, mut command)) = next() {
                    if let Err(error) = run_in_one_piece(&name, &mut command)
                        && let Ok(mut failed) = failed.lock()
                    {
                        failed.push(format!("{name}: {error:#}"));
                    }
                }
            });
        }
    });
    let failed = failed.into_inner().unwrap_or_default();
    if !failed.is_empty() {
        bail!("{}", failed.join("; "));
    }
    Ok(())
}

fn run_in_one_piece(name: &str, command: &mut Command) -> Result<()> {
    let start = Instant::now();
    let output = command.output().with_context(|| format!("starting {}", shown(command)))?;
    let mut stdout = std::io::stdout().lock();
    writeln!(stdout, "{name}: {:.0} s", start.elapsed().as_secs_f64())?;
    stdout.write_all(&output.stdout)?;
    stdout.write_all(&output.stderr)?;
    if !output.status.success() {
        bail!("ended with {}", output.status);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::{Command, program, run};

    #[test]
    fn of_all_artifacts_only_programs_of_tests_are_taken() {
        let artifact = |kind: &str, is_test: bool, executable: Option<&str>| {
            json!({
                "reason": "compiler-artifact",
                "manifest_path": "/limb/crates/hapdef/Cargo.toml",
                "target": { "kind": [kind], "name": "it" },
                "profile": { "test": is_test },
                "executable": executable,
            })
        };
        let found = program(&artifact("test", true, Some("/limb/it"))).unwrap();
        assert_eq!(found.to_string(), "integration tests of hapdef");
        assert_eq!(found.rank(), 0);
        let found = program(&artifact("lib", true, Some("/limb/hapdef"))).unwrap();
        assert_eq!(found.to_string(), "unit tests of hapdef");
        assert!(program(&artifact("bin", false, Some("/limb/hapdef"))).is_none());
        assert!(program(&artifact("lib", true, None)).is_none());
        assert!(program(&json!({ "reason": "build-finished", "success": true })).is_none());
    }

    #[test]
    fn all_run_and_each_that_failed_is_named() {
        let ended = |name: &str, status: u8| {
            let mut command = Command::new("sh");
            command.args(["-c", &format!("exit {status}")]);
            (name.to_owned(), command)
        };
        let commands = vec![ended("a", 1), ended("b", 0), ended("c", 0), ended("d", 2)];
        let error = run(commands, 2).unwrap_err().to_string();
        assert!(error.contains("a: ended") && error.contains("d: ended"), "{error}");
        assert!(!error.contains("b: ") && !error.contains("c: "), "{error}");
    }
}
