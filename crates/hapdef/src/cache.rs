//! The content-addressed cache: a stage whose inputs are unchanged is not run again.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::error::HapdefError;

/// Folder of finished stages, `<root>/<stage>-<key>/`, the key being the hash of what went in.
#[derive(Clone, Debug)]
pub struct Cache {
    root: PathBuf,
    only_looks: bool,
}

/// A finished stage.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Folder with what it wrote.
    pub dir: PathBuf,
    /// Hash of what went in; part of the key of stages that build on this one.
    pub key: String,
    /// Whether it was there already.
    pub cached: bool,
    /// Its record.
    pub record: StageRecord,
}

/// What is written beside a stage's results.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StageRecord {
    /// Name of the stage.
    pub stage: String,
    /// What went in.
    pub inputs: serde_json::Value,
    /// What happened: sizes, residuals, losses.
    pub info: serde_json::Value,
    /// Wall-clock time of the run that made it, s.
    pub elapsed_s: f64,
}

const RECORD_FILE: &str = "stage.json";

impl Cache {
    /// A cache under `root`, which is made when needed.
    #[must_use]
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into(), only_looks: false }
    }

    /// The same folder, only looked at: [`Self::stage`] then runs and writes nothing, and a stage
    /// that is not there comes back not cached, with an empty record.
    #[must_use]
    pub fn looking(&self) -> Self {
        Self { root: self.root.clone(), only_looks: true }
    }

    /// Returns the stage if it is there, or lets `run` make it in a folder that gets its final
    /// name only when `run` is done. What an interrupted run left in that folder is still there
    /// the next time, so a stage can resume. Two processes don't make one stage at a time.
    ///
    /// # Errors
    /// What `run` returns, and [`HapdefError::File`].
    pub fn stage(
        &self,
        stage: &str,
        inputs: &serde_json::Value,
        run: impl FnOnce(&Path) -> Result<serde_json::Value, HapdefError>,
    ) -> Result<Stage, HapdefError> {
        let key = key_of(stage, inputs);
        let dir = self.root.join(format!("{stage}-{key}"));
        if self.only_looks {
            return look(stage, inputs, key, dir);
        }
        fs::create_dir_all(&self.root).map_err(HapdefError::file(&self.root))?;
        let _lock = self.lock(stage, &key)?;
        if let Some(record) = read_record(&dir)? {
            return Ok(Stage { dir, key, cached: true, record });
        }
        let partial = self.root.join(format!("{stage}-{key}.partial"));
        fs::create_dir_all(&partial).map_err(HapdefError::file(&partial))?;
        let start = Instant::now();
        let info = run(&partial).inspect_err(|_| {
            // Succeeds only if the folder is empty: what an interrupted stage left stays.
            let _ = fs::remove_dir(&partial);
        })?;
        let elapsed_s = start.elapsed().as_secs_f64();
        let record = StageRecord { stage: stage.into(), inputs: inputs.clone(), info, elapsed_s };
        write_json(&partial.join(RECORD_FILE), &record)?;
        fs::rename(&partial, &dir).map_err(HapdefError::file(&dir))?;
        Ok(Stage { dir, key, cached: false, record })
    }

    /// Records of all finished stages that can be read, and those that were kept beside them.
    pub(crate) fn records(&self) -> Vec<StageRecord> {
        let dirs = fs::read_dir(&self.root).into_iter().flatten().flatten();
        let mut dirs: Vec<PathBuf> = dirs.map(|entry| entry.path()).collect();
        dirs.sort();
        dirs.iter().filter_map(|dir| read_record(dir).ok().flatten()).collect()
    }

    /// Keeps a record of what is no stage; the last one of its name stays.
    pub(crate) fn keep(&self, record: &StageRecord) -> Result<(), HapdefError> {
        let dir = self.root.join(&record.stage);
        fs::create_dir_all(&dir).map_err(HapdefError::file(&dir))?;
        write_json(&dir.join(RECORD_FILE), record)
    }

    fn lock(&self, stage: &str, key: &str) -> Result<File, HapdefError> {
        let path = self.root.join(format!("{stage}-{key}.lock"));
        let file = File::create(&path).map_err(HapdefError::file(&path))?;
        file.lock().map_err(HapdefError::file(&path))?;
        Ok(file)
    }
}

