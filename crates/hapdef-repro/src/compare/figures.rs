//! The table, the METRIC lines and the targets of the comparison.

use hapdef_bench::stats::{mean, quantile};
use hapdef_bench::{Column, Figure, Goal, Measurements, Metric, Wanted, or_dash};
use serde::Serialize;

use super::palm::Palms;
use super::score::Row;

const FEW_SINGLE: &str = "single, 300 presses";
const FEW_DOUBLE: &str = "double, 300 presses";
const ARRIVING: &str = "four arriving";
const TRIPLE: &str = "triple, 16 gauges";
const ROUGH: &str = "double, friction and wide tip";
const MANY: &str = "single, many frames";

/// Everything that was measured.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Measured {
    pub(super) rows: Vec<Row>,
    pub(super) palms: Option<Palms>,
    pub(super) bound_ratio: Option<f64>,
    /// Relative errors of the maps at presses they were not calibrated with: with all presses,
    /// 300, and none.
    pub(super) map_errors: [f64; 3],
    /// Times of all frames of contacts that arrive one after another, µs, rising.
    pub(super) tracking_us: Vec<f64>,
}

impl Measurements for Measured {
    type Row = Row;

    fn rows(&self) -> &[Row] {
        &self.rows
    }
}

/// The columns of the table of rows.
pub(super) const COLUMNS: [Column<Row>; 15] = [
    Column::new("frames of", |r| r.name.clone()),
    Column::new("n", |r| r.errors.n_frames.to_string()),
    Column::new("mean, mm", |r| format!("{:.2}", r.errors.mean_mm)),
    Column::new("median", |r| format!("{:.2}", r.errors.median_mm)),
    Column::new("90 %", |r| format!("{:.2}", r.errors.p90_mm)),
    Column::new("within 10 mm", |r| percent(r.errors.within10_pct)),
    Column::new("mean, N", |r| format!("{:.2}", r.errors.mean_n)),
    Column::new("missed", |r| percent(r.errors.missed_pct)),
    Column::new("spurious", |r| percent(r.errors.spurious_pct)),
    Column::new("count right", |r| percent(r.errors.count_pct)),
    Column::new("clean", |r| percent(r.errors.clean_pct)),
    Column::new("unsure", |r| percent(r.unsure_pct)),
    Column::new("in 95 %", |r| or_dash(r.coverage95_pct.map(percent))),
    Column::new("p50, µs", |r| format!("{:.0}", r.p50_us)),
    Column::new("p99, µs", |r| format!("{:.0}", r.p99_us)),
];

/// What is printed as METRIC lines.
pub(super) const METRICS: [Metric<Measured>; 22] = [
    Metric::row("compare.single_mean_mm", "mm", "single", |r: &Row| r.errors.mean_mm),
    Metric::row("compare.single_median_mm", "mm", "single", |r: &Row| r.errors.median_mm),
    Metric::row("compare.single_mean_n", "N", "single", |r: &Row| r.errors.mean_n),
    Metric::row("compare.double_mean_mm", "mm", "double", |r: &Row| r.errors.mean_mm),
    Metric::row("compare.double_median_mm", "mm", "double", |r: &Row| r.errors.median_mm),
    Metric::row("compare.double_mean_n", "N", "double", |r: &Row| r.errors.mean_n),
    Metric::row("compare.double_within10_pct", "%", "double", |r: &Row| r.errors.within10_pct),
    Metric::row("compare.double_count_pct", "%", "double", |r: &Row| r.errors.count_pct),
    Metric::row("compare.double300_mean_mm", "mm", FEW_DOUBLE, |r: &Row| r.errors.mean_mm),
    Metric::row("compare.friction_double_mean_mm", "mm", ROUGH, |r: &Row| r.errors.mean_mm),
    Metric::row("compare.triple16_mean_mm", "mm", TRIPLE, |r: &Row| r.errors.mean_mm),
    Metric::row("compare.sequential4_mean_mm", "mm", ARRIVING, |r: &Row| r.errors.mean_mm),
    Metric::row("compare.sequential4_mean_n", "N", ARRIVING, |r: &Row| r.errors.mean_n),
    Metric::row("compare.sequential4_found_pct", "%", ARRIVING, |r: &Row| r.errors.within10_pct),
    Metric::row(
        "compare.pair_beside_two_clean_pct",
        "%",
        "four arriving, two at once",
        |r: &Row| r.errors.clean_pct,
    ),
    Metric {
        absent: "no frame was sure",
        ..Metric::row("compare.coverage95_pct", "%", MANY, coverage95_pct)
    },
    Metric::all(
        "compare.bound_ratio",
        "1",
        |m| m.bound_ratio,
        "at no contact does the noise's bound exceed the map's error",
    ),
    Metric::all("compare.palm_clean_pct", "%", palm_clean_pct, "not measured"),
    Metric::all(
        "compare.palm_by_narrow_clean_pct",
        "%",
        |m| m.palms.as_ref().map(|palms| palms.narrow_clean_pct),
        "not measured",
    ),
    Metric::all(
        "compare.palm_radius_error_mm",
        "mm",
        |m| m.palms.as_ref().map(|palms| palms.radius_error_mm),
        "not measured",
    ),
    Metric::all("compare.double_vs_paper", "1", double_vs_paper, "--without-paper"),
    Metric::all("compare.time_vs_paper", "1", time_vs_paper, "--without-paper"),
];

