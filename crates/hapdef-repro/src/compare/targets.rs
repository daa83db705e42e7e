//! What the figures of the comparison should be.

use anyhow::Result;
use hapdef_report::ReportTable;

use super::run::{Measured, double_vs_paper, time_vs_paper};
use super::score::Row;
use hapdef_bench::{Target, Wanted, target_table};

/// A figure of a row.
type OfRow = (&'static str, &'static str, Wanted, fn(&Row) -> f64);

const OF_ROWS: [OfRow; 24] = [
    at_most("single", "one contact, mean, mm", 0.3, |r| r.mean_mm),
    at_most("single", "one contact, median, mm", 0.15, |r| r.median_mm),
    at_most("single", "one contact, mean, N", 0.35, |r| r.mean_n),
    at_least("single", "one contact, count right, %", 99.0, |r| r.count_pct),
    at_most("double", "two, mean, mm", 2.0, |r| r.mean_mm),
    at_most("double", "two, median, mm", 0.3, |r| r.median_mm),
    at_most("double", "two, mean, N", 1.0, |r| r.mean_n),
    at_least("double", "two, within 10 mm, %", 96.0, |r| r.within10_pct),
    at_least("double", "two, count right, %", 94.0, |r| r.count_pct),
    at_most(FEW_SINGLE, "one, 300 presses, mean, mm", 0.5, |r| r.mean_mm),
    at_most(FEW_DOUBLE, "two, 300 presses, mean, mm", 3.0, |r| r.mean_mm),
    at_most(FEW_DOUBLE, "two, 300 presses, median, mm", 0.6, |r| r.median_mm),
    at_most(ARRIVING, "four arriving, mean, mm", 0.7, |r| r.mean_mm),
    at_most(ARRIVING, "four arriving, mean, N", 0.6, |r| r.mean_n),
    at_least(ARRIVING, "four arriving, found, %", 99.0, |r| r.within10_pct),
    at_least(ARRIVING, "four arriving, count right, %", 97.0, |r| r.count_pct),
    at_most(TRIPLE, "three, 16 gauges, mean, mm", 1.5, |r| r.mean_mm),
    at_least(TRIPLE, "three, 16 gauges, clean, %", 95.0, |r| r.clean_pct),
    at_most(ROUGH, "two, friction and 8 mm tip, mean, mm", 3.0, |r| r.mean_mm),
    at_least(ROUGH, "two, friction and 8 mm tip, clean, %", 95.0, |r| r.clean_pct),
    honest(MANY, "one contact, in 95 % regions, %"),
    honest("double", "two, in 95 % regions, %"),
    honest(FEW_SINGLE, "one, 300 presses, in 95 % regions, %"),
    honest(FEW_DOUBLE, "two, 300 presses, in 95 % regions, %"),
];

const FEW_SINGLE: &str = "single, 300 presses";
const FEW_DOUBLE: &str = "double, 300 presses";
const ARRIVING: &str = "four arriving";
const TRIPLE: &str = "triple, 16 gauges";
const ROUGH: &str = "double, friction and wide tip";
const MANY: &str = "single, many frames";

/// The figures beside what they should be.
pub(super) fn table(measured: &Measured) -> Result<ReportTable> {
    let of_rows = OF_ROWS.iter().map(|&(row, what, wanted, of)| Target {
        what,
        wanted,
        measured: measured.row(row).map(of).filter(|v| v.is_finite()),
    });
    let mut targets: Vec<Target> = of_rows.collect();
    targets.extend([
        Target {
            what: "error over the noise's bound, where that exceeds the map's error",
            wanted: Wanted::AtMost(1.5),
            measured: measured.bound_ratio,
        },
        Target {
            what: "two: the paper's mean error over superposition's",
            wanted: Wanted::AtLeast(8.0),
            measured: double_vs_paper(measured),
        },
        Target {
            what: "the paper's time of a frame over that of a followed one",
            wanted: Wanted::AtLeast(100.0),
            measured: time_vs_paper(measured),
        },
    ]);
    let note = "Found: matched within 10 mm. Clean: every contact within 10 mm of a true one, and none else. \
                Asked of a map calibrated with 3,000 presses where no number is said, ten gauges, 1 µε.";
    Ok(target_table(&targets, note)?)
}

const fn at_most(row: &'static str, what: &'static str, most: f64, of: fn(&Row) -> f64) -> OfRow {
    (row, what, Wanted::AtMost(most), of)
}

const fn at_least(row: &'static str, what: &'static str, least: f64, of: fn(&Row) -> f64) -> OfRow {
    (row, what, Wanted::AtLeast(least), of)
}

const fn honest(row: &'static str, what: &'static str) -> OfRow {
    (row, what, Wanted::Between(92.0, 98.0), coverage)
}

fn coverage(row: &Row) -> f64 {
    row.coverage95_pct.unwrap_or(f64::NAN)
}
