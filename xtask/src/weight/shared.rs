//! Crates that would be compiled twice: with one set of features for the tests, with another for the wheel or
//! the programs.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result, bail};

use crate::tool::{cargo, shown};

/// What must take what was compiled for the tests, in words of `cargo tree`.
const TAKERS: [(&str, &[&str]); 2] = [
    ("the wheel", &["--package", "hapdef-py", "--edges", "normal,build"]),
    ("a program", &["--edges", "normal,build"]),
];

/// The tests, which have every dependency of the workspace but the wheel's own.
const TESTS: [&str; 2] = ["--edges", "normal,build,dev"];

/// Sets of features that a crate has, by its name and version.
type Features = BTreeMap<String, BTreeSet<BTreeSet<String>>>;

/// Fails where a crate has other features in one of [`TAKERS`] than it has in the tests.
pub(super) fn check() -> Result<()> {
    let tests = features(&TESTS)?;
    let mut faults = Vec::new();
    for (name, words) in TAKERS {
        faults.extend(
            twice(&features(words)?, &tests).iter().map(|fault| format!("{name}: {fault}")),
        );
    }
    if faults.is_empty() {
        return Ok(());
    }
    bail!(
        "compiled twice, and all that stands on it; name the missing features in \
         crates/workspace-hack/Cargo.toml:\n  {}",
        faults.join("\n  ")
    )
}

/// Crates of both whose features differ, with the features that one of them lacks.
fn twice(of: &Features, tests: &Features) -> Vec<String> {
    let mut found = Vec::new();
    for (name, sets) in of {
        let Some(others) = tests.get(name) else { continue };
        for set in sets.difference(others) {
            let nearest = others.iter().min_by_key(|other| set.symmetric_difference(other).count());
            let missing = nearest.into_iter().flat_map(|other| set.symmetric_difference(other));
            let missing: Vec<&str> = missing.map(String::as_str).collect();
            found.push(format!("{name}, {}", missing.join(", ")));
        }
    }
    found
}

fn features(words: &[&str]) -> Result<Features> {
    let mut command = cargo(&["tree", "--locked", "--prefix", "none", "--format", "{p}|{f}"]);
    let output = command.args(words).output().context("starting cargo tree")?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        bail!("{} ended with {}: {text}", shown(&command), output.status);
    }
    Ok(read(&String::from_utf8_lossy(&output.stdout)))
}

/// Lines such as `rand v0.10.3|alloc,std (*)`; a path or `(proc-macro)` may follow the version.
fn read(text: &str) -> Features {
    let mut all = Features::new();
    for (package, features) in text.lines().filter_map(|line| line.split_once('|')) {
        let name = package.split(" (").next().unwrap_or(package).to_owned();
        let listed = features.trim_end_matches(" (*)").split(',').filter(|word| !word.is_empty());
        all.entry(name).or_default().insert(listed.map(str::to_owned).collect());
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{read, twice};

    #[test]
    fn a_crate_with_other_features_is_found() {
        let tests =
            read("a v1.0.0|std\nb v2.0.0 (proc-macro)|\nc v1.0.0 (/c)|x,y\nc v1.0.0 (/c)|x");
        assert!(twice(&read("a v1.0.0|std (*)\nc v1.0.0|x\nd v1.0.0|new"), &tests).is_empty());
        assert_eq!(
            twice(&read("a v1.0.0|\nb v2.0.0|more"), &tests),
            ["a v1.0.0, std", "b v2.0.0, more"]
        );
    }
}