/// Writes a value as JSON under a temporary name, then renames it.
///
/// # Errors
/// [`HapdefError::File`] when the disk refuses.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), HapdefError> {
    let json =
        serde_json::to_vec_pretty(value).map_err(|error| HapdefError::file(path)(error.into()))?;
    hapdef_mesh::atomic_write(path, |file| std::io::Write::write_all(file, &json))
        .map_err(HapdefError::file(path))
}

/// The finished stage in `dir`, or one that is still to be run.
fn look(
    stage: &str,
    inputs: &serde_json::Value,
    key: String,
    dir: PathBuf,
) -> Result<Stage, HapdefError> {
    let found = read_record(&dir)?;
    let cached = found.is_some();
    let record = found.unwrap_or_else(|| StageRecord {
        stage: stage.into(),
        inputs: inputs.clone(),
        info: serde_json::Value::Null,
        elapsed_s: 0.0,
    });
    Ok(Stage { dir, key, cached, record })
}

/// Hash of a stage's name and inputs, in whatever order their fields were written, 16 hexadecimal
/// digits.
fn key_of(stage: &str, inputs: &serde_json::Value) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(stage.as_bytes());
    hasher.update(inputs.to_string().as_bytes());
    hasher.finalize().to_hex()[..16].to_owned()
}

fn read_record(dir: &Path) -> Result<Option<StageRecord>, HapdefError> {
    let path = dir.join(RECORD_FILE);
    if !path.exists() {
        return Ok(None);
    }
    let text = fs::read(&path).map_err(HapdefError::file(&path))?;
    let record = serde_json::from_slice(&text)
        .map_err(|error| HapdefError::Stale { path, what: error.to_string() })?;
    Ok(Some(record))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn an_unchanged_stage_runs_once_and_a_changed_one_again() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path());
        let mut runs = 0;
        for inputs in [json!({"a": 1}), json!({"a": 1}), json!({"a": 2})] {
            let stage = cache.stage("square", &inputs, |_| {
                runs += 1;
                Ok(json!({}))
            });
            stage.unwrap();
        }
        assert_eq!(runs, 2);
    }

    #[test]
    fn a_key_is_that_of_all_that_went_in_in_any_order() {
        let key = |text: &str| key_of("s", &serde_json::from_str(text).unwrap());
        let own = key(r#"{"a": 1, "b": {"c": [1.5, "x"], "d": null}}"#);
        assert_eq!(own, key(r#"{"b": {"d": null, "c": [1.5, "x"]}, "a": 1}"#));
        for other in [
            r#"{"a": 2, "b": {"c": [1.5, "x"], "d": null}}"#,
            r#"{"a": 1, "b": {"c": [1.25, "x"], "d": null}}"#,
            r#"{"a": 1, "b": {"c": [1.5, "y"], "d": null}}"#,
            r#"{"a": 1, "b": {"c": [1.5, "x"], "d": 0}}"#,
            r#"{"a": 1, "b": {"c": [1.5, "x"]}}"#,
        ] {
            assert_ne!(own, key(other), "{other}");
        }
        assert_ne!(own, key_of("t", &json!({"a": 1, "b": {"c": [1.5, "x"], "d": null}})));
    }

    #[test]
    fn looking_finds_what_is_there_under_the_same_key_and_makes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path().join("cache"));
        let look = || {
            let run = |_: &Path| panic!("a look runs nothing");
            cache.looking().stage("s", &json!({}), run).unwrap()
        };
        let before = look();
        assert!(!before.cached && !folder.path().join("cache").exists());
        let made = cache.stage("s", &json!({}), |_| Ok(json!({"n": 1})));
        let (made, after) = (made.unwrap(), look());
        assert!(after.cached && after.key == made.key && before.key == made.key);
        assert_eq!(after.record.info, json!({"n": 1}));
    }

    #[test]
    fn a_failed_stage_is_not_taken_for_finished_and_keeps_its_partial_work() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path());
        let inputs = json!({});
        let failed = cache.stage("s", &inputs, |dir| {
            fs::write(dir.join("checkpoint"), b"half").unwrap();
            Err(HapdefError::Stopped { stage: "s".into() })
        });
        assert!(failed.is_err());
        let done = cache
            .stage("s", &inputs, |dir| {
                assert_eq!(fs::read(dir.join("checkpoint")).unwrap(), b"half");
                Ok(json!({"ok": true}))
            })
            .unwrap();
        assert!(!done.cached && done.dir.join("checkpoint").exists());
    }
}
