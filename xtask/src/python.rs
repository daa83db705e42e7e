//! The Python module: its wheel, installed in a clean environment, its tests, stub, notebook and examples.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::docs::blocks;
use crate::tool::{release_binary, root, run, run_quietly, target_dir};

/// Oldest Python that the module runs on.
const OLDEST: (u32, u32) = (3, 9);

/// Says why not, if Python can't make environments; else its version.
const PROBE: &str = "import sys, venv, ensurepip; print(*sys.version_info[:2])";

/// Where the module is in the tree.
const CRATE: &str = "crates/hapdef-py";

/// Programs that the wheel installs.
const SCRIPTS: &str = "hapdef.data/scripts";

/// The example with a robot, which needs MuJoCo.
const ROBOT: &str = "crates/hapdef-py/examples/robot_touch.py";

/// What the docs say of it.
const PAGE: &str = "docs/python.md";

/// A wheel, and the Python that it was built for.
pub(crate) struct Wheel {
    python: String,
    path: PathBuf,
}

impl Wheel {
    /// The file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

/// `cargo xtask python`.
pub(crate) fn check() -> Result<()> {
    build_wheel()?.as_ref().map_or(Ok(()), |wheel| test_wheel(wheel, true))
}

/// The wheel; without Python, or outside CI without a network, none, and it says so.
pub(crate) fn build_wheel() -> Result<Option<Wheel>> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    if let Err(reason) = usable(&python) {
        println!("wheel skipped: {reason}");
        return Ok(None);
    }
    let folder = target_dir()?.join("python");
    let tools = match tools(&python, &folder.join("tools")) {
        Ok(tools) => tools,
        Err(error) if std::env::var("CI").is_ok_and(|ci| ci == "true") => return Err(error),
        Err(error) => {
            println!("wheel skipped: pip has no maturin here: {error:#}");
            return Ok(None);
        }
    };
    add_program()?;
    let path = build(&tools, &folder)?;
    println!("wheel: {}", path.display());
    Ok(Some(Wheel { python, path }))
}

/// Installs the wheel in a clean environment and runs its tests, stub, notebook and examples; `is_whole` takes the robot
/// in MuJoCo along, two minutes of a core.
pub(crate) fn test_wheel(wheel: &Wheel, is_whole: bool) -> Result<()> {
    let python = environment(&wheel.python, &target_dir()?.join("python/venv"), true)?;
    let path = wheel.path.to_string_lossy();
    install(&python, &[&format!("{path}[notebook,dask]"), "mypy>=1.11"])?;
    println!("installed for {}", python.display());
    let program = release_binary("hapdef")?;
    let ours = |folder: &Path, words: &[&str]| -> Result<()> {
        let mut command = Command::new(&python);
        command.args(words).current_dir(folder);
        command.env("HAPDEF_BIN", &program);
        command.env("PYTHONDONTWRITEBYTECODE", "1");
        run(&mut command)
    };
    let folder = root().join(CRATE);
    ours(&folder, &["-W", "error", "-m", "unittest", "discover", "-s", "tests"])?;
    let installed = python.with_file_name("hapdef");
    run(Command::new(&installed).arg("--version").current_dir(root()))?;
    run_quietly(
        Command::new(&installed).args(["check", "fixtures/shin/placed.json"]).current_dir(root()),
    )?;
    ours(&folder, &["-m", "mypy.stubtest", "hapdef", "--ignore-missing-stub"])?;
    for snippet in snippets()? {
        ours(root(), &["-W", "error", "-c", &snippet])?;
    }
    ours(&folder, &["tests/run_notebook.py", "notebook/first_touch.ipynb"])?;
    ours(&folder, &["examples/scale_out.py", "--check"])?;
    needs_mujoco(&python)?;
    if !is_whole {
        return Ok(());
    }
    match install(&python, &["mujoco"]) {
        Ok(()) => ours(root(), &["-W", "error", ROBOT, "--check"]),
        Err(error) => {
            println!("{ROBOT} skipped: pip has no mujoco here: {error:#}");
            Ok(())
        }
    }
}

/// Without MuJoCo the robot's example says what to install.
fn needs_mujoco(python: &Path) -> Result<()> {
    let mut command = Command::new(python);
    let output = command.arg(ROBOT).current_dir(root()).output().context("running Python")?;
    let text = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(2) && text.contains("pip install mujoco") {
        return Ok(());
    }
    bail!(
        "{ROBOT} without mujoco: expected status 2 and what to install, found {}: {text}",
        output.status
    )
}

