//! What is taken from the measurements of a study: METRIC lines, targets, the page.

use std::io::Write;
use std::path::Path;

use hapdef_report::{MetricLog, Report, ReportError, ReportTable, write_report};

use crate::target::{Target, Wanted, target_table};

/// What a study measured, in rows that have names.
pub trait Measurements {
    /// What was measured of one case.
    type Row;

    /// The row of a case, if it was measured.
    fn row(&self, name: &str) -> Option<&Self::Row>;
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
    /// Its name, behind the study's prefix.
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

/// Prints a METRIC line for each figure, its name behind `prefix` and a point.
///
/// # Errors
/// A name, unit or reason that is refused, or standard output failing.
pub fn log_metrics<M: Measurements, W: Write>(
    metrics: &[Metric<M>],
    prefix: &str,
    measured: &M,
    log: &mut MetricLog<W>,
) -> Result<(), ReportError> {
    for metric in metrics {
        let name = format!("{prefix}.{}", metric.name);
        match metric.figure.of(measured) {
            Some(value) => log.value(&name, value, metric.unit)?,
            None => log.skipped(&name, metric.absent)?,
        }
    }
    Ok(())
}

/// The figures beside what they should be.
///
/// # Errors
/// As [`target_table`].
pub fn goal_table<M: Measurements>(
    goals: &[Goal<M>],
    measured: &M,
    note: &str,
) -> Result<ReportTable, serde_json::Error> {
    let target = |goal: &Goal<M>| Target {
        what: goal.what,
        wanted: goal.wanted,
        measured: goal.figure.of(measured),
    };
    target_table(&goals.iter().map(target).collect::<Vec<_>>(), note)
}

/// Writes the report with the metrics of `log` into the folder `name` of its scene's under `out`, adds
/// the metrics to `metrics.json` there and prints the paths of the pages.
///
/// # Errors
/// A report that is refused, and files that can't be written.
#[expect(clippy::print_stdout, reason = "whoever made a study looks for its page")]
pub fn publish<W: Write>(
    out: &Path,
    name: &str,
    report: Report,
    log: &MetricLog<W>,
) -> Result<Report, ReportError> {
    let report = Report { metrics: log.records().to_vec(), ..report };
    let paths = write_report(&out.join(&report.scene).join(name), &report)?;
    log.append_to(&out.join("metrics.json"))?;
    for path in paths.iter().rev().take(3) {
        println!("{}", path.display());
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use hapdef_report::MetricContext;

    use super::*;

    struct Timed(Vec<(&'static str, f64)>);

    impl Measurements for Timed {
        type Row = (&'static str, f64);

        fn row(&self, name: &str) -> Option<&Self::Row> {
            self.0.iter().find(|row| row.0 == name)
        }
    }

    #[test]
    fn figures_that_are_not_there_are_skipped_and_their_goals_not_measured() {
        let figure = |row| Figure::Row(row, |r: &(&'static str, f64)| r.1);
        let metric =
            |name, row| Metric { name, unit: "µs", figure: figure(row), absent: "no row" };
        let context = MetricContext {
            commit: "abc".into(),
            machine: "one".into(),
            seed: 1,
            time: "now".into(),
        };
        let measured = Timed(vec![("fast", 2.0), ("broken", f64::NAN)]);
        let metrics = [metric("fast_us", "fast"), metric("slow_us", "slow")];
        let mut out = Vec::new();
        log_metrics(&metrics, "demo", &measured, &mut MetricLog::new(&mut out, context)).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, "METRIC:demo.fast_us:2:µs\nMETRIC:demo.slow_us:skipped:no row\n");
        let goal =
            |row| Goal { what: "time, µs", wanted: Wanted::AtMost(3.0), figure: figure(row) };
        let table = goal_table(&[goal("fast"), goal("broken")], &measured, "").unwrap();
        let verdicts = table.text.rows.iter().map(|row| row[3].text.as_str());
        assert_eq!(verdicts.collect::<Vec<_>>(), ["met", "not measured"]);
    }
}
