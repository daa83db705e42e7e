//! What CI runs, in the order in which it is likely to fail.

use std::process::Command;
use std::thread;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::tool::{cargo, metadata, root, run, run_quietly, shown};
use crate::{
    browser, docs, first_minute, fixtures, frontier, python, readers, repro, soak, stability, tidy,
    verify, weight,
};

/// Property tests draw the same cases in every run of CI; a plain `cargo test` draws new ones.
const PROPTEST_SEED: &str = "20190715";

/// Features that the programs are built without, which clippy and the docs cover, too.
const WITH_MORE: &str = "hapdef/foxglove,hapdef/zenoh";

/// Crates that are not checked alone: nothing stands on xtask, and the wheel is hapdef-py alone.
const NOT_ALONE: [&str; 2] = ["xtask", "hapdef-py"];

/// Runs every check; stops at the first that fails.
fn run_all() -> Result<Vec<(String, f64)>> {
    let mut times = Vec::new();
    step(&mut times, "format", || run(&mut cargo(&["fmt", "--all", "--check"])))?;
    step(&mut times, "tidy", tidy::run)?;
    step(&mut times, "weight", weight::check_table)?;
    step(&mut times, "clippy", || {
        let words = ["clippy", "--workspace", "--all-targets", "--features"];
        run(cargo(&words).args([WITH_MORE, "--", "-D", "warnings"]))
    })?;
    step(&mut times, "docs", || {
        let words = ["doc", "--workspace", "--no-deps", "--features", WITH_MORE];
        let mut command = cargo(&words);
        command.arg("--document-private-items");
        run(command.env("RUSTDOCFLAGS", "-D warnings"))
    })?;
    step(&mut times, "tests", || {
        let words = ["test", "--release", "--no-fail-fast"];
        let mut command = cargo(&words);
        command.env("PROPTEST_RNG_SEED", PROPTEST_SEED);
        run(command.env("HAPDEF_BROWSER", browser::wish()?))
    })?;
    step(&mut times, "tests of network servers", || {
        let words = ["test", "--package", "hapdef-ros", "--features"];
        run(cargo(&words).arg("foxglove,zenoh"))
    })?;
    step(&mut times, "soak --short", soak::short)?;
    thread::scope(|scope| {
        // The tables leave half of the second core idle, and what compiles here is not what they run.
        let alone = scope.spawn(crates_alone);
        step(&mut times, "verification table", verify::check)?;
        step(&mut times, "stability tables", stability::check)?;
        step(&mut times, "limits page", frontier::check)?;
        let wait = || alone.join().unwrap_or_else(|_| bail!("panicked"));
        step(&mut times, "each crate alone, begun with the tables", wait)
    })?;
    step(&mut times, "fixtures", || fixtures::make(true))?;
    step(&mut times, "demo --quick", quick_demo)?;
    step(&mut times, "demo --live", first_minute::check)?;
    step(&mut times, "python", python::check)?;
    step(&mut times, "readers", readers::check)?;
    step(&mut times, "commands of the docs", docs::run_commands)?;
    Ok(times)
}

/// Checks that each crate needs no feature that another one turns on.
fn crates_alone() -> Result<()> {
    for package in crates()? {
        let words = ["check", "--package", &package, "--no-default-features"];
        run_quietly(cargo(&words).env("RUSTFLAGS", ""))?;
    }
    Ok(())
}

/// `cargo xtask ci`.
pub(crate) fn run_everything() -> Result<()> {
    let start = Instant::now();
    let times = run_all()?;
    for (name, seconds) in &times {
        println!("{seconds:8.1} s  {name}");
    }
    println!("{:8.1} s  all", start.elapsed().as_secs_f64());
    Ok(())
}

fn step(
    times: &mut Vec<(String, f64)>,
    name: &str,
    check: impl FnOnce() -> Result<()>,
) -> Result<()> {
    eprintln!("── {name}");
    let start = Instant::now();
    check().with_context(|| format!("ci step {name:?}"))?;
    times.push((name.to_owned(), start.elapsed().as_secs_f64()));
    Ok(())
}

/// Names of the crates that are checked alone.
fn crates() -> Result<Vec<String>> {
    let metadata = metadata()?;
    let packages = metadata["packages"].as_array().context("cargo metadata: packages")?;
    let names = packages.iter().filter_map(|p| p["name"].as_str());
    Ok(names.filter(|name| !NOT_ALONE.contains(name)).map(str::to_owned).collect())
}

/// A quick run of the main job; its figures must show every cell of both tables, none NaN, and none
/// farther from the golden values than they allow.
fn quick_demo() -> Result<()> {
    let program = std::env::current_exe().context("own program")?;
    let mut command = Command::new(program);
    command.args(["demo", "--quick"]).current_dir(root());
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
            bail!("{name}: expected {expected}, the demo printed {value}");
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
        .with_context(|| format!("the demo printed no METRIC line {name}"))?;
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
