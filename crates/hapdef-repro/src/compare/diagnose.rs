//! `compare --diagnose`: why frames are not clean.

use anyhow::Result;
use hapdef::touch::{Causes, why_not_clean};
use hapdef_bench::{Column, Figure, Goal, Metric, Named, Study, Wanted, page_table, table};
use hapdef_report::Report;
use serde::Serialize;

use super::cases::{Case, DIAGNOSED};
use super::score::Row;
use super::setup::Bench;
use crate::run::facts;

const NOTE: &str = "Each frame that is not clean (a contact farther than 10 mm from its match, missed or \
    spurious) by its cause. The true places are refined on the same readings. Search: the readings \
    prefer the truth, and it was not found. Tie: they can't decide between both. Map: they prefer what was \
    found, by the map's error or the noise, or the true places refined end there. The limit is odds of e^½ to 1, at which an answer is said to be \
    tied.";

/// Why the frames of a row are not clean.
#[derive(Clone, Debug, Serialize)]
struct Diagnosed {
    #[serde(flatten)]
    row: Row,
    #[serde(flatten)]
    causes: Causes,
}

impl Named for Diagnosed {
    fn name(&self) -> &str {
        &self.row.name
    }
}

const STUDY: Study<Vec<Diagnosed>> = Study {
    folder: "diagnosis",
    metrics: &METRICS,
    goals: &GOALS,
    goals_note: GOALS_NOTE,
    file: None,
};

/// Names of rows that a figure or a target is of.
const QUADRUPLE: &str = "quadruple, 16 gauges, count given";
const TRIPLE: &str = "triple, 16 gauges, count given";
const TRIPLE_OF_TEN: &str = "triple, 10 gauges, count given";
const ROUGH: &str = "double, friction and wide tip";

const COLUMNS: [Column<Diagnosed>; 8] = [
    Column::new("frames of", |r| r.row.name.clone()),
    Column::new("n", |r| r.row.errors.n_frames.to_string()),
    Column::new("clean", |r| format!("{:.1} %", r.row.errors.clean_pct)),
    Column::new("search", |r| r.causes.n_search.to_string()),
    Column::new("tie", |r| r.causes.n_tie.to_string()),
    Column::new("map", |r| r.causes.n_map.to_string()),
    Column::new("p50, ms", |r| format!("{:.2}", r.row.p50_us / 1e3)),
    Column::new("p99, ms", |r| format!("{:.2}", r.row.p99_us / 1e3)),
];

const METRICS: [Metric<Vec<Diagnosed>>; 10] = [
    clean("compare.quadruple16_clean_pct", QUADRUPLE),
    clean("compare.triple16_clean_pct", TRIPLE),
    clean("compare.triple10_clean_pct", TRIPLE_OF_TEN),
    clean("compare.double_clean_pct", "double"),
    clean("compare.friction_clean_pct", ROUGH),
    Metric {
        absent: "no frame was sure",
        ..Metric::row("compare.friction_coverage95_pct", "%", ROUGH, |r: &Diagnosed| {
            r.row.coverage95_pct.unwrap_or(f64::NAN)
        })
    },
    Metric::all("compare.search_failures_pct", "%", |rows| worst_search(rows), "no frames"),
    Metric::row("compare.cold_quadruple16_p50_us", "µs", QUADRUPLE, |r: &Diagnosed| r.row.p50_us),
    Metric::row("compare.cold_pair_p50_us", "µs", "double", |r: &Diagnosed| r.row.p50_us),
    Metric::row("compare.cold_pair_beyond10_pct", "%", "double", |r: &Diagnosed| {
        100.0 - r.row.errors.within10_pct
    }),
];

/// What the figures should be.
const GOALS: [Goal<Vec<Diagnosed>>; 9] = [
    clean_at_least(QUADRUPLE, "four at once, 16 gauges, clean, %", 97.0),
    clean_at_least(TRIPLE, "three at once, 16 gauges, clean, %", 99.0),
    clean_at_least("double", "two, clean, %", 98.0),
    clean_at_least(TRIPLE_OF_TEN, "three at once, 10 gauges, clean, %", 92.0),
    clean_at_least(ROUGH, "two, friction and wide tip, clean, %", 96.0),
    goal(
        "not clean by the search, worst row, %",
        Wanted::AtMost(5.0),
        Figure::All(|rows| worst_search(rows)),
    ),
    goal(
        "two, found in a single frame, ms",
        Wanted::AtMost(1.0),
        Figure::Row("double", |r: &Diagnosed| r.row.p50_us / 1e3),
    ),
    goal(
        "four, found in a single frame, ms",
        Wanted::AtMost(50.0),
        Figure::Row(QUADRUPLE, |r: &Diagnosed| r.row.p50_us / 1e3),
    ),
    goal(
        "the same, 99 of 100 frames, ms",
        Wanted::AtMost(200.0),
        Figure::Row(QUADRUPLE, |r: &Diagnosed| r.row.p99_us / 1e3),
    ),
];

const GOALS_NOTE: &str = "Clean: every contact within 10 mm of a true one, and none else; of four and of three the \
    count is given. By the search: the share of the frames that are not clean.";

const fn clean_at_least(
    row: &'static str,
    what: &'static str,
    least_pct: f64,
) -> Goal<Vec<Diagnosed>> {
    let figure = Figure::Row(row, |r: &Diagnosed| r.row.errors.clean_pct);
    goal(what, Wanted::AtLeast(least_pct), figure)
}

const fn goal(
    what: &'static str,
    wanted: Wanted,
    figure: Figure<Vec<Diagnosed>>,
) -> Goal<Vec<Diagnosed>> {
    Goal { what, wanted, figure }
}

/// The largest share of a row's frames that are not clean which the search has missed, %.
fn worst_search(rows: &[Diagnosed]) -> Option<f64> {
    rows.iter().map(|row| row.causes.search_pct()).reduce(f64::max)
}

const fn clean(name: &'static str, row: &'static str) -> Metric<Vec<Diagnosed>> {
    Metric::row(name, "%", row, |r: &Diagnosed| r.row.errors.clean_pct)
}

/// Scores frames and takes apart why some are not clean, prints and writes it.
pub(super) fn diagnose(bench: &mut Bench<'_>) -> Result<()> {
    let cases = bench.possible(&DIAGNOSED).into_iter();
    let rows = cases.map(|case| diagnosed(bench, case));
    let rows: Vec<Diagnosed> = rows.collect::<Result<_>>()?;
    let title = "Frames that are not clean, by cause";
    let report = Report {
        tables: vec![
            page_table(title, NOTE, table(&COLUMNS, &rows), &rows)?,
            STUDY.goal_table(&rows)?,
        ],
        ..facts::study(bench.run, "why frames are not clean", bench.args.test_seed)?
    };
    let log = &mut facts::log_of(bench.run, bench.args.test_seed);
    STUDY.publish(&rows, report, log, &bench.args.scene.results)?;
    Ok(())
}

fn diagnosed(bench: &mut Bench<'_>, case: &Case) -> Result<Diagnosed> {
    let mut causes = Causes::default();
    let scored = bench.found(case, |estimator, readings, frame, estimate| {
        let truth: Vec<_> = frame.contacts.iter().map(|c| (c.point, c.force_n)).collect();
        causes.add(why_not_clean(estimator, readings, &truth, estimate)?.as_ref());
        Ok(())
    })?;
    Ok(Diagnosed { row: scored.row(case.name), causes })
}
