//! Metrics for machines to read.
//!
//! Each prints as `METRIC:name:value:unit`, or `METRIC:name:skipped:reason` where it could not
//! be measured, and joins a JSON array of records on disk.

use std::io::Write;
use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

use hapdef_mesh::atomic_write;
use serde::{Deserialize, Serialize};

use crate::argument::ArgumentError;
use crate::error::ReportError;

/// What every record carries besides its own.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MetricContext {
    /// Commit of the code that measured.
    pub commit: String,
    /// The machine, in words.
    pub machine: String,
    /// Seed of the run.
    pub seed: u64,
    /// When, as RFC 3339.
    pub time: String,
}

impl MetricContext {
    /// Commit of the tree that this runs in, this machine, now.
    #[must_use]
    pub fn here(seed: u64) -> Self {
        let commit = output("git", &["rev-parse", "--short", "HEAD"]);
        Self {
            commit: commit.unwrap_or_else(|| "unknown".into()),
            machine: machine(),
            seed,
            time: now(),
        }
    }
}

/// What came out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", untagged)]
pub enum MetricOutcome {
    /// A finite number and its unit; "1" for none.
    Value {
        /// The number.
        value: f64,
        /// Its unit.
        unit: String,
    },
    /// It could not be measured.
    Skipped {
        /// Why.
        skipped: String,
    },
}

/// One metric, as stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MetricRecord {
    /// Dotted name, such as `demo.wall_s`.
    pub name: String,
    /// What came out.
    #[serde(flatten)]
    pub outcome: MetricOutcome,
    /// By what and when.
    #[serde(flatten)]
    pub context: MetricContext,
}

/// Prints metrics as they come and keeps them for the file.
#[derive(Debug)]
pub struct MetricLog<W> {
    out: W,
    context: MetricContext,
    suffix: String,
    records: Vec<MetricRecord>,
}

impl<W: Write> MetricLog<W> {
    /// A log that prints to `out`.
    pub fn new(out: W, context: MetricContext) -> Self {
        Self { out, context, suffix: String::new(), records: Vec::new() }
    }

    /// The same with `suffix` at the end of every name: figures of the same kind of something else.
    #[must_use]
    pub fn with_suffix(self, suffix: &str) -> Self {
        Self { suffix: suffix.to_owned(), ..self }
    }

    /// Prints and keeps a number; the unit is "1" for a bare number.
    ///
    /// # Errors
    /// A value that is not finite, a bad name or unit, or `out` failing.
    pub fn value(&mut self, name: &str, value: f64, unit: &str) -> Result<(), ReportError> {
        if !value.is_finite() {
            let index = self.records.len();
            return Err(ReportError::NotFinite { what: "metric", index, value });
        }
        let plain = |c: char| c.is_alphanumeric() || "_/%·²³µ".contains(c);
        if unit.is_empty() || !unit.chars().all(plain) {
            let expected = "a unit is letters, digits, _ / % and · ² ³, and not empty";
            return Err(
                ArgumentError::Name { what: "unit", name: unit.to_owned(), expected }.into()
            );
        }
        let unit = unit.to_owned();
        self.push(name, MetricOutcome::Value { value, unit })
    }

    /// Prints and keeps that a metric could not be measured.
    ///
    /// # Errors
    /// A bad name, a reason that is empty or has a line break, or `out` failing.
    pub fn skipped(&mut self, name: &str, reason: &str) -> Result<(), ReportError> {
        if reason.trim().is_empty() || reason.chars().any(char::is_control) {
            let expected = "a reason is one line and not empty";
            return Err(
                ArgumentError::Name { what: "reason", name: reason.to_owned(), expected }.into()
            );
        }
        self.push(name, MetricOutcome::Skipped { skipped: reason.to_owned() })
    }

    /// What was kept so far, in order.
    #[must_use]
    pub fn records(&self) -> &[MetricRecord] {
        &self.records
    }

    /// Adds what was kept to the JSON array in `path`, making file and folder when absent.
    ///
    /// The file is replaced as a whole; programs that append at the same time wait for each other, by a lock on
    /// the file of the same name with the ending `lock`.
    ///
    /// # Errors
    /// A file that can't be read or written, or that holds no array of metric records; it is
    /// left as it is then.
    pub fn append_to(&self, path: &Path) -> Result<(), ReportError> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(ReportError::io("making folder", folder))?;
        }
        // Two programs that read the same array would each write it without the other's figures.
        let lock = path.with_extension("lock");
        let held = std::fs::File::create(&lock).and_then(|file| file.lock().map(|()| file));
        let _held = held.map_err(ReportError::io("locking", &lock))?;
        let mut all: Vec<MetricRecord> = match std::fs::read(path) {
            Ok(bytes) => serde_json::from_slice(&bytes).map_err(ReportError::json(path))?,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(source) => return Err(ReportError::io("reading", path)(source)),
        };
        all.extend_from_slice(&self.records);
        let json = serde_json::to_vec_pretty(&all).map_err(ReportError::json(path))?;
        atomic_write(path, |file| file.write_all(&json)).map_err(ReportError::io("writing", path))
    }

    fn push(&mut self, name: &str, outcome: MetricOutcome) -> Result<(), ReportError> {
        let name = format!("{name}{}", self.suffix);
        let plain = |c: char| c.is_ascii_alphanumeric() || "_.".contains(c);
        if name == self.suffix || !name.chars().all(plain) {
            let expected = "a metric's name is letters, digits, _ and ., and not empty";
            return Err(ArgumentError::Name { what: "metric", name, expected }.into());
        }
        let context = self.context.clone();
        let record = MetricRecord { name, outcome, context };
        writeln!(self.out, "{}", record.line())
            .map_err(ReportError::io("printing metrics to", Path::new("standard output")))?;
        self.records.push(record);
        Ok(())
    }
}