/// What the figures should be.
pub(super) const GOALS: [Goal<Measured>; 28] = [
    at_most("single", "one contact, mean, mm", 0.3, |r| r.errors.mean_mm),
    at_most("single", "one contact, median, mm", 0.15, |r| r.errors.median_mm),
    at_most("single", "one contact, mean, N", 0.35, |r| r.errors.mean_n),
    at_least("single", "one contact, count right, %", 99.0, |r| r.errors.count_pct),
    at_most("double", "two, mean, mm", 2.0, |r| r.errors.mean_mm),
    at_most("double", "two, median, mm", 0.3, |r| r.errors.median_mm),
    at_most("double", "two, mean, N", 1.0, |r| r.errors.mean_n),
    at_least("double", "two, within 10 mm, %", 96.0, |r| r.errors.within10_pct),
    at_least("double", "two, count right, %", 94.0, |r| r.errors.count_pct),
    at_most(FEW_SINGLE, "one, 300 presses, mean, mm", 0.5, |r| r.errors.mean_mm),
    at_most(FEW_DOUBLE, "two, 300 presses, mean, mm", 3.0, |r| r.errors.mean_mm),
    at_most(FEW_DOUBLE, "two, 300 presses, median, mm", 0.6, |r| r.errors.median_mm),
    at_most(ARRIVING, "four arriving, mean, mm", 0.7, |r| r.errors.mean_mm),
    at_most(ARRIVING, "four arriving, mean, N", 0.6, |r| r.errors.mean_n),
    at_least(ARRIVING, "four arriving, found, %", 99.0, |r| r.errors.within10_pct),
    at_least(ARRIVING, "four arriving, count right, %", 97.0, |r| r.errors.count_pct),
    at_most(TRIPLE, "three, 16 gauges, mean, mm", 1.5, |r| r.errors.mean_mm),
    at_least(TRIPLE, "three, 16 gauges, clean, %", 95.0, |r| r.errors.clean_pct),
    at_most(ROUGH, "two, friction and 8 mm tip, mean, mm", 3.0, |r| r.errors.mean_mm),
    at_least(ROUGH, "two, friction and 8 mm tip, clean, %", 95.0, |r| r.errors.clean_pct),
    calibrated(MANY, "one contact, in 95 % regions, %"),
    calibrated("double", "two, in 95 % regions, %"),
    calibrated(FEW_SINGLE, "one, 300 presses, in 95 % regions, %"),
    calibrated(FEW_DOUBLE, "two, 300 presses, in 95 % regions, %"),
    Goal {
        what: "a palm of 20 mm radius is one contact within 3 mm and 10 % of its force, %",
        wanted: Wanted::AtLeast(95.0),
        figure: Figure::All(palm_clean_pct),
    },
    Goal {
        what: "error over the noise's bound, where that exceeds the map's error",
        wanted: Wanted::AtMost(1.5),
        figure: Figure::All(|m| m.bound_ratio),
    },
    Goal {
        what: "two: the paper's mean error over superposition's",
        wanted: Wanted::AtLeast(8.0),
        figure: Figure::All(double_vs_paper),
    },
    Goal {
        what: "the paper's time of a frame over that of a followed one",
        wanted: Wanted::AtLeast(100.0),
        figure: Figure::All(time_vs_paper),
    },
];

pub(super) const GOALS_NOTE: &str = "Found: matched within 10 mm. Clean: every contact within 10 mm of a \
    true one, and none else. Asked of a map calibrated with 3,000 presses where no number is said, ten \
    gauges, 1 µε.";

const fn at_most(
    row: &'static str,
    what: &'static str,
    most: f64,
    of: fn(&Row) -> f64,
) -> Goal<Measured> {
    Goal { what, wanted: Wanted::AtMost(most), figure: Figure::Row(row, of) }
}

const fn at_least(
    row: &'static str,
    what: &'static str,
    least: f64,
    of: fn(&Row) -> f64,
) -> Goal<Measured> {
    Goal { what, wanted: Wanted::AtLeast(least), figure: Figure::Row(row, of) }
}

const fn calibrated(row: &'static str, what: &'static str) -> Goal<Measured> {
    Goal { what, wanted: Wanted::Between(92.0, 98.0), figure: Figure::Row(row, coverage95_pct) }
}

fn coverage95_pct(row: &Row) -> f64 {
    row.coverage95_pct.unwrap_or(f64::NAN)
}

fn palm_clean_pct(measured: &Measured) -> Option<f64> {
    measured.palms.as_ref().map(|palms| palms.clean_pct)
}

/// The paper's better row on two contacts, from readings.
pub(super) fn best_paper(measured: &Measured) -> Option<&Row> {
    let is_double = |row: &&Row| row.name.starts_with("paper") && row.name.ends_with("double");
    let rows = measured.rows.iter().filter(is_double);
    rows.min_by(|a, b| a.errors.mean_mm.total_cmp(&b.errors.mean_mm))
}

/// The mean position error of the paper's pipeline with two contacts over superposition's.
fn double_vs_paper(measured: &Measured) -> Option<f64> {
    Some(best_paper(measured)?.errors.mean_mm / measured.row("double")?.errors.mean_mm)
}

/// The time of a frame of the paper's pipeline over that of a followed one.
fn time_vs_paper(measured: &Measured) -> Option<f64> {
    let rows = measured.rows.iter().filter(|r| r.name.starts_with("paper"));
    let times: Vec<f64> = rows.map(|r| r.p50_us).collect();
    let paper_us = mean(times.iter().copied());
    (!times.is_empty()).then(|| paper_us / quantile(&measured.tracking_us, 0.5))
}

fn percent(value: f64) -> String {
    format!("{value:.1} %")
}
