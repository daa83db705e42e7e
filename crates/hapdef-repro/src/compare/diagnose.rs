//! `compare --diagnose`: why frames are not clean.

use std::path::Path;

use anyhow::Result;
use hapdef::Run;
use hapdef_bench::{
    Column, Figure, Measurements, Metric, log_metrics, publish, table, terminal_table,
};
use hapdef_inverse::{ContactEstimate, ContactEstimator, EstimatorParams, SkinPoint, tip_ring_m};
use hapdef_report::{Report, ReportTable};
use serde::Serialize;

use super::cells::{Map, score};
use super::score::{Row, is_clean};
use super::setup::{Bench, FRICTION, N_MORE, WIDE_TIP_M};
use super::world::Frame;
use crate::run::facts;

const NOTE: &str = "Each frame that is not clean (a contact farther than 10 mm from its match, missed or \
    spurious) by its cause. The true places are refined on the same readings. Search: the readings \
    prefer the truth, and it was not found. Tie: they can't decide between both. Map: they prefer what was \
    found, by the map's error or the noise. The limit is odds of e^½ to 1, at which an answer is said to be \
    tied.";

/// Why the frames of a row are not clean.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Diagnosed {
    #[serde(flatten)]
    row: Row,
    n_search: usize,
    n_tie: usize,
    n_map: usize,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Diagnosis {
    rows: Vec<Diagnosed>,
}

impl Measurements for Diagnosis {
    type Row = Diagnosed;

    fn row(&self, name: &str) -> Option<&Diagnosed> {
        self.rows.iter().find(|row| row.row.name == name)
    }
}

impl Diagnosed {
    fn n_bad(&self) -> usize {
        self.n_search + self.n_tie + self.n_map
    }

    fn search_pct(&self) -> f64 {
        100.0 * self.n_search as f64 / self.n_bad().max(1) as f64
    }
}

impl Bench<'_> {
    /// Scores frames and takes apart why some are not clean, prints and writes it.
    pub(super) fn diagnose(&self, out: &Path) -> Result<()> {
        let n_gauges = self.limb.gauges.len();
        let presses = self.presses()?;
        let ten = self.calibrate(&self.ten, &presses, 0..n_gauges)?;
        let sixteen = self.calibrate(&self.more, &presses, n_gauges..n_gauges + N_MORE)?;
        let given = |k| EstimatorParams { known_count: Some(k), ..self.params() };
        let mut found = Diagnosis::default();
        for (k, map, name) in [
            (4, &sixteen, "quadruple, 16 gauges"),
            (3, &sixteen, "triple, 16 gauges"),
            (3, &ten, "triple, 10 gauges"),
        ] {
            let frames = self.apart(k, if map.channels.start == 0 { 13 } else { 30 + k as u64 })?;
            found.add(map, &map.estimator(self.params())?, &frames, name)?;
            let name = format!("{name}, count given");
            found.add(map, &map.estimator(given(k))?, &frames, &name)?;
        }
        let (drawn, n) = (self.drawn(), self.args.frames);
        found.add(&ten, &ten.estimator(self.params())?, &drawn.doubles(n)?, "double")?;
        let ring_m = tip_ring_m(WIDE_TIP_M, self.run.scene.contact.tip_radius_m);
        let rough = ten.estimator_with_friction(self.params(), FRICTION, ring_m)?;
        let frames = drawn.rough_doubles(n, FRICTION, WIDE_TIP_M)?;
        found.add(&ten, &rough, &frames, "double, friction and wide tip")?;
        write(self.run, out, self.args.test_seed, &found)
    }
}

impl Diagnosis {
    fn add(
        &mut self,
        map: &Map,
        estimator: &ContactEstimator,
        frames: &[Frame],
        name: &str,
    ) -> Result<()> {
        let (mut n_search, mut n_tie, mut n_map) = (0, 0, 0);
        let (mut scratch, mut of_truth) = (estimator.scratch(), ContactEstimate::default());
        let tie = estimator.params().tie_delta;
        let scored = score(estimator, map.channels.clone(), frames, |frame, estimate| {
            if is_clean(estimator.map().skin(), frame, estimate)? {
                return Ok(());
            }
            let places: Vec<SkinPoint> = frame.contacts.iter().map(|c| c.point).collect();
            let readings = &frame.readings_ue[map.channels.clone()];
            estimator.refine_into(readings, &places, &mut scratch, &mut of_truth)?;
            let behind = estimate.cost - of_truth.cost;
            let cause = match behind {
                behind if behind > tie => &mut n_search,
                behind if behind >= -tie => &mut n_tie,
                _ => &mut n_map,
            };
            *cause += 1;
            Ok(())
        })?;
        let row = Diagnosed { row: scored.row(name), n_search, n_tie, n_map };
        self.rows.push(row);
        Ok(())
    }
}

const COLUMNS: [Column<Diagnosed>; 8] = [
    Column::new("frames of", |r| r.row.name.clone()),
    Column::new("n", |r| r.row.errors.n_frames.to_string()),
    Column::new("clean", |r| format!("{:.1} %", r.row.errors.clean_pct)),
    Column::new("search", |r| r.n_search.to_string()),
    Column::new("tie", |r| r.n_tie.to_string()),
    Column::new("map", |r| r.n_map.to_string()),
    Column::new("p50, ms", |r| format!("{:.2}", r.row.p50_us / 1e3)),
    Column::new("p99, ms", |r| format!("{:.2}", r.row.p99_us / 1e3)),
];

const METRICS: [Metric<Diagnosis>; 8] = [
    clean("quadruple16_clean_pct", "quadruple, 16 gauges, count given"),
    clean("triple16_clean_pct", "triple, 16 gauges, count given"),
    clean("triple10_clean_pct", "triple, 10 gauges, count given"),
    clean("double_clean_pct", "double"),
    clean("friction_clean_pct", "double, friction and wide tip"),
    Metric {
        name: "friction_coverage95_pct",
        unit: "%",
        figure: Figure::Row("double, friction and wide tip", |r: &Diagnosed| {
            r.row.coverage95_pct.unwrap_or(f64::NAN)
        }),
        absent: "no frame was sure",
    },
    Metric {
        name: "search_failures_pct",
        unit: "%",
        figure: Figure::All(|found| found.rows.iter().map(Diagnosed::search_pct).reduce(f64::max)),
        absent: "no frames",
    },
    Metric {
        name: "cold_quadruple16_p50_us",
        unit: "µs",
        figure: Figure::Row("quadruple, 16 gauges, count given", |r: &Diagnosed| r.row.p50_us),
        absent: "no such row",
    },
];

const fn clean(name: &'static str, row: &'static str) -> Metric<Diagnosis> {
    let figure = Figure::Row(row, |r: &Diagnosed| r.row.errors.clean_pct);
    Metric { name, unit: "%", figure, absent: "no such row" }
}

fn write(run: &Run, out: &Path, test_seed: u64, found: &Diagnosis) -> Result<()> {
    let mut log = facts::log(test_seed);
    log_metrics(&METRICS, "compare", found, &mut log)?;
    let table = table(&COLUMNS, &found.rows);
    println!("{}", terminal_table(&table));
    let study = facts::study(run, "why frames are not clean", test_seed)?;
    let report = Report {
        tables: vec![ReportTable {
            title: "Frames that are not clean, by cause".into(),
            note: NOTE.into(),
            text: table,
            data: serde_json::to_value(&found.rows)?,
        }],
        ..study
    };
    publish(out, "diagnosis", report, &log)?;
    Ok(())
}
