//! Trials as lines of JSON: appended as they end, read back, merged.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;

use hapdef_report::ReportError;
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

/// A file of trials that is being added to.
#[derive(Debug)]
pub struct TrialLog {
    file: File,
    path: std::path::PathBuf,
}

impl TrialLog {
    /// Opens `path`, or makes it with `header`; gives the trials that are in it. A last line that a
    /// crash cut off is dropped from the file: its trial is run again.
    pub fn open(path: &Path, header: &TrialHeader) -> Result<(Self, Vec<Trial>), ReproError> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(ReportError::io("making folder", folder))?;
        }
        let file = OpenOptions::new().append(true).create(true).open(path);
        let file = file.map_err(ReportError::io("opening", path))?;
        let text = std::fs::read_to_string(path).map_err(ReportError::io("reading", path))?;
        let whole = text.rfind('\n').map_or(0, |at| at + 1);
        file.set_len(whole as u64).map_err(ReportError::io("cutting", path))?;
        let mut log = Self { file, path: path.to_owned() };
        if whole == 0 {
            log.append(header)?;
            return Ok((log, Vec::new()));
        }
        let (found, trials) = parse_trials(path, &text[..whole])?;
        check_header(path, header, &found)?;
        Ok((log, trials))
    }

    /// Adds a trial; it is on disk when this returns.
    pub fn push(&mut self, trial: &Trial) -> Result<(), ReproError> {
        self.append(trial)
    }

    fn append(&mut self, line: &impl Serialize) -> Result<(), ReproError> {
        let mut text = serde_json::to_vec(line).map_err(ReportError::json(&self.path))?;
        text.push(b'\n');
        Ok(self
            .file
            .write_all(&text)
            .and_then(|()| self.file.sync_data())
            .map_err(ReportError::io("writing", &self.path))?)
    }
}

/// The header and the trials of a file.
pub fn read_trials(path: &Path) -> Result<(TrialHeader, Vec<Trial>), ReproError> {
    let text = std::fs::read_to_string(path).map_err(ReportError::io("reading", path))?;
    let whole = text.rfind('\n').map_or(0, |at| at + 1);
    parse_trials(path, &text[..whole])
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

/// Header and trials as a file's text.
pub fn trials_text(header: &TrialHeader, trials: &[Trial]) -> Result<String, ReproError> {
    let bad = ReportError::json(Path::new("trials"));
    let json = |line: serde_json::Result<String>| line.map_err(&bad);
    let mut text = json(serde_json::to_string(header))? + "\n";
    for trial in trials {
        text += &(json(serde_json::to_string(trial))? + "\n");
    }
    Ok(text)
}

fn parse_trials(path: &Path, text: &str) -> Result<(TrialHeader, Vec<Trial>), ReproError> {
    let bad = ReportError::json(path);
    let mut lines = text.lines();
    let header = serde_json::from_str(lines.next().unwrap_or_default()).map_err(&bad)?;
    let mut trials: Vec<Trial> =
        lines.map(|line| serde_json::from_str(line).map_err(&bad)).collect::<Result<_, _>>()?;
    trials.sort_by_key(|trial| trial.index);
    Ok((header, trials))
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
        let path = folder.path().join("deep/trials.jsonl");
        let (mut log, none) = TrialLog::open(&path, &header()).unwrap();
        assert!(none.is_empty());
        let all = [trial(0, Some(1.0 / 3.0)), trial(1, None)];
        all.iter().for_each(|t| log.push(t).unwrap());
        std::fs::OpenOptions::new()
            .append(true)
            .open(&path)
            .unwrap()
            .write_all(b"{\"index\": 2, \"sou")
            .unwrap();
        let (mut log, read) = TrialLog::open(&path, &header()).unwrap();
        assert_eq!(read, all);
        log.push(&trial(2, Some(0.1))).unwrap();
        assert_eq!(read_trials(&path).unwrap().1.len(), 3);
        let other = TrialHeader { seed: 2, ..header() };
        let error = TrialLog::open(&path, &other).unwrap_err().to_string();
        assert!(error.contains("seed: 2"), "{error}");
    }

    #[test]
    fn shards_merge_by_number_and_contradictions_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, trials: &[Trial]| {
            let path = folder.path().join(name);
            let (mut log, _) = TrialLog::open(&path, &header()).unwrap();
            trials.iter().for_each(|t| log.push(t).unwrap());
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