impl MetricRecord {
    /// `METRIC:name:value:unit` or `METRIC:name:skipped:reason`.
    #[must_use]
    pub fn line(&self) -> String {
        match &self.outcome {
            MetricOutcome::Value { value, unit } => format!("METRIC:{}:{value}:{unit}", self.name),
            MetricOutcome::Skipped { skipped } => format!("METRIC:{}:skipped:{skipped}", self.name),
        }
    }
}

/// Seconds since 1970 as RFC 3339 in UTC, by the date program; plain seconds without it.
fn now() -> String {
    output("date", &["-u", "+%Y-%m-%dT%H:%M:%SZ"]).unwrap_or_else(|| {
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        format!("{} s since 1970", since.map_or(0, |d| d.as_secs()))
    })
}

fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let name = name.map_or("unknown processor", |(_, name)| name.trim());
    format!("{name}, {cores} cores, {}", std::env::consts::OS)
}

/// Most memory the process has held so far, GiB; none where the system does not tell.
#[must_use]
pub fn peak_rss_gib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kib / f64::from(1 << 20))
}

fn output(program: &str, words: &[&str]) -> Option<String> {
    let output = Command::new(program).args(words).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn context() -> MetricContext {
        MetricContext {
            commit: "abc1234".to_owned(),
            machine: "two cores".to_owned(),
            seed: 7,
            time: "2026-01-02T03:04:05Z".to_owned(),
        }
    }

    #[test]
    fn prints_and_appends() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/metrics.json");
        let mut out = Vec::new();
        for round in 0..2 {
            let mut log = MetricLog::new(&mut out, context());
            log.value("demo.wall_s", 12.5 + f64::from(round), "s").unwrap();
            log.skipped("fe.factor_vs_cholmod", "no CHOLMOD: not installed").unwrap();
            log.append_to(&path).unwrap();
        }
        let text = String::from_utf8(out).unwrap();
        assert_eq!(
            text.lines().take(2).collect::<Vec<_>>(),
            [
                "METRIC:demo.wall_s:12.5:s",
                "METRIC:fe.factor_vs_cholmod:skipped:no CHOLMOD: not installed"
            ]
        );
        let all: Vec<MetricRecord> =
            serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        assert_eq!(all.len(), 4);
        assert_eq!(all[2].line(), "METRIC:demo.wall_s:13.5:s");
        assert_eq!((all[3].context.clone(), all[3].line().contains("skipped")), (context(), true));
    }

    #[test]
    fn what_is_appended_at_the_same_time_is_all_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.json");
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..25 {
                        let mut log = MetricLog::new(Vec::new(), context());
                        log.value("demo.wall_s", 1.0, "s").unwrap();
                        log.append_to(&path).unwrap();
                    }
                });
            }
        });
        let all: Vec<MetricRecord> =
            serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        assert_eq!(all.len(), 100);
    }

    #[test]
    fn a_suffix_is_at_the_end_of_every_name() {
        let mut lines = Vec::new();
        let mut log = MetricLog::new(&mut lines, context()).with_suffix("_paper");
        log.value("demo.wall_s", 1.0, "s").unwrap();
        log.skipped("demo.size_mm", "no limb").unwrap();
        let names = log.records().iter().map(|record| record.name.as_str());
        assert_eq!(names.collect::<Vec<_>>(), ["demo.wall_s_paper", "demo.size_mm_paper"]);
        let lines = String::from_utf8(lines).unwrap();
        assert!(lines.starts_with("METRIC:demo.wall_s_paper:1:s\n"), "{lines}");
    }

    #[test]
    fn what_a_reader_could_not_parse_is_refused() {
        let mut log = MetricLog::new(Vec::new(), context());
        assert!(matches!(log.value("a", f64::NAN, "s"), Err(ReportError::NotFinite { .. })));
        assert!(matches!(
            log.value("a:b", 1.0, "s"),
            Err(ReportError::Argument(ArgumentError::Name { .. }))
        ));
        assert!(matches!(
            log.value("a", 1.0, "m:s"),
            Err(ReportError::Argument(ArgumentError::Name { .. }))
        ));
        assert!(matches!(
            log.skipped("a", "two\nlines"),
            Err(ReportError::Argument(ArgumentError::Name { .. }))
        ));
        assert!(log.records().is_empty());
    }

    #[test]
    fn a_foreign_file_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.json");
        std::fs::write(&path, "{\"mine\": 1}").unwrap();
        let mut log = MetricLog::new(Vec::new(), context());
        log.value("a.b", 1.0, "1").unwrap();
        let error = log.append_to(&path).unwrap_err();
        assert!(matches!(error, ReportError::Json { .. }), "{error}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "{\"mine\": 1}");
    }
}
