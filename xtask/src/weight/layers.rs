//! The layers that somebody may take, and the crates of each.

use std::collections::BTreeSet;

use anyhow::{Context, Result, bail};

use crate::tool::{cargo, shown};

/// A build of one layer with those below it: its name in metrics and in the table, its package, which
/// is taken without default features, and the features that it is taken with.
pub(super) struct Layers {
    pub(super) name: &'static str,
    package: &'static str,
    /// One of its own, or `package/feature` of one below it.
    feature: Option<&'static str>,
    /// See [`super::MAX_ROBOT_CRATES`].
    pub(super) is_limited: bool,
}

/// From the bottom up; the last is everything that the command line has.
pub(super) const LAYERS: [Layers; 18] = [
    plain("kmax", "hapdef-kmax").with("points"),
    plain("data", "hapdef-data"),
    plain("mesh", "hapdef-mesh"),
    plain("sim", "hapdef-sim"),
    plain("contact", "hapdef-contact"),
    plain("inverse", "hapdef-inverse"),
    plain("nets", "hapdef-nets"),
    plain("nets_train", "hapdef-nets").with("train"),
    plain("daq", "hapdef-daq"),
    plain("robot", ROBOT).limited(),
    plain("robot_serial", ROBOT).with("hapdef-daq/serial"),
    plain("robot_nets", ROBOT).with("nets").limited(),
    plain("ros", "hapdef-ros"),
    plain("rig", "hapdef-rig").with("solve"),
    plain("view", "hapdef-view").with("server"),
    plain("wasm", "hapdef-wasm"),
    plain("report", "hapdef-report"),
    plain("program", "hapdef-cli"),
];

/// What a robot builds.
const ROBOT: &str = "hapdef-live";

const fn plain(name: &'static str, package: &'static str) -> Layers {
    Layers { name, package, feature: None, is_limited: false }
}

impl Layers {
    const fn with(mut self, feature: &'static str) -> Self {
        self.feature = Some(feature);
        self
    }

    const fn limited(mut self) -> Self {
        self.is_limited = true;
        self
    }

    /// What cargo takes it by.
    pub(super) fn words(&self) -> impl Iterator<Item = &'static str> {
        let feature = self.feature.into_iter().flat_map(|f| ["--features", f]);
        ["--no-default-features", "--package", self.package].into_iter().chain(feature)
    }

    /// `package`, `package/feature`, or `package + another/feature`.
    pub(super) fn shown(&self) -> String {
        let package = self.package;
        match self.feature {
            None => package.to_owned(),
            Some(feature) if feature.contains('/') => format!("{package} + {feature}"),
            Some(feature) => format!("{package}/{feature}"),
        }
    }

    /// Its crates, its own included, with their versions, as Cargo.lock has them.
    pub(super) fn crates(&self) -> Result<BTreeSet<String>> {
        let words = ["tree", "--locked", "--edges", "normal", "--prefix", "none"];
        let mut command = cargo(&words);
        command.args(self.words());
        let output = command.output().context("starting cargo tree")?;
        if !output.status.success() {
            let what = String::from_utf8_lossy(&output.stderr);
            bail!("{} failed: {}", shown(&command), what.trim());
        }
        let text = String::from_utf8(output.stdout).context("cargo tree")?;
        Ok(crates(&text))
    }
}

/// Names with versions; a crate that is shown again is the same one.
fn crates(tree: &str) -> BTreeSet<String> {
    let name = |line: &str| {
        let mut words = line.split_whitespace();
        Some(format!("{} {}", words.next()?, words.next()?))
    };
    tree.lines().filter_map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crate_counts_once_and_two_versions_twice() {
        let tree = "a v1.0.0 (/somewhere)\nb v2.0.0\nb v2.0.0 (*)\n\nb v3.0.0 (proc-macro)\n";
        assert_eq!(crates(tree).len(), 3);
    }
}
