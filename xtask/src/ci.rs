//! What CI runs: what compiles beside what does not fill both cores, what claims a time alone.

use std::process::Command;
use std::sync::{Mutex, mpsc};
use std::thread;
use std::time::Instant;

use crate::book::BookArgs;
use crate::test::Tests;
use crate::tool::{cargo, metadata, results, root, run, run_quietly, shown};
use crate::{
    book, docs, first_minute, fixtures, frontier, fuzz, metrics, package, python, repro,
    robustness, soak, tidy, verify, wasm, weight,
};
use anyhow::{Context, Result, bail};

/// Features that the programs are built without, which clippy and the docs cover, too.
const LEFT_OUT: [&str; 3] = ["candle", "foxglove", "zenoh"];

/// Packages whose tests need them, and what is in the names of those tests.
const NEED_LEFT_OUT: [(&str, &str); 3] =
    [("hapdef-nets", "candle"), ("hapdef-ros", "foxglove"), ("hapdef-ros", "zenoh")];

/// Crates that are not checked alone: nothing stands on xtask, the wheel is hapdef-py alone, and
/// workspace-hack is a manifest.
const NOT_ALONE: [&str; 3] = ["xtask", "hapdef-py", "workspace-hack"];

/// Arguments of `ci`.
#[derive(clap::Args)]
pub(crate) struct CiArgs {
    /// The slow sweeps, too: hours of damage and of scenes at random, new cases of every property.
    #[arg(long)]
    nightly: bool,
}

/// `cargo xtask ci`: prints how long every step took, also when one has failed.
pub(crate) fn run_everything(args: &CiArgs) -> Result<()> {
    let start = Instant::now();
    let steps = Steps::default();
    let result = run_all(&steps, args.nightly);
    steps.print();
    let wall_s = start.elapsed().as_secs_f64();
    metrics::report(&[("ci.wall_s", wall_s, "s")], 0, Some(&results().join("metrics.json")));
    result
}

/// Runs every check; stops at the first that fails.
fn run_all(steps: &Steps, is_nightly: bool) -> Result<()> {
    steps.run("format", || run(&mut cargo(&["fmt", "--all", "--check"])))?;
    steps.run("tidy", tidy::run)?;
    steps.run("weight", weight::check_table)?;
    steps.run("packages", package::check)?;
    let (tests, wheel) = beside(
        || {
            let tests = steps.run("build of the tests", || Tests::build(is_nightly))?;
            steps.run("tests", || tests.untimed())?;
            Ok(tests)
        },
        || {
            steps.run("clippy", clippy)?;
            steps.run("docs", rustdoc)?;
            let build = || run_quietly(&mut tests_of_features(&["--no-run"]));
            steps.run("build with optional features", build)?;
            // It waits for Cargo until the tests are built.
            steps.run("build of the wheel", python::build_wheel)
        },
    )?;
    steps.run("tests that claim a time", || tests.timed())?;
    steps.run("soak --short", || soak::of_ci(true))?;
    steps.run("demo --live", first_minute::check)?;
    let commands = &docs::Commands::of_docs()?;
    let (tables_ended, wait) = mpsc::channel::<()>();
    let with_features = || run(&mut tests_of_features(&[&["--"], &LEFT_OUT[..]].concat()));
    beside(
        || {
            // Some pages show what is made of the tables' stages: dropped, ended well or not, it lets them go.
            let ended = tables_ended;
            steps.run("repro --quick", quick_tables)?;
            drop(ended);
            steps.run("commands of the docs", || commands.run())
        },
        move || {
            steps.run("tests of optional features", with_features)?;
            steps.run("trust --short", || soak::trust_of_ci(true))?;
            steps.run("verification table", verify::check)?;
            steps.run("robustness tables", robustness::check)?;
            steps.run("limits page", frontier::check)?;
            steps.run("fixtures", || fixtures::make(true))?;
            steps.run("book", || book::make(&BookArgs::default()))?;
            steps.run("page in the browser", wasm::check)?;
            steps.run("tests of the wheel", || {
                wheel.as_ref().map_or(Ok(()), |wheel| python::test_wheel(wheel, is_nightly))
            })?;
            let _ = wait.recv();
            steps.run("more commands of the docs", || commands.run())
        },
    )?;
    if is_nightly {
        steps.run("each crate alone", crates_alone)?;
        steps.run("soak", || soak::of_ci(false))?;
        steps.run("trust", || soak::trust_of_ci(false))?;
        steps.run("fuzz", fuzz::nightly)?;
        steps.run("scenes at random", robustness::nightly)?;
    }
    Ok(())
}

/// Two series of steps at a time that need nothing of each other: hardly a step fills both cores alone.
fn beside<T, U: Send>(
    first: impl FnOnce() -> Result<T>,
    second: impl FnOnce() -> Result<U> + Send,
) -> Result<(T, U)> {
    thread::scope(|scope| {
        let second = scope.spawn(second);
        let first = first();
        let second = second.join().unwrap_or_else(|_| bail!("panicked"));
        match (first, second) {
            (Err(first), Err(second)) => bail!("{first:#}; beside it {second:#}"),
            (first, second) => Ok((first?, second?)),
        }
    })
}

