//! Every unit, integration and documentation test, once.

mod programs;

use std::path::PathBuf;
use std::process::Command;
use std::thread;
use std::time::Instant;

use anyhow::{Result, bail};

use crate::tool::{cargo, results, target_dir};
use crate::{browser, metrics, python};
use programs::Program;

/// Modules of the crates' integration tests that claim how soon something happens, how much arrives in
/// time or how much memory the process takes: they run one after the other, with nothing beside them.
const TIMED: [&str; 16] = [
    "feed::",
    "live_browser::",
    "live_ports::",
    "live_robot::",
    "person::",
    "player::",
    "realtime::",
    "receivers::",
    "record_survival::",
    "runtime::",
    "serial_pty::",
    "sinks::",
    "sources::",
    "stalled_client::",
    "tokio_ports::",
    "wire::",
];

/// Property tests draw the same cases in every run, unless `PROPTEST_RNG_SEED` says otherwise.
const PROPTEST_SEED: &str = "20190715";

/// Cases of each property that names no number of its own, in a long run.
const PROPTEST_CASES: &str = "2048";

/// Packages of Python that read recordings.
const READERS: [&str; 4] = ["mcap", "mcap-ros2-support", "rosbags", "rerun-sdk"];

/// The tests, built, and what they find on this machine.
pub(crate) struct Tests {
    programs: Vec<Program>,
    /// What `HAPDEF_BROWSER` says.
    browser: &'static str,
    /// A Python that has [`READERS`].
    python: Option<PathBuf>,
    /// More kills, packets and cases, longer stalls.
    is_long: bool,
}

/// `cargo xtask test`.
pub(crate) fn run_all() -> Result<()> {
    let start = Instant::now();
    let tests = Tests::build(false)?;
    let passes = [tests.untimed(), tests.timed()];
    let wall_s = start.elapsed().as_secs_f64();
    metrics::report(&[("test.wall_s", wall_s, "s")], 0, Some(&results().join("metrics.json")));
    let failed: Vec<String> =
        passes.into_iter().filter_map(Result::err).map(|error| format!("{error:#}")).collect();
    if !failed.is_empty() {
        bail!("tests failed:\n  {}", failed.join("\n  "));
    }
    Ok(())
}

impl Tests {
    /// Builds all tests; meanwhile gets a browser and the readers of recordings where that is possible.
    pub(crate) fn build(is_long: bool) -> Result<Self> {
        thread::scope(|scope| {
            let found = scope.spawn(|| Ok((browser::wish()?, readers()?)));
            let built = programs::build();
            let found = found.join().unwrap_or_else(|_| bail!("panicked"));
            let programs = built?;
            let (browser, python) = found?;
            Ok(Self { programs, browser, python, is_long })
        })
    }

    /// Everything that claims no time: integration tests, unit tests and the examples of the documentation. Two
    /// programs at a time, since few fill both cores.
    pub(crate) fn untimed(&self) -> Result<()> {
        let skips: Vec<&str> = TIMED.iter().flat_map(|module| ["--skip", *module]).collect();
        let words = |program: &Program| if program.is_integration { &skips[..] } else { &[] };
        let mut commands: Vec<_> =
            self.programs.iter().map(|program| self.named(program, words(program))).collect();
        let examples = self.with_environment(cargo(&["test", "--release", "--doc"]));
        commands.push(("examples of the documentation".to_owned(), examples));
        programs::run(commands, 2)
    }

    /// The integration tests that want the machine for themselves.
    pub(crate) fn timed(&self) -> Result<()> {
        let words = [&TIMED[..], &["--test-threads", "1"]].concat();
        let programs = self.programs.iter().filter(|program| program.is_integration);
        programs::run(programs.map(|program| self.named(program, &words)).collect(), 1)
    }

    fn named(&self, program: &Program, words: &[&str]) -> (String, Command) {
        let mut command = program.command();
        command.args(words);
        (program.to_string(), self.with_environment(command))
    }

    /// Says in a command's environment what the tests find and how long they take.
    fn with_environment(&self, mut command: Command) -> Command {
        if std::env::var_os("PROPTEST_RNG_SEED").is_none() && !self.is_long {
            command.env("PROPTEST_RNG_SEED", PROPTEST_SEED);
        }
        if self.is_long {
            command.env("HAPDEF_SOAK", "1").env("PROPTEST_CASES", PROPTEST_CASES);
        }
        if let Some(python) = &self.python {
            command.env("HAPDEF_PYTHON", python);
        }
        command.env("HAPDEF_BROWSER", self.browser);
        command
    }
}

/// A Python with the readers; without Python, or outside CI without a network, it says so.
fn readers() -> Result<Option<PathBuf>> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    if let Err(reason) = python::usable(&python) {
        println!("readers of recordings skipped: {reason}");
        return Ok(None);
    }
    let python = python::environment(&python, &target_dir()?.join("python/readers"), false)?;
    match python::install(&python, &READERS) {
        Ok(()) => Ok(Some(python)),
        Err(error) if std::env::var("CI").is_ok_and(|ci| ci == "true") => Err(error),
        Err(error) => {
            println!("readers of recordings skipped: pip has none here: {error:#}");
            Ok(None)
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::TIMED;
    use crate::tool::root;

    #[test]
    fn every_timed_module_is_there() {
        let crates = fs::read_dir(root().join("crates")).unwrap();
        let mains = crates.map(|entry| entry.unwrap().path().join("tests/it/main.rs"));
        let text: String = mains.filter_map(|main| fs::read_to_string(main).ok()).collect();
        for module in TIMED {
            let line = format!("mod {};", module.trim_end_matches("::"));
            assert!(text.lines().any(|found| found == line), "no crate's tests have {line}");
        }
    }
}
