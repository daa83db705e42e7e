//! Trials as lines of JSON: written as they end, read back, merged.

use std::path::Path;

use hapdef_report::{ReportError, write_text};
use serde::{Deserialize, Serialize};

use super::space::ParameterValues;
use crate::error::ReproError;

/// What the trials of a file rest on: its first line. Trials of other headers don't compare.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialHeader {
    /// The method's name.
    pub method: String,
    /// What is made least, with its unit.
    pub objective: String,
    /// Keys of the datasets and how much of them was used.
    pub data: String,
    /// Steps of a net's training, or samples of a support-vector machine.
    pub budget: String,
    /// Seed of the search.
    pub seed: u64,
}

/// How a trial's point came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrialSource {
    /// The paper's settings.
    Paper,
    /// Drawn evenly.
    Random,
    /// Proposed from the trials before it.
    Proposed,
}

/// One point that was tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Its number; 0 is the paper's point.
    pub index: usize,
    /// How it came about.
    pub source: TrialSource,
    /// Its parameters.
    pub values: ParameterValues,
    /// The validation error; none where the fit failed.
    pub objective: Option<f64>,
    /// Why it failed.
    pub note: Option<String>,
    /// Samples trained on.
    pub n_train: usize,
    /// Time of fit and validation, s.
    pub elapsed_s: f64,
}

/// The trials of the file at `path`, none where there is no file. A last line that is cut off is left out:
/// its trial is run again.
pub fn open_trials(path: &Path, header: &TrialHeader) -> Result<Vec<Trial>, ReproError> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let (found, trials) = read_trials(path)?;
    check_header(path, header, &found)?;
    Ok(trials)
}

/// Writes header and trials, whole or not at all.
pub fn write_trials(path: &Path, header: &TrialHeader, trials: &[Trial]) -> Result<(), ReproError> {
    let json = |line: serde_json::Result<String>| line.map_err(ReportError::json(path));
    let mut text = json(serde_json::to_string(header))? + "\n";
    for trial in trials {
        text += &(json(serde_json::to_string(trial))? + "\n");
    }
    Ok(write_text(path, &text)?)
}

/// The header and the trials of a file, by their numbers.
pub fn read_trials(path: &Path) -> Result<(TrialHeader, Vec<Trial>), ReproError> {
    let text = std::fs::read_to_string(path).map_err(ReportError::io("reading", path))?;
    let whole = text.rfind('\n').map_or(0, |at| at + 1);
    let bad = ReportError::json(path);
    let mut lines = text[..whole].lines();
    let header = serde_json::from_str(lines.next().unwrap_or_default()).map_err(&bad)?;
    let mut trials: Vec<Trial> =
        lines.map(|line| serde_json::from_str(line).map_err(&bad)).collect::<Result<_, _>>()?;
    trials.sort_by_key(|trial| trial.index);
    Ok((header, trials))
}

/// Joins the trials of several files, such as of the shards of one search, by their numbers.
pub fn merge_trials(files: &[std::path::PathBuf]) -> Result<(TrialHeader, Vec<Trial>), ReproError> {
    let Some((first, rest)) = files.split_first() else {
        return Err(ReproError::TooFewSamples {
            what: "merging trials (files)",
            needed: 1,
            found: 0,
        });
    };
    let (header, mut all) = read_trials(first)?;
    for path in rest {
        let (other, trials) = read_trials(path)?;
        check_header(path, &header, &other)?;
        all.extend(trials);
    }
    all.sort_by_key(|trial| trial.index);
    let same = |a: &Trial, b: &Trial| a.values == b.values && a.objective == b.objective;
    if let Some(pair) =
        all.windows(2).find(|pair| pair[0].index == pair[1].index && !same(&pair[0], &pair[1]))
    {
        return Err(ReproError::Search {
            message: format!(
                "two files have a trial {} with different outcomes: they are not shards of one \
                 search",
                pair[0].index
            ),
        });
    }
    all.dedup_by_key(|trial| trial.index);
    Ok((header, all))
}

/// The trial of the lowest validation error; the earliest of equals.
pub fn best_trial(trials: &[Trial]) -> Option<&Trial> {
    let worth = |trial: &&Trial| trial.objective.unwrap_or(f64::INFINITY);
    let best = trials.iter().min_by(|a, b| worth(a).total_cmp(&worth(b)))?;
    best.objective.map(|_| best)
}

fn check_header(path: &Path, asked: &TrialHeader, found: &TrialHeader) -> Result<(), ReproError> {
    if asked == found {
        return Ok(());
    }
    Err(ReproError::Search {
        message: format!(
            "{}: its trials rest on {found:?}, this search on {asked:?}; move the file away or ask \
             for the same",
            path.display()
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> TrialHeader {
        TrialHeader {
            method: "knn".into(),
            objective: "µm".into(),
            data: "abc".into(),
            budget: "1".into(),
            seed: 1,
        }
    }

    fn trial(index: usize, objective: Option<f64>) -> Trial {
        Trial {
            index,
            source: TrialSource::Random,
            values: [("k".to_owned(), index as f64 / 3.0)].into(),
            objective,
            note: None,
            n_train: 10,
            elapsed_s: 0.5,
        }
    }

    #[test]
    fn what_was_written_is_read_and_a_torn_line_is_run_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.jsonl");
        assert!(open_trials(&path, &header()).unwrap().is_empty());
        let all = [trial(0, Some(1.0 / 3.0)), trial(1, None)];
        write_trials(&path, &header(), &all).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text + "{\"index\": 2, \"sou").unwrap();
        assert_eq!(open_trials(&path, &header()).unwrap(), all);
        let other = TrialHeader { seed: 2, ..header() };
        let error = open_trials(&path, &other).unwrap_err().to_string();
        assert!(error.contains("seed: 2"), "{error}");
    }

    #[test]
    fn shards_merge_by_number_and_contradictions_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, trials: &[Trial]| {
            let path = folder.path().join(name);
            write_trials(&path, &header(), trials).unwrap();
            path
        };
        let a = write("a", &[trial(0, Some(3.0)), trial(2, Some(1.0))]);
        let b = write("b", &[trial(1, None), trial(2, Some(1.0))]);
        let (_, all) = merge_trials(&[a.clone(), b]).unwrap();
        assert_eq!(all.iter().map(|t| t.index).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(best_trial(&all).unwrap().index, 2);
        let c = write("c", &[trial(2, Some(9.0))]);
        let error = merge_trials(&[a, c]).unwrap_err().to_string();
        assert!(error.contains("trial 2"), "{error}");
        assert!(best_trial(&[trial(0, None)]).is_none());
    }
}