fn clippy() -> Result<()> {
    let features = features_left_out()?;
    let words = ["clippy", "--workspace", "--all-targets", "--features", &features];
    run_quietly(without_debug(cargo(&words).args(["--", "-D", "warnings"])))
}

fn rustdoc() -> Result<()> {
    let words = ["doc", "--workspace", "--no-deps", "--features", &features_left_out()?];
    let mut command = cargo(&words);
    command.arg("--document-private-items");
    run_quietly(without_debug(command.env("RUSTDOCFLAGS", "-D warnings")))
}

/// `package/feature` of every package that has one of [`LEFT_OUT`].
fn features_left_out() -> Result<String> {
    let metadata = metadata()?;
    let packages = metadata["packages"].as_array().context("cargo metadata: packages")?;
    let mut found = Vec::new();
    for package in packages {
        let name = package["name"].as_str().context("a package without a name")?;
        let has = |feature: &&str| !package["features"][*feature].is_null();
        found.extend(LEFT_OUT.into_iter().filter(has).map(|feature| format!("{name}/{feature}")));
    }
    Ok(found.join(","))
}

/// The tests of what a plain build leaves out.
fn tests_of_features(words: &[&str]) -> Command {
    let mut command = cargo(&["test", "--lib", "--test", "it"]);
    for (package, feature) in NEED_LEFT_OUT {
        command.args(["--package", package, "--features", &format!("{package}/{feature}")]);
    }
    without_debug(command.args(words));
    command
}

/// Checks that each crate needs no feature that another one turns on; each checks what lies below it anew.
fn crates_alone() -> Result<()> {
    for package in crates()? {
        let words = ["check", "--package", &package, "--no-default-features"];
        run_quietly(without_debug(&mut cargo(&words)))?;
    }
    Ok(())
}

/// Without debug information and records of what changed: nobody debugs or changes what is built here, and
/// what one of these commands compiles the others take.
fn without_debug(command: &mut Command) -> &mut Command {
    command.envs([("CARGO_PROFILE_DEV_DEBUG", "0"), ("CARGO_INCREMENTAL", "0")])
}

/// Names and seconds of the steps, in the order in which they ended.
#[derive(Default)]
struct Steps(Mutex<Vec<(String, f64)>>);

impl Steps {
    fn run<T>(&self, name: &str, check: impl FnOnce() -> Result<T>) -> Result<T> {
        eprintln!("── {name}");
        let start = Instant::now();
        let value = check().with_context(|| format!("ci step {name:?}"))?;
        let seconds = start.elapsed().as_secs_f64();
        eprintln!("── {name}: done in {seconds:.1} s");
        if let Ok(mut times) = self.0.lock() {
            times.push((name.to_owned(), seconds));
        }
        Ok(value)
    }

    fn print(&self) {
        let Ok(times) = self.0.lock() else { return };
        for (name, seconds) in times.iter() {
            println!("{seconds:8.1} s  {name}");
        }
    }
}

/// Names of the crates that are checked alone.
fn crates() -> Result<Vec<String>> {
    let metadata = metadata()?;
    let packages = metadata["packages"].as_array().context("cargo metadata: packages")?;
    let names = packages.iter().filter_map(|package| package["name"].as_str());
    Ok(names.filter(|name| !NOT_ALONE.contains(name)).map(str::to_owned).collect())
}

/// A quick run of the paper's tables; its figures must show every cell of both tables, none NaN, and none
/// farther from the golden values than they allow.
fn quick_tables() -> Result<()> {
    let program = std::env::current_exe().context("own program")?;
    let mut command = Command::new(program);
    command.args(["repro", "--quick", "--tables"]).current_dir(root());
    let output = command.stderr(std::process::Stdio::inherit()).output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    print!("{text}");
    if !output.status.success() {
        bail!("{} ended with {}", shown(&command), output.status);
    }
    for (name, expected) in
        [("demo.table1_cells", 60.0), ("demo.table2_cells", 8.0), ("demo.nan_cells", 0.0)]
    {
        let value = metric(&text, name)?;
        if value.total_cmp(&expected).is_ne() {
            bail!("{name}: expected {expected}, the run printed {value}");
        }
    }
    let report = root().join("target/hapdef/shin/report/report.json");
    repro::check_golden(&report)?;
    repro::check_results(&report)
}

/// The value of a `METRIC:name:value:unit` line.
fn metric(text: &str, name: &str) -> Result<f64> {
    let mut lines = text.lines().filter_map(|line| line.strip_prefix("METRIC:"));
    let line = lines
        .find_map(|rest| rest.strip_prefix(name)?.strip_prefix(':'))
        .with_context(|| format!("the run printed no METRIC line {name}"))?;
    let value = line.split(':').next().unwrap_or_default();
    value.parse().with_context(|| format!("METRIC {name}: {value:?} is no number"))
}

#[cfg(test)]
mod tests {
    use super::metric;

    #[test]
    fn metric_lines_are_found_by_their_whole_name() {
        let text = "noise\nMETRIC:demo.wall_seconds:9:s\nMETRIC:demo.wall_s:12.5:s\n";
        assert_eq!(metric(text, "demo.wall_s").unwrap(), 12.5);
        assert!(metric(text, "demo.cells").is_err());
    }
}
