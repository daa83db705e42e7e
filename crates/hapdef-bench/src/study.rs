//! What is taken from the measurements of a study: METRIC lines, targets, the page.

use std::io::Write;
use std::path::Path;

use hapdef_report::{MetricLog, Report, ReportError, ReportTable, write_report, write_text};
use serde::Serialize;

use crate::summary::summary;
use crate::table::{page_table, terminal_table};
use crate::target::{Target, Wanted, target_table};

/// What was measured of a case, under the case's name.
pub trait Named {
    /// The name.
    fn name(&self) -> &str;
}

/// What a study measured: a row for each case, and what belongs to no row.
pub trait Measurements {
    /// What was measured of one case.
    type Row: Named;

    /// The rows, in their order.
    fn rows(&self) -> &[Self::Row];

    /// The row of a case, if it was measured.
    fn row(&self, name: &str) -> Option<&Self::Row> {
        self.rows().iter().find(|row| row.name() == name)
    }
}

impl<R: Named> Measurements for Vec<R> {
    type Row = R;

    fn rows(&self) -> &[R] {
        self
    }
}

/// What is taken from the measurements of a study, and where it goes.
pub struct Study<M: Measurements + 'static> {
    /// Folder of its page, below the scene's.
    pub folder: &'static str,
    /// METRIC lines.
    pub metrics: &'static [Metric<M>],
    /// What figures should be.
    pub goals: &'static [Goal<M>],
    /// What is to be known of those.
    pub goals_note: &'static str,
    /// A file beside the page with the measurements as JSON, if they are to be there.
    pub file: Option<&'static str>,
}

/// Where a figure comes from.
pub enum Figure<M: Measurements> {
    /// From the row of this name.
    Row(&'static str, fn(&M::Row) -> f64),
    /// From all measurements.
    All(fn(&M) -> Option<f64>),
}

/// A figure that is printed as METRIC line.
pub struct Metric<M: Measurements> {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Where it comes from.
    pub figure: Figure<M>,
    /// Why it is not there, where it is not.
    pub absent: &'static str,
}

/// A figure that should be something.
pub struct Goal<M: Measurements> {
    /// The figure in words, with its unit.
    pub what: &'static str,
    /// What it should be.
    pub wanted: Wanted,
    /// Where it comes from.
    pub figure: Figure<M>,
}

impl<M: Measurements> Figure<M> {
    /// The figure, if it was measured and is finite.
    pub fn of(&self, measured: &M) -> Option<f64> {
        let value = match self {
            Self::Row(name, of) => measured.row(name).map(of),
            Self::All(of) => of(measured),
        };
        value.filter(|value| value.is_finite())
    }
}

impl<M: Measurements> Metric<M> {
    /// A figure of the row of a case.
    pub const fn row(
        name: &'static str,
        unit: &'static str,
        row: &'static str,
        of: fn(&M::Row) -> f64,
    ) -> Self {
        Self { name, unit, figure: Figure::Row(row, of), absent: "no such row" }
    }

    /// A figure of all measurements; `absent`: why it is not there, where it is not.
    pub const fn all(
        name: &'static str,
        unit: &'static str,
        of: fn(&M) -> Option<f64>,
        absent: &'static str,
    ) -> Self {
        Self { name, unit, figure: Figure::All(of), absent }
    }

