//! Starting other programs.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::time::SystemTime;

use anyhow::{Context, Result, bail};

/// A program that is ended when this is dropped.
pub(crate) struct Running(pub(crate) Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Root of the workspace.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// `cargo` with arguments, in the workspace root.
pub(crate) fn cargo(args: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(args).current_dir(root());
    command
}

/// Runs a command to its end and fails when it fails.
pub(crate) fn run(command: &mut Command) -> Result<()> {
    let status = status(command)?;
    if !status.success() {
        bail!("{} ended with {status}", shown(command));
    }
    Ok(())
}

/// Runs a command to its end and fails, with all that it said, when it fails.
pub(crate) fn run_quietly(command: &mut Command) -> Result<()> {
    let output = command.output().with_context(|| format!("starting {}", shown(command)))?;
    if !output.status.success() {
        let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
        bail!("{} ended with {}:\n{out}{err}", shown(command), output.status);
    }
    Ok(())
}

/// Runs a command to its end; what it writes goes to [`results`] if nothing else is said.
pub(crate) fn status(command: &mut Command) -> Result<ExitStatus> {
    let is_cargo = Path::new(command.get_program()).file_stem() == Some("cargo".as_ref());
    let command = if is_cargo { command } else { into_results(command) };
    command.status().with_context(|| format!("starting {}", shown(command)))
}

/// Builds a program and returns its path. No package is named: that would build the crates below it
/// once more, with the features of that package alone.
pub(crate) fn release_binary(name: &str) -> Result<PathBuf> {
    let words = ["build", "--quiet", "--release", "--bin", name];
    run(&mut cargo(&words))?;
    Ok(target_dir()?.join("release").join(name))
}

/// Builds an example, as [`release_binary`] does, and returns its path.
pub(crate) fn release_example(name: &str) -> Result<PathBuf> {
    let words = ["build", "--quiet", "--release", "--example", name];
    run(&mut cargo(&words))?;
    Ok(target_dir()?.join("release/examples").join(name))
}

/// Has a program write a file of the workspace, or fail where the file says something else.
pub(crate) fn add_document(command: &mut Command, file: &str, write: bool, check: bool) {
    for (flag, on) in [("--write", write), ("--check", check)] {
        if on {
            command.arg(flag).arg(root().join(file));
        }
    }
}

/// Where hapdef's programs leave results and metrics, wherever cargo's target folder is and whatever the
/// working directory: `HAPDEF_OUT`, or `target/hapdef` in the workspace.
pub(crate) fn results() -> PathBuf {
    let own = || root().join("target/hapdef");
    std::env::var_os("HAPDEF_OUT").map_or_else(own, PathBuf::from)
}

/// Tells a program of [`results`].
pub(crate) fn into_results(command: &mut Command) -> &mut Command {
    command.env("HAPDEF_OUT", results());
    if std::env::var_os("HAPDEF_METRICS").is_none() {
        command.env("HAPDEF_METRICS", results().join("metrics.json"));
    }
    command
}

/// Cargo's target folder.
pub(crate) fn target_dir() -> Result<PathBuf> {
    let metadata = metadata()?;
    let dir = metadata["target_directory"].as_str().context("cargo metadata: target_directory")?;
    Ok(PathBuf::from(dir))
}

/// `cargo metadata` of the workspace's own packages.
pub(crate) fn metadata() -> Result<serde_json::Value> {
    let output = cargo(&["metadata", "--no-deps", "--format-version", "1"])
        .output()
        .context("starting cargo metadata")?;
    serde_json::from_slice(&output.stdout).context("reading cargo metadata")
}

/// Days since 1970: the seed of what is drawn anew every night.
pub(crate) fn day() -> u64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0, |since| since.as_secs() / 86_400)
}

/// The command line as a person would type it.
pub(crate) fn shown(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
