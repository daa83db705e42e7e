//! What the figures of the comparison should be.

use anyhow::Result;
use hapdef_report::ReportTable;

use super::run::{Measured, double_vs_paper, time_vs_paper};
use super::score::Row;
use crate::target::{Target, Wanted, target_table};

/// A figure of a row.
type OfRow = (&'static str, &'static str, Wanted, fn(&Row) -> f64);

const OF_ROWS: [OfRow; 24] = [
    (
        "single",
        "one contact, mean, mm",
        Wanted::AtMost(0.3),
        |r| r.mean_mm,
    ),
    (
        "single",
        "one contact, median, mm",
        Wanted::AtMost(0.15),
        |r| r.median_mm,
    ),
    (
        "single",
        "one contact, mean, N",
        Wanted::AtMost(0.35),
        |r| r.mean_n,
    ),
    (
        "single",
        "one contact, count right, %",
        Wanted::AtLeast(99.0),
        |r| r.count_pct,
    ),
    ("double", "two, mean, mm", Wanted::AtMost(2.0), |r| {
        r.mean_mm
    }),
    ("double", "two, median, mm", Wanted::AtMost(0.3), |r| {
        r.median_mm
    }),
    ("double", "two, mean, N", Wanted::AtMost(1.0), |r| r.mean_n),
    (
        "double",
        "two, within 10 mm, %",
        Wanted::AtLeast(96.0),
        |r| r.within10_pct,
    ),
    (
        "double",
        "two, count right, %",
        Wanted::AtLeast(94.0),
        |r| r.count_pct,
    ),
    (
        FEW_SINGLE,
        "one contact, 300 presses, mean, mm",
        Wanted::AtMost(0.5),
        |r| r.mean_mm,
    ),
    (
        FEW_DOUBLE,
        "two, 300 presses, mean, mm",
        Wanted::AtMost(3.0),
        |r| r.mean_mm,
    ),
    (
        FEW_DOUBLE,
        "two, 300 presses, median, mm",
        Wanted::AtMost(0.6),
        |r| r.median_mm,
    ),
    (
        ARRIVING,
        "four arriving, mean, mm",
        Wanted::AtMost(0.7),
        |r| r.mean_mm,
    ),
    (
        ARRIVING,
        "four arriving, mean, N",
        Wanted::AtMost(0.6),
        |r| r.mean_n,
    ),
    (
        ARRIVING,
        "four arriving, found, %",
        Wanted::AtLeast(99.0),
        |r| r.within10_pct,
    ),
    (
        ARRIVING,
        "four arriving, count right, %",
        Wanted::AtLeast(97.0),
        |r| r.count_pct,
    ),
    (
        TRIPLE,
        "three, 16 gauges, mean, mm",
        Wanted::AtMost(1.5),
        |r| r.mean_mm,
    ),
    (
        TRIPLE,
        "three, 16 gauges, frames clean, %",
        Wanted::AtLeast(95.0),
        |r| r.clean_pct,
    ),
    (
        ROUGH,
        "two, friction and 8 mm tip, mean, mm",
        Wanted::AtMost(3.0),
        |r| r.mean_mm,
    ),
    (
        ROUGH,
        "two, friction and 8 mm tip, frames clean, %",
        Wanted::AtLeast(95.0),
        |r| r.clean_pct,
    ),
    (MANY, "one contact, in 95 % regions, %", HONEST, coverage),
    ("double", "two, in 95 % regions, %", HONEST, coverage),
    (
        FEW_SINGLE,
        "one contact, 300 presses, in 95 % regions, %",
        HONEST,
        coverage,
    ),
    (
        FEW_DOUBLE,
        "two, 300 presses, in 95 % regions, %",
        HONEST,
        coverage,
    ),
];

const FEW_SINGLE: &str = "single, 300 presses";
const FEW_DOUBLE: &str = "double, 300 presses";
const ARRIVING: &str = "four arriving";
const TRIPLE: &str = "triple, 16 gauges";
const ROUGH: &str = "double, friction and wide tip";
const MANY: &str = "single, many frames";
const HONEST: Wanted = Wanted::Between(92.0, 98.0);

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
    target_table(&targets, note)
}

fn coverage(row: &Row) -> f64 {
    row.coverage95_pct.unwrap_or(f64::NAN)
}
