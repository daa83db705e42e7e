//! What somebody compiles who takes one layer alone.

use std::collections::BTreeSet;
use std::fs;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::tool::{cargo, root, run as run_to_end, shown, target_dir};

/// Arguments of `weight`.
#[derive(clap::Args)]
pub(crate) struct WeightArgs {
    /// Build the robot's crates in release into a folder of their own and time it.
    #[arg(long)]
    build: bool,
    /// Fail where the table in ARCHITECTURE.md says something else.
    #[arg(long)]
    check: bool,
}

/// A build of one layer with those below it: its name in metrics and in the table, its package, which
/// is taken without default features, and the features that it is taken with.
struct Layers {
    name: &'static str,
    package: &'static str,
    /// One of its own, or `package/feature` of one below it.
    feature: Option<&'static str>,
    /// See [`MAX_ROBOT_CRATES`].
    is_limited: bool,
}

const LAYERS: [Layers; 5] = [
    Layers {
        name: "kmax",
        package: "hapdef-kmax",
        feature: Some("points"),
        is_limited: false,
    },
    Layers {
        name: "daq",
        package: "hapdef-daq",
        feature: None,
        is_limited: false,
    },
    Layers {
        name: "robot",
        package: ROBOT,
        feature: None,
        is_limited: true,
    },
    Layers {
        name: "robot_serial",
        package: ROBOT,
        feature: Some("hapdef-daq/serial"),
        is_limited: false,
    },
    Layers {
        name: "robot_nets",
        package: ROBOT,
        feature: Some("nets"),
        is_limited: true,
    },
];

/// What a robot builds.
const ROBOT: &str = "hapdef-live";

/// A robot's build that reads by TCP has fewer crates than this; serial ports come on top.
const MAX_ROBOT_CRATES: usize = 60;

/// `cargo xtask weight`.
pub(crate) fn run(args: &WeightArgs) -> Result<()> {
    let counts = counts()?;
    println!("{}", table(&counts));
    check_robot(&counts)?;
    if args.check {
        check(&counts)?;
    }
    for (layers, n) in LAYERS.iter().zip(&counts) {
        println!("METRIC:weight.{}_crates:{n}:1", layers.name);
    }
    if args.build {
        println!("METRIC:weight.robot_build_s:{:.1}:s", build_s(&LAYERS[2])?);
    } else {
        println!("METRIC:weight.robot_build_s:skipped:--build not given");
    }
    Ok(())
}

/// Fails where a robot's build is too heavy, or the table in ARCHITECTURE.md says something else.
pub(crate) fn check_table() -> Result<()> {
    let counts = counts()?;
    check_robot(&counts)?;
    check(&counts)
}

/// Crates of each build, its own included, as Cargo.lock has them.
fn counts() -> Result<Vec<usize>> {
    LAYERS
        .iter()
        .map(|layers| Ok(tree(layers)?.len()))
        .collect()
}

fn tree(layers: &Layers) -> Result<BTreeSet<String>> {
    let words = [
        "tree",
        "--locked",
        "--edges",
        "normal",
        "--no-default-features",
        "--prefix",
        "none",
    ];
    let mut command = cargo(&words);
    command.args(layers.words());
    let output = command.output().context("starting cargo tree")?;
    if !output.status.success() {
        let what = String::from_utf8_lossy(&output.stderr);
        bail!("{} failed: {}", shown(&command), what.trim());
    }
    let text = String::from_utf8(output.stdout).context("cargo tree")?;
    Ok(crates(&text))
}

/// Names with versions; a crate that is shown again is the same one.
fn crates(tree: &str) -> BTreeSet<String> {
    let name = |line: &str| {
        let mut words = line.split_whitespace();
        Some(format!("{} {}", words.next()?, words.next()?))
    };
    tree.lines().filter_map(name).collect()
}

impl Layers {
    /// What cargo takes it by.
    fn words(&self) -> impl Iterator<Item = &'static str> {
        let feature = self.feature.into_iter().flat_map(|f| ["--features", f]);
        ["--package", self.package].into_iter().chain(feature)
    }

    /// `package`, `package/feature`, or `package + another/feature`.
    fn shown(&self) -> String {
        let package = self.package;
        match self.feature {
            None => package.to_owned(),
            Some(feature) if feature.contains('/') => format!("{package} + {feature}"),
            Some(feature) => format!("{package}/{feature}"),
        }
    }
}

