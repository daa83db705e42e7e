//! How well touch is found on a limb once simulated presses have calibrated it: from the file to errors.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::tool::{into_results, shown};

/// Errors of contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    /// Over all contacts; one that is not found is infinitely far.
    pub(super) median_mm: f64,
    /// Share that is not found within 10 mm.
    pub(super) share_beyond: f64,
}

/// A limb's touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// Time of `hapdef new`, s.
    pub(super) new_s: f64,
    /// Of one contact at a time, and of two.
    pub(super) errors: [Errors; 2],
}

impl Touch {
    /// Makes a limb of `file` in `folder`, calibrates it by simulated presses and finds others.
    ///
    /// # Errors
    /// What a command refuses.
    pub(super) fn of(program: &Path, file: &Path, folder: &Path) -> Result<Self> {
        fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
        let file = file.canonicalize().with_context(|| format!("reading {}", file.display()))?;
        let start = Instant::now();
        let file = file.to_string_lossy();
        printed(program, folder, &["new", &file, "--out", "limb", "--replace", "--yes"])?;
        let new_s = start.elapsed().as_secs_f64();
        let text = printed(program, folder, &["demo", "limb", "--json"])?;
        let found: Value = serde_json::from_str(&text).context("what hapdef demo prints")?;
        Ok(Self { new_s, errors: [Errors::of(&found, 1)?, Errors::of(&found, 2)?] })
    }

    /// Columns of the table.
    pub(super) fn cells(&self) -> String {
        let of = |errors: &Errors| {
            format!("{:.2}, {:.0}", errors.median_mm, 100.0 * errors.share_beyond)
        };
        let [single, double] = self.errors.each_ref().map(of);
        format!("{:.0} | {single} | {double}", self.new_s)
    }
}

impl Errors {
    /// Those of presses of `n_contacts` in what `hapdef demo --json` printed.
    fn of(found: &Value, n_contacts: usize) -> Result<Self> {
        let scores = found["scores"].as_array().into_iter().flatten();
        let score = scores.clone().find(|score| score["n_contacts"] == n_contacts);
        let score = score.with_context(|| format!("no score of {n_contacts} contacts"))?;
        let within = score["share_within_10mm"].as_f64().context("share_within_10mm")?;
        // JSON has no infinity: more than half of the contacts were not found.
        let median_mm = score["median_mm"].as_f64().unwrap_or(f64::INFINITY);
        Ok(Self { median_mm, share_beyond: 1.0 - within })
    }
}

/// What the program prints, run in a folder.
fn printed(program: &Path, folder: &Path, words: &[&str]) -> Result<String> {
    let mut command = Command::new(program);
    into_results(command.args(words).current_dir(folder));
    let output = command.output().with_context(|| format!("starting {}", shown(&command)))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!("{}: {}", words[0], said.lines().last().unwrap_or_default());
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::Errors;

    #[test]
    fn errors_are_read_and_a_count_that_is_missing_is_said() {
        let found = json!({"scores": [
            {"n_contacts": 1, "median_mm": 0.2, "share_within_10mm": 0.75},
            {"n_contacts": 2, "median_mm": null, "share_within_10mm": 0.25}]});
        let errors = Errors::of(&found, 1).unwrap();
        assert_eq!(errors, Errors { median_mm: 0.2, share_beyond: 0.25 });
        assert_eq!(Errors::of(&found, 2).unwrap().median_mm, f64::INFINITY);
        assert!(Errors::of(&found, 3).is_err());
    }
}