/// The Python that the page shows.
fn snippets() -> Result<Vec<String>> {
    let text = fs::read_to_string(root().join(PAGE)).with_context(|| format!("reading {PAGE}"))?;
    let blocks = blocks(&text).into_iter();
    let python = blocks.filter(|block| block.fence.starts_with("python"));
    let found: Vec<String> = python.map(|block| block.lines.join("\n")).collect();
    if found.is_empty() {
        bail!("{PAGE} shows no Python: expected a ```python block");
    }
    Ok(found)
}

/// The version is old enough, and environments can be made.
pub(crate) fn usable(python: &str) -> Result<(), String> {
    let advice = format!("expected Python {}.{} or newer with venv and pip", OLDEST.0, OLDEST.1);
    let output = Command::new(python).args(["-c", PROBE]).output();
    let output = output.map_err(|error| format!("{advice}; {python}: {error}"))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        let last = text.lines().last().unwrap_or_default();
        return Err(format!("{advice}; {python}: {last}"));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    match version(&text) {
        Some(found) if found >= OLDEST => Ok(()),
        _ => Err(format!("{advice}; {python} is {}", text.trim())),
    }
}

fn version(text: &str) -> Option<(u32, u32)> {
    let (major, minor) = text.trim().split_once(' ')?;
    Some((major.parse().ok()?, minor.parse().ok()?))
}

/// A Python with maturin.
fn tools(python: &str, folder: &Path) -> Result<PathBuf> {
    let tools = environment(python, folder, false)?;
    install(&tools, &["maturin>=1.9,<2"])?;
    Ok(tools)
}

/// Puts the program beside the module: maturin takes it along as one that pip installs.
fn add_program() -> Result<()> {
    let program = release_binary("hapdef")?;
    let scripts = root().join(CRATE).join(SCRIPTS);
    fs::create_dir_all(&scripts).with_context(|| format!("making {}", scripts.display()))?;
    fs::copy(program, scripts.join("hapdef")).context("copying the program")?;
    Ok(())
}

/// The wheel, built by maturin.
fn build(tools: &Path, folder: &Path) -> Result<PathBuf> {
    let wheels = folder.join("wheels");
    if wheels.exists() {
        fs::remove_dir_all(&wheels).context("removing old wheels")?;
    }
    let mut command = Command::new(tools);
    command.args(["-m", "maturin", "build", "--release", "--locked", "--out"]);
    command.arg(&wheels).current_dir(root().join(CRATE));
    run(&mut command)?;
    let entries = fs::read_dir(&wheels).context("reading the folder of the wheel")?;
    let paths = entries.map(|entry| Ok(entry?.path()));
    match paths.collect::<Result<Vec<_>>>()?.as_slice() {
        [wheel] => Ok(wheel.clone()),
        others => bail!("expected one wheel in {}, found {}", wheels.display(), others.len()),
    }
}

/// A virtual environment's Python; made anew if it is to be clean.
pub(crate) fn environment(python: &str, folder: &Path, is_clean: bool) -> Result<PathBuf> {
    let own = folder.join("bin/python");
    if is_clean || !own.exists() {
        let mut command = Command::new(python);
        run(command.args(["-m", "venv", "--clear"]).arg(folder))?;
    }
    Ok(own)
}

pub(crate) fn install(python: &Path, packages: &[&str]) -> Result<()> {
    let mut command = Command::new(python);
    command.args(["-m", "pip", "--quiet", "--disable-pip-version-check", "install"]);
    run(command.args(packages))
}

#[cfg(test)]
mod tests {
    use super::{usable, version};

    #[test]
    fn versions_are_compared_as_numbers() {
        assert_eq!(version("3 11\n"), Some((3, 11)));
        assert!(version("3 11\n").unwrap() > super::OLDEST);
        assert!(version("3 8").unwrap() < super::OLDEST);
        assert_eq!(version("three"), None);
    }

    #[test]
    fn a_python_that_is_not_there_is_a_reason() {
        let reason = usable("no-such-python").unwrap_err();
        assert!(reason.contains("3.9") && reason.contains("no-such-python"), "{reason}");
    }
}
