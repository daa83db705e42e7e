//! The first minute: `demo --live` where nothing was solved yet, until its page has drawn a contact.

use std::io::{BufRead, BufReader};
use std::process::{ChildStdout, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use anyhow::{Context, Result, ensure};

use crate::browser;
use crate::pipeline::live_command;
use crate::tool::{Running, into_results, release_example, shown, target_dir};

/// The figure, and what it may be at most, s.
const FIGURE: &str = "METRIC:view.first_picture_s:";
const MOST_S: f64 = 60.0;
/// Longest wait for a figure that is beyond that.
const PATIENCE: Duration = Duration::from_secs(240);

/// A step of CI: prints the figure and fails where it is too large; without a Chromium it says so.
pub(crate) fn check() -> Result<()> {
    if browser::wish()? == "skip" {
        println!("{FIGURE}skipped:no Chromium");
        return Ok(());
    }
    let out = target_dir()?.join("first-minute");
    if out.exists() {
        std::fs::remove_dir_all(&out).with_context(|| out.display().to_string())?;
    }
    let opener = release_example("view_shot")?;
    let mut command = live_command(None, None, Some(opener))?;
    command.args(["--view-port", "0", "--results"]).arg(&out);
    into_results(&mut command).stdout(Stdio::piped());
    let child = command.spawn();
    let mut program = Running(child.with_context(|| format!("starting {}", shown(&command)))?);
    let figures = figures(program.0.stdout.take().context("its output")?);
    let line = figures.recv_timeout(PATIENCE);
    // Its page, which sees that, ends the browser.
    drop(program);
    std::fs::remove_dir_all(&out).with_context(|| out.display().to_string())?;
    let line = line.with_context(|| format!("no {FIGURE} of {}", shown(&command)))?;
    println!("{line}");
    let value = line[FIGURE.len()..].split(':').next().unwrap_or_default();
    let first_s: f64 = value.parse().with_context(|| line.clone())?;
    ensure!(first_s <= MOST_S, "the first picture took {first_s} s, expected {MOST_S} s at most");
    Ok(())
}

/// The figure's line as soon as it comes; a thread reads everything else.
fn figures(stdout: ChildStdout) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let lines = BufReader::new(stdout).lines().map_while(Result::ok);
        for line in lines.filter(|line| line.starts_with(FIGURE)) {
            let _ = sender.send(line);
        }
    });
    receiver
}
