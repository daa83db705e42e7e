//! Table 1's linear regression with a ridge that validation samples choose.

use anyhow::{Context, Result};
use hapdef::{MapError, Pipeline, Run, Stage};
use hapdef_bench::{or_dash, page_table};
use hapdef_report::{ReportTable, TextCell, TextTable};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::dataset::{Dataset, first_of};
use super::kept::kept;
use super::table1::{add_training, error_on, test_error};
use crate::baselines::{LinearAccumulator, LinearParams};
use crate::search::Fitted;
use crate::tables::{Method, Table1, TestSet, TrainSet};

const VERSION: u32 = 1;

/// Ridges that are tried, shares of an input's variance.
const RIDGES: [f64; 7] = [0.0, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];

/// Most validation samples of a choice, spread over the sets that it was trained on.
const MAX_VALIDATION: usize = 1000;

/// Linear regression trained on I, I–II, and so on.
#[derive(Deserialize, Serialize)]
pub(crate) struct RidgeRows {
    rows: Vec<RidgeRow>,
}

#[derive(Deserialize, Serialize)]
struct RidgeRow {
    /// The ridge of least mean absolute error on validation samples.
    ridge: f64,
    /// On each set's test samples.
    test: Vec<MapError>,
}

/// Fits and tests them, or reads them from the cache.
pub(crate) fn ridge(run: &Run, done: &Pipeline) -> Result<(RidgeRows, Stage)> {
    let data = done.data.as_ref().context("no datasets")?;
    let sets: Vec<&str> = data.simulated.iter().map(|s| s.key.as_str()).collect();
    let inputs = json!({ "version": VERSION, "sets": sets, "ridges": RIDGES });
    kept(run, "ridge", &inputs, |_| {
        run.say("linear regression with a ridge by validation");
        fill(run, done)
    })
}

fn fill(run: &Run, done: &Pipeline) -> Result<RidgeRows> {
    let mut sets = Dataset::open_all(done.data.as_ref().context("no datasets")?)?;
    let mut sums = LinearAccumulator::new(sets[0].n_virtual, sets[0].n_surface);
    let mut rows = vec![];
    for n_sets in 1..=sets.len() {
        run.check_stop("linear regression with a ridge")?;
        add_training(&mut sums, &mut sets[n_sets - 1])?;
        let (ridge, best) = choose(&sums, &mut sets[..n_sets])?;
        let test = sets.iter_mut().map(|set| test_error(&best, set));
        let test = test.collect::<Result<_>>()?;
        rows.push(RidgeRow { ridge, test });
    }
    Ok(RidgeRows { rows })
}

/// The ridge of least error on validation samples of the sets trained on, and its regression.
fn choose(sums: &LinearAccumulator, sets: &mut [Dataset]) -> Result<(f64, Fitted)> {
    let most = MAX_VALIDATION / sets.len();
    let mut best: Option<(f64, f64, Fitted)> = None;
    for ridge in RIDGES {
        let params = LinearParams { ridge, ..LinearParams::default() };
        let regression = Fitted::Linear(sums.solve(&params)?.0);
        let mut error = 0.0;
        for set in &mut *sets {
            let rows = set.split()?.validation;
            error += error_on(&regression, set, first_of(rows, most))?.mean_abs_um;
        }
        if best.as_ref().is_none_or(|(least, ..)| error < *least) {
            best = Some((error, ridge, regression));
        }
    }
    let (_, ridge, regression) = best.context("no ridge to try")?;
    Ok((ridge, regression))
}

impl RidgeRows {
    /// For people, beside Table 1's linear regression `plain`; mean absolute errors.
    pub(crate) fn table(&self, plain: &Table1) -> Result<ReportTable> {
        let row = |(row, train): (&RidgeRow, TrainSet)| {
            let cell = |(error, test): (&MapError, TestSet)| {
                let plain = plain.test(Method::Linear, train, test);
                let plain = or_dash(plain.map(|um| format!("{um:.2}")));
                TextCell::plain(format!("{:.2} ({plain})", error.mean_abs_um))
            };
            let names = [train.name().to_owned(), format!("{:e}", row.ridge)];
            let mut cells: Vec<TextCell> = names.map(TextCell::plain).to_vec();
            cells.extend(row.test.iter().zip(TestSet::ALL).map(cell));
            cells
        };
        let mut header = vec!["trained on".to_owned(), "ridge".to_owned()];
        let n_tests = self.rows.first().map_or(0, |row| row.test.len());
        let tests = TestSet::ALL.iter().take(n_tests);
        header.extend(tests.map(|test| test.name().to_owned()));
        let note = format!(
            "The ridge, a share of each standardised input's variance, is the one of {RIDGES:?} \
             with the least error on at most {MAX_VALIDATION} validation samples of the sets \
             trained on. In brackets: Table 1's LR, without a ridge."
        );
        let rows = self.rows.iter().zip(TrainSet::ALL).map(row).collect();
        let title = "Linear regression with a ridge by validation: mean |error|, µm (plain)";
        Ok(page_table(title, note, TextTable { header, rows }, self)?)
    }
}
