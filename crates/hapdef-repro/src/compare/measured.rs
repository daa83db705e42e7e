//! What the comparison measured.

use hapdef_bench::Measurements;
use hapdef_bench::stats::{mean, quantile};

use super::score::{Row, Score};

/// Everything that was measured.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measured {
    pub(crate) rows: Vec<Row>,
    pub(crate) coverage95_pct: Option<f64>,
    pub(crate) bound_ratio: Option<f64>,
    /// Presses that the map is calibrated with where nothing else is said.
    pub(crate) n_presses: usize,
    /// Relative errors of the maps at presses they were not calibrated with: with all presses,
    /// 300, and none.
    pub(crate) map_errors: [f64; 3],
    /// Times of all frames of contacts that arrive one after another, µs, rising.
    pub(crate) tracking_us: Vec<f64>,
    /// Name of the paper's better row on doubles.
    pub(crate) best_paper: Option<String>,
}

impl Measured {
    pub(super) fn add(&mut self, name: &str, score: &Score) {
        self.rows.push(score.row(name));
    }
}

impl Measurements for Measured {
    type Row = Row;

    fn row(&self, name: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.name == name)
    }
}

/// The mean position error of the paper's pipeline with two contacts over superposition's.
pub(super) fn double_vs_paper(measured: &Measured) -> Option<f64> {
    let paper = measured.row(measured.best_paper.as_ref()?)?;
    Some(paper.errors.mean_mm / measured.row("double")?.errors.mean_mm)
}

/// The time of a frame of the paper's pipeline over that of a followed one.
pub(super) fn time_vs_paper(measured: &Measured) -> Option<f64> {
    let rows = measured.rows.iter().filter(|r| r.name.starts_with("paper"));
    let times: Vec<f64> = rows.map(|r| r.p50_us).collect();
    let paper_us = mean(times.iter().copied());
    (!times.is_empty()).then(|| paper_us / quantile(&measured.tracking_us, 0.5))
}
