//! The firmware compiled for the host, by the host's compiler.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A compiler, and the flags of its language.
pub struct Compiler {
    name: &'static str,
    flags: [&'static str; 3],
}

const C: Compiler = Compiler { name: "cc", flags: ["-std=c99", "-x", "c"] };
pub const CPP: Compiler = Compiler { name: "c++", flags: ["-std=c++11", "-x", "c++"] };

/// Where the headers are, below the firmware's folder.
const HEADERS: [&str; 4] = [".", "host/due", "host/pico", "hapdef_pico"];

/// A program made of files of the firmware; it stays in cargo's folder for tests.
pub struct Program {
    path: PathBuf,
}

/// What a program said.
pub struct Said {
    pub stdout: Vec<u8>,
    pub stderr: String,
    pub code: Option<i32>,
}

impl Program {
    /// Compiles files of C to a program of that name; `None`, and a line that says so, without a compiler.
    pub fn of(name: &str, files: &[&str]) -> Option<Self> {
        Self::linked(&C, name, files)
    }

    /// Compiles files of C and C++ and links them by that compiler.
    pub fn linked(linker: &Compiler, name: &str, files: &[&str]) -> Option<Self> {
        let programs = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let folder = tempfile::tempdir_in(programs).unwrap();
        let mut command = Command::new(linker.name);
        for file in files {
            command.arg(object(file, folder.path())?);
        }
        let linked = folder.path().join("program");
        command.arg("-lm").arg("-o").arg(&linked);
        compile(command)?;
        // A program that runs in another process goes on.
        let path = programs.join(name);
        fs::rename(&linked, &path).unwrap();
        Some(Self { path })
    }

    /// Runs it to its end, which has to be a good one; `input` is what it can read.
    pub fn run(&self, arguments: &[&str], variables: &[(&str, &str)], input: &[u8]) -> Said {
        let said = self.try_run(arguments, variables, input);
        assert_eq!(said.code, Some(0), "{}", last_lines(&said.stderr));
        said
    }

    pub fn try_run(&self, arguments: &[&str], variables: &[(&str, &str)], input: &[u8]) -> Said {
        let mut command = Command::new(&self.path);
        command.args(arguments).envs(variables.iter().copied());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        // A program that ends early reads no more; its code tells.
        child.stdin.take().unwrap().write_all(input).ok();
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        Said { stdout: output.stdout, stderr, code: output.status.code() }
    }
}

/// Compiles a file of the firmware.
fn object(file: &str, folder: &Path) -> Option<PathBuf> {
    let firmware = Path::new(env!("CARGO_MANIFEST_DIR")).join("firmware");
    let compiler = if file.ends_with(".cpp") { &CPP } else { &C };
    let to = folder.join(file.replace('/', "_")).with_extension("o");
    let mut command = Command::new(compiler.name);
    command.args(["-c", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O2"]);
    for folder in HEADERS {
        command.arg("-I").arg(firmware.join(folder));
    }
    command.args(compiler.flags).arg(firmware.join(file)).arg("-o").arg(&to);
    compile(command).map(|()| to)
}

fn compile(mut command: Command) -> Option<()> {
    let Ok(compiled) = command.output() else {
        println!("skipped: there is no {}", command.get_program().display());
        return None;
    };
    let words = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{words}");
    Some(())
}

fn last_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(5)..].join("\n")
}
