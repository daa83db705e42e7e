//! A folder to give away: the program, the wheel, completions, manual, docs, checksums.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::python;
use crate::tool::{metadata, release_binary, root, run, run_quietly, shown, target_dir};

/// Shared libraries that every Linux with the GNU C library has; the program may need no other.
const EVERYWHERE: [&str; 6] =
    ["linux-vdso", "ld-linux", "libc.so", "libm.so", "libgcc_s.so", "libpthread.so"];

/// What goes along from the tree: docs link to all of it by the same paths.
const FROM_TREE: [&str; 5] = ["docs", "README.md", "LICENSE", "CHANGELOG.md", "ARCHITECTURE.md"];

/// Shells and the names that they find their completions by.
const SHELLS: [(&str, &str); 3] = [("bash", "hapdef"), ("zsh", "_hapdef"), ("fish", "hapdef.fish")];

/// `cargo xtask dist`.
pub(crate) fn make() -> Result<()> {
    let program = release_binary("hapdef")?;
    let libc = needed_libc(&program)?;
    let name = format!("hapdef-{}-{}", version()?, std::env::consts::ARCH);
    let dist = target_dir()?.join("dist");
    let folder = dist.join(&name);
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
    }
    let bin = made(&folder.join("bin"))?;
    fs::copy(&program, bin.join("hapdef")).context("copying the program")?;
    let program = bin.join("hapdef");
    let completions = made(&folder.join("completions"))?;
    for (shell, file) in SHELLS {
        fs::write(
            completions.join(file),
            output(Command::new(&program).args(["completions", shell]))?,
        )?;
    }
    let manual = folder.join("man/man1");
    run_quietly(Command::new(&program).arg("man").arg("-o").arg(&manual))?;
    for file in FROM_TREE {
        run_quietly(Command::new("cp").arg("-r").arg(root().join(file)).arg(folder.join(file)))?;
    }
    match python::build_wheel()? {
        Some(wheel) => {
            let wheels = made(&folder.join("wheel"))?;
            let file = wheel.path().file_name().context("the wheel has no name")?;
            fs::copy(wheel.path(), wheels.join(file)).context("copying the wheel")?;
        }
        None => println!("the folder has no wheel"),
    }
    sum(&folder)?;
    let archive = dist.join(format!("{name}.tar.gz"));
    let mut tar = Command::new("tar");
    run_quietly(tar.arg("-C").arg(&dist).arg("-czf").arg(&archive).arg(&name))?;
    println!(
        "needs glibc {libc} or newer, no other library\n{}\n{}",
        folder.display(),
        archive.display()
    );
    Ok(())
}

/// Runs what the folder has, as somebody would who was given it.
pub(crate) fn check() -> Result<()> {
    make()?;
    let dist = target_dir()?.join("dist");
    let archive = dist.join(format!("hapdef-{}-{}.tar.gz", version()?, std::env::consts::ARCH));
    let unpacked = dist.join("unpacked");
    if unpacked.exists() {
        fs::remove_dir_all(&unpacked)?;
    }
    let unpacked = made(&unpacked)?;
    run_quietly(Command::new("tar").arg("-C").arg(&unpacked).arg("-xzf").arg(&archive))?;
    let folder = unpacked.join(archive_name(&archive)?);
    run_quietly(
        Command::new("sha256sum").args(["--quiet", "-c", "SHA256SUMS"]).current_dir(&folder),
    )?;
    run(Command::new(folder.join("bin/hapdef")).arg("--version"))?;
    for file in ["completions/_hapdef", "man/man1/hapdef-live.1", "docs/README.md"] {
        let path = folder.join(file);
        ensure!(path.metadata().is_ok_and(|m| m.len() > 0), "{} is not there", path.display());
    }
    Ok(())
}

fn archive_name(archive: &Path) -> Result<String> {
    let name = archive.file_name().and_then(|name| name.to_str()).context("an archive's name")?;
    Ok(name.trim_end_matches(".tar.gz").to_owned())
}

fn made(folder: &Path) -> Result<PathBuf> {
    fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    Ok(folder.to_owned())
}

/// Version of the program.
fn version() -> Result<String> {
    let metadata = metadata()?;
    let packages = metadata["packages"].as_array().context("cargo metadata: packages")?;
    let program = packages.iter().find(|package| package["name"] == "hapdef-cli");
    let version = program.and_then(|package| package["version"].as_str());
    Ok(version.context("cargo metadata: the version of hapdef-cli")?.to_owned())
}

/// SHA-256 of every file, by its path in the folder, sorted.
fn sum(folder: &Path) -> Result<()> {
    let script =
        "find . -type f ! -name SHA256SUMS | LC_ALL=C sort | xargs -d '\\n' sha256sum > SHA256SUMS";
    run_quietly(Command::new("sh").args(["-c", script]).current_dir(folder))
}

/// The newest version of the C library that `program` needs; fails for a library that not every system has.
fn needed_libc(program: &Path) -> Result<String> {
    let needed = String::from_utf8(output(Command::new("ldd").arg(program))?)?;
    for line in needed.lines() {
        let library = line.trim().rsplit('/').next().unwrap_or_default();
        let first = line.split_whitespace().next().unwrap_or_default();
        let is_there =
            EVERYWHERE.iter().any(|name| library.starts_with(name) || first.starts_with(name));
        ensure!(
            is_there,
            "{} needs a library that not every system has: {line}",
            program.display()
        );
    }
    let bytes = fs::read(program).with_context(|| format!("reading {}", program.display()))?;
    newest_libc(&bytes).context("the program names no version of the C library")
}

/// The largest `GLIBC_2.…` in a program's symbol versions.
fn newest_libc(bytes: &[u8]) -> Option<String> {
    const WORD: &[u8] = b"GLIBC_";
    let starts = bytes.windows(WORD.len()).enumerate().filter(|(_, window)| *window == WORD);
    let versions = starts.filter_map(|(at, _)| {
        let rest = &bytes[at + WORD.len()..];
        let len = rest.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
        let text = std::str::from_utf8(&rest[..len]).ok()?;
        let numbers: Option<Vec<u32>> = text.split('.').map(|number| number.parse().ok()).collect();
        Some((numbers?, text.to_owned()))
    });
    versions.max().map(|(_, text)| text)
}

fn output(command: &mut Command) -> Result<Vec<u8>> {
    let output = command.output().with_context(|| format!("starting {}", shown(command)))?;
    if !output.status.success() {
        bail!("{} ended with {}", shown(command), output.status);
    }
    Ok(output.stdout)
}

#[cfg(test)]
mod tests {
    use super::newest_libc;

    #[test]
    fn versions_are_compared_as_numbers() {
        let bytes = b"\0GLIBC_2.9\0GLIBC_2.34\0GLIBC_PRIVATE\0GLIBC_2.4\0";
        assert_eq!(newest_libc(bytes).as_deref(), Some("2.34"));
        assert_eq!(newest_libc(b"static"), None);
    }
}
