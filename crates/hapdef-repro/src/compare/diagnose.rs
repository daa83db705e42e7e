//! `compare --diagnose`: why frames are not clean.

use anyhow::Result;
use hapdef::touch::{Causes, why_not_clean};
use hapdef_bench::{Column, Metric, Named, Study, page_table, table};
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

const STUDY: Study<Vec<Diagnosed>> =
    Study { folder: "diagnosis", metrics: &METRICS, goals: &[], goals_note: "", file: None };

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
    clean("compare.quadruple16_clean_pct", "quadruple, 16 gauges, count given"),
    clean("compare.triple16_clean_pct", "triple, 16 gauges, count given"),
    clean("compare.triple10_clean_pct", "triple, 10 gauges, count given"),
    clean("compare.double_clean_pct", "double"),
    clean("compare.friction_clean_pct", "double, friction and wide tip"),
    Metric {
        absent: "no frame was sure",
        ..Metric::row(
            "compare.friction_coverage95_pct",
            "%",
            "double, friction and wide tip",
            |r: &Diagnosed| r.row.coverage95_pct.unwrap_or(f64::NAN),
        )
    },
    Metric::all(
        "compare.search_failures_pct",
        "%",
        |rows| rows.iter().map(|row| row.causes.search_pct()).reduce(f64::max),
        "no frames",
    ),
    Metric::row(
        "compare.cold_quadruple16_p50_us",
        "µs",
        "quadruple, 16 gauges, count given",
        |r: &Diagnosed| r.row.p50_us,
    ),
    Metric::row("compare.cold_pair_p50_us", "µs", "double", |r: &Diagnosed| r.row.p50_us),
    Metric::row("compare.cold_pair_beyond10_pct", "%", "double", |r: &Diagnosed| {
        100.0 - r.row.errors.within10_pct
    }),
];

const fn clean(name: &'static str, row: &'static str) -> Metric<Vec<Diagnosed>> {
    Metric::row(name, "%", row, |r: &Diagnosed| r.row.errors.clean_pct)
}

/// Scores frames and takes apart why some are not clean, prints and writes it.
pub(super) fn diagnose(bench: &mut Bench<'_>) -> Result<()> {
    let rows = DIAGNOSED.iter().map(|case| diagnosed(bench, case));
    let rows: Vec<Diagnosed> = rows.collect::<Result<_>>()?;
    let title = "Frames that are not clean, by cause";
    let report = Report {
        tables: vec![page_table(title, NOTE, table(&COLUMNS, &rows), &rows)?],
        ..facts::study(bench.run, "why frames are not clean", bench.args.test_seed)?
    };
    let log = &mut facts::log(bench.args.test_seed);
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