    /// Prints its METRIC line.
    ///
    /// # Errors
    /// Standard output failing.
    pub fn log<W: Write>(&self, measured: &M, log: &mut MetricLog<W>) -> Result<(), ReportError> {
        match self.figure.of(measured) {
            Some(value) => log.value(self.name, value, self.unit),
            None => log.skipped(self.name, self.absent),
        }
    }
}

impl<M: Measurements + Serialize> Study<M> {
    /// Prints a METRIC line for each figure, and every table; writes the page into the study's folder of
    /// the report's scene under `out`, adds the metrics to `metrics.json` there, and prints the paths.
    ///
    /// # Errors
    /// A figure or a report that is refused, and files that can't be written.
    #[expect(
        clippy::print_stdout,
        reason = "whoever made a study looks for its figures and its page"
    )]
    pub fn publish<W: Write>(
        &self,
        measured: &M,
        mut report: Report,
        log: &mut MetricLog<W>,
        out: &Path,
    ) -> Result<Report, ReportError> {
        for metric in self.metrics {
            metric.log(measured, log)?;
        }
        let folder = out.join(&report.scene).join(self.folder);
        for table in &report.tables {
            println!("{}\n{}", table.title, terminal_table(&table.text));
        }
        report.metrics = log.records().to_vec();
        if report.summary.is_none() {
            let picture = report.figures.first().cloned();
            report.summary = summary(&self.targets(measured), picture);
            // it stands on top, not a second time below
            let is_on_top = report.summary.as_ref().is_some_and(|top| top.picture.is_some());
            report.figures.drain(..usize::from(is_on_top));
        }
        let mut paths = write_report(&folder, &report)?;
        log.append_to(&out.join("metrics.json"))?;
        if let Some(file) = self.file {
            let path = folder.join(file);
            let json = serde_json::to_string_pretty(measured).map_err(ReportError::json(&path))?;
            write_text(&path, &json)?;
            paths.insert(0, path);
        }
        for path in paths.iter().rev().take(3) {
            println!("{}", path.display());
        }
        Ok(report)
    }

    /// The figures beside what they should be.
    ///
    /// # Errors
    /// A figure that JSON can't hold.
    pub fn goal_table(&self, measured: &M) -> Result<ReportTable, ReportError> {
        let targets = self.targets(measured);
        page_table("What was asked for", self.goals_note, target_table(&targets), &targets)
    }

    fn targets(&self, measured: &M) -> Vec<Target> {
        let target = |goal: &Goal<M>| Target {
            what: goal.what,
            wanted: goal.wanted,
            measured: goal.figure.of(measured),
        };
        self.goals.iter().map(target).collect()
    }
}

#[cfg(test)]
mod tests {
    use hapdef_report::{MetricContext, NamedText};

    use super::*;

    #[derive(Serialize)]
    struct Timed(&'static str, f64);

    impl Named for Timed {
        fn name(&self) -> &str {
            self.0
        }
    }

    const fn time(row: &'static str) -> Figure<Vec<Timed>> {
        Figure::Row(row, |timed: &Timed| timed.1)
    }

    const fn metric(name: &'static str, row: &'static str) -> Metric<Vec<Timed>> {
        Metric { name, unit: "µs", figure: time(row), absent: "no row" }
    }

    const fn goal(row: &'static str) -> Goal<Vec<Timed>> {
        Goal { what: "time, µs", wanted: Wanted::AtMost(3.0), figure: time(row) }
    }

    const STUDY: Study<Vec<Timed>> = Study {
        folder: "times",
        metrics: &[metric("demo.fast_us", "fast"), metric("demo.slow_us", "slow")],
        goals: &[goal("fast"), goal("broken")],
        goals_note: "",
        file: Some("times.json"),
    };

    #[test]
    fn figures_that_are_not_there_are_skipped_and_their_goals_not_measured() {
        let context = MetricContext {
            commit: "abc".into(),
            machine: "one".into(),
            seed: 1,
            time: "now".into(),
        };
        let measured = vec![Timed("fast", 2.0), Timed("broken", f64::NAN)];
        let goals = STUDY.goal_table(&measured).unwrap();
        let verdicts = goals.text.rows.iter().map(|row| row[3].text.as_str());
        assert_eq!(verdicts.collect::<Vec<_>>(), ["met", "not measured"]);
        let out = tempfile::tempdir().unwrap();
        let report = Report {
            scene: "limb".into(),
            hashes: vec![NamedText { name: "scene".into(), text: "0".into() }],
            tables: vec![goals],
            ..Report::default()
        };
        let mut lines = Vec::new();
        let log = &mut MetricLog::new(&mut lines, context);
        STUDY.publish(&measured, report, log, out.path()).unwrap();
        let lines = String::from_utf8(lines).unwrap();
        assert_eq!(lines, "METRIC:demo.fast_us:2:µs\nMETRIC:demo.slow_us:skipped:no row\n");
        let json = std::fs::read_to_string(out.path().join("limb/times/times.json")).unwrap();
        assert!(json.contains("fast"), "{json}");
        let page = std::fs::read_to_string(out.path().join("limb/times/report.html")).unwrap();
        assert!(page.contains("1 of 1 figures are what was asked for."), "{page}");
    }
}
