//! What a limb's gauges tell of touch once simulated presses have calibrated them: from the file to errors.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

use crate::tool::{into_results, shown};

/// Presses that the response is corrected by.
const N_CALIBRATION: usize = 300;

/// Other presses that are scored, of one contact and of two.
const N_SCORED: usize = 100;

/// An error beyond this is a contact found at the wrong place, m; so is one that is not found.
const BEYOND_M: f64 = 0.01;

/// Errors of contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    pub(super) median_m: f64,
    /// Share beyond [`BEYOND_M`].
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
        let hapdef = Hapdef { program, folder };
        let file = file.canonicalize().with_context(|| format!("reading {}", file.display()))?;
        let start = Instant::now();
        let file = file.to_string_lossy();
        hapdef.done(&["new", &file, "--folder", "limb", "--replace", "--yes"])?;
        let new_s = start.elapsed().as_secs_f64();
        let n = N_CALIBRATION.to_string();
        hapdef.done(&["probe", "limb", "presses.csv", "--presses", &n])?;
        hapdef.done(&["calibrate", "limb", "presses.csv", "limb/made.json"])?;
        use_calibration(&folder.join("limb/scene.json"))?;
        Ok(Self { new_s, errors: [hapdef.errors(1)?, hapdef.errors(2)?] })
    }

    /// Columns of the table.
    pub(super) fn cells(&self) -> String {
        let of = |errors: &Errors| {
            format!("{:.2}, {:.0}", 1e3 * errors.median_m, 100.0 * errors.share_beyond)
        };
        let [single, double] = self.errors.each_ref().map(of);
        format!("{:.0} | {single} | {double}", self.new_s)
    }
}

/// The program, run in a folder.
struct Hapdef<'a> {
    program: &'a Path,
    folder: &'a Path,
}

impl Hapdef<'_> {
    /// What a command prints.
    fn done(&self, words: &[&str]) -> Result<String> {
        let mut command = Command::new(self.program);
        into_results(command.args(words).current_dir(self.folder));
        let output = command.output().with_context(|| format!("starting {}", shown(&command)))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            bail!("{}: {}", words[0], said.lines().last().unwrap_or_default());
        }
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// Errors of presses of `n_contacts` that the calibration has not seen.
    fn errors(&self, n_contacts: usize) -> Result<Errors> {
        let (table, n, seed) =
            (format!("others{n_contacts}.csv"), N_SCORED.to_string(), (1 + n_contacts).to_string());
        let contacts = n_contacts.to_string();
        let drawn = ["--presses", &n, "--contacts", &contacts, "--press-seed", &seed];
        self.done(&[&["probe", "limb", &table], &drawn[..]].concat())?;
        let found = self.done(&["contacts", "limb", &table, "--json"])?;
        let path = self.folder.join(&table);
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let mut all = Vec::new();
        for (row, frame) in text.lines().skip(1).zip(found.lines()) {
            all.extend(misses_m(&places(row, n_contacts)?, &strongest(frame, n_contacts)?));
        }
        Ok(Errors::of(all))
    }
}

impl Errors {
    fn of(mut misses_m: Vec<f64>) -> Self {
        misses_m.sort_by(f64::total_cmp);
        let n_beyond = misses_m.iter().filter(|miss| **miss > BEYOND_M).count();
        Self {
            median_m: misses_m.get(misses_m.len() / 2).copied().unwrap_or(f64::INFINITY),
            share_beyond: n_beyond as f64 / misses_m.len().max(1) as f64,
        }
    }
}

/// The scene finds contacts by the calibration beside it from now on.
fn use_calibration(file: &Path) -> Result<()> {
    let text = fs::read(file).with_context(|| format!("reading {}", file.display()))?;
    let mut scene: Value = serde_json::from_slice(&text)?;
    scene["estimator"] = json!({"kind": "superposition", "calibration": "made.json"});
    fs::write(file, scene.to_string()).with_context(|| format!("writing {}", file.display()))
}

type Place = [f64; 3];

/// Where the contacts of a row are.
fn places(row: &str, n_contacts: usize) -> Result<Vec<Place>> {
    let numbers: Vec<f64> = row.split(',').map(|word| Ok(word.parse()?)).collect::<Result<_>>()?;
    let places = numbers.chunks_exact(4).take(n_contacts);
    Ok(places.map(|place| [place[0], place[1], place[2]]).collect())
}

/// Where the strongest contacts of a frame were found.
fn strongest(frame: &str, n_contacts: usize) -> Result<Vec<Place>> {
    let frame: Value = serde_json::from_str(frame)?;
    let mut contacts = frame["contacts"].as_array().context("a frame without contacts")?.clone();
    let force_n = |contact: &Value| contact["force_n"].as_f64().unwrap_or_default();
    contacts.sort_by(|a, b| force_n(b).total_cmp(&force_n(a)));
    let place = |contact: &Value| {
        [0, 1, 2].map(|axis| contact["position_m"][axis].as_f64().unwrap_or(f64::NAN))
    };
    Ok(contacts.iter().take(n_contacts).map(place).collect())
}

/// How far each of one or two true contacts is from the found one that it is paired with, so that the
/// sum is least; one that has none is infinitely far.
fn misses_m(truth: &[Place], found: &[Place]) -> Vec<f64> {
    let miss = |at: Option<&Place>, place: &Place| {
        at.map_or(f64::INFINITY, |at| {
            [0, 1, 2].map(|axis| (at[axis] - place[axis]).powi(2)).iter().sum::<f64>().sqrt()
        })
    };
    let paired = |order: [usize; 2]| -> Vec<f64> {
        truth.iter().zip(order).map(|(place, i)| miss(found.get(i), place)).collect()
    };
    let finite = |misses: &Vec<f64>| misses.iter().filter(|m| m.is_finite()).sum::<f64>();
    let [first, second] = [[0, 1], [1, 0]].map(paired);
    let is_worse = truth.len() == 2 && !found.is_empty() && finite(&second) < finite(&first);
    if is_worse { second } else { first }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_are_paired_so_that_the_sum_is_least() {
        let [a, b] = [[0.0; 3], [0.1, 0.0, 0.0]];
        assert_eq!(misses_m(&[a, b], &[b, a]), [0.0, 0.0]);
        assert_eq!(misses_m(&[a, b], &[b]), [f64::INFINITY, 0.0]);
        assert_eq!(misses_m(&[a, b], &[]), [f64::INFINITY; 2]);
        assert_eq!(misses_m(&[a], &[b]), [0.1]);
    }

    #[test]
    fn what_is_not_found_is_beyond() {
        let errors = Errors::of(vec![f64::INFINITY, 0.001, 0.02, 0.003]);
        assert_eq!(errors, Errors { median_m: 0.02, share_beyond: 0.5 });
        assert_eq!(Errors::of(vec![f64::INFINITY]).share_beyond, 1.0);
    }

    #[test]
    fn rows_and_frames_are_read() {
        let row = "0.1,0.2,0.3,9,0.4,0.5,0.6,8,12.5,-3";
        assert_eq!(places(row, 2).unwrap(), [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]);
        let frame = r#"{"contacts": [{"force_n": 1.0, "position_m": [1, 2, 3]},
            {"force_n": 5.0, "position_m": [4, 5, 6]}]}"#;
        assert_eq!(strongest(frame, 1).unwrap(), [[4.0, 5.0, 6.0]]);
        assert!(strongest("{}", 1).is_err());
    }
}
