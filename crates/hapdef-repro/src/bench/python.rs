//! A Python that answers line by line.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context, Result, bail};

/// A running Python; it ends when its input does.
pub(super) struct Python {
    child: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
}

impl Python {
    pub(super) fn start(command: &mut Command) -> Result<Self> {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .with_context(|| format!("starting {}", command.get_program().display()))?;
        let to = child.stdin.take();
        let from = BufReader::new(child.stdout.take().context("Python's output")?);
        Ok(Self { child, to, from })
    }

    /// Its answer to a line.
    pub(super) fn ask(&mut self, line: &str) -> Result<String> {
        let to = self.to.as_mut().context("Python's input")?;
        writeln!(to, "{line}").context("asking Python")?;
        self.line()
    }

    /// The next line that it says.
    pub(super) fn line(&mut self) -> Result<String> {
        let mut line = String::new();
        if self.from.read_line(&mut line).context("hearing Python")? == 0 {
            bail!("Python ended: {}", self.child.wait()?);
        }
        Ok(line)
    }
}

impl Drop for Python {
    fn drop(&mut self) {
        self.to = None;
        let _ = self.child.wait();
    }
}