/// Rows as they stand in ARCHITECTURE.md.
fn table(counts: &[usize]) -> String {
    let row =
        |(layers, n): (&Layers, &usize)| format!("| {} | {} | {n} |", layers.name, layers.shown());
    let rows = LAYERS.iter().zip(counts).map(row);
    let head = ["| build | packages | crates |", "|---|---|---|"].map(str::to_owned);
    head.into_iter().chain(rows).collect::<Vec<_>>().join("\n")
}

fn check_robot(counts: &[usize]) -> Result<()> {
    let robots = LAYERS.iter().zip(counts).filter(|(l, _)| l.is_limited);
    for (layers, n) in robots {
        if *n >= MAX_ROBOT_CRATES {
            bail!(
                "a robot's build of {} is {n} crates, expected less than {MAX_ROBOT_CRATES}: \
                 cargo tree --no-default-features shows which came",
                layers.shown()
            );
        }
    }
    Ok(())
}

fn check(counts: &[usize]) -> Result<()> {
    let path = root().join("ARCHITECTURE.md");
    let text = fs::read_to_string(&path).context("reading ARCHITECTURE.md")?;
    let table = table(counts);
    let missing = missing_rows(&text, &table)?;
    if missing.is_empty() {
        return Ok(());
    }
    bail!(
        "ARCHITECTURE.md, Weight, says something else; put there, if the difference is wanted:\n{}",
        missing.join("\n")
    )
}

/// Rows of `table` that the section Weight does not have.
fn missing_rows<'a>(architecture: &str, table: &'a str) -> Result<Vec<&'a str>> {
    let (_, section) = architecture
        .split_once("\n## Weight\n")
        .context("ARCHITECTURE.md has no section Weight")?;
    let section = section.split("\n## ").next().unwrap_or_default();
    let there: BTreeSet<&str> = section.lines().map(str::trim).collect();
    Ok(table.lines().filter(|row| !there.contains(row)).collect())
}

/// Seconds of a release build from nothing, in a folder that is removed again.
fn build_s(layers: &Layers) -> Result<f64> {
    let folder = target_dir()?.join(format!("weight-{}", std::process::id()));
    let mut command = cargo(&["build", "--release", "--locked", "--no-default-features"]);
    command
        .args(layers.words())
        .env("CARGO_TARGET_DIR", &folder);
    let start = Instant::now();
    let built = run_to_end(&mut command);
    let elapsed_s = start.elapsed().as_secs_f64();
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
    }
    built?;
    Ok(elapsed_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crate_counts_once_and_two_versions_twice() {
        let tree = "a v1.0.0 (/somewhere)\nb v2.0.0\nb v2.0.0 (*)\n\nb v3.0.0 (proc-macro)\n";
        assert_eq!(crates(tree).len(), 3);
    }

    #[test]
    fn a_count_that_differs_is_named() {
        let page = format!(
            "# A\n\n## Weight\n\n{}\n\n## B\n| robot |\n",
            table(&[1, 2, 3, 9, 4])
        );
        assert!(
            missing_rows(&page, &table(&[1, 2, 3, 9, 4]))
                .unwrap()
                .is_empty()
        );
        let grown = table(&[1, 2, 5, 9, 4]);
        let missing = missing_rows(&page, &grown).unwrap();
        assert_eq!(missing, ["| robot | hapdef-live | 5 |"]);
        assert!(missing_rows("# A\n", &grown).is_err());
    }

    #[test]
    fn a_robots_build_that_is_too_heavy_fails() {
        assert!(check_robot(&[1, 2, 3, MAX_ROBOT_CRATES, MAX_ROBOT_CRATES - 1]).is_ok());
        let error = check_robot(&[1, 2, 3, 4, MAX_ROBOT_CRATES]).unwrap_err();
        assert!(error.to_string().contains("hapdef-live/nets"), "{error}");
    }
}
