//! Table 1: displacement error of maps from virtual gauges.

use hapdef::MapError;
use hapdef_report::{TextCell, TextTable, cell_text};

use super::{CellCount, MapMetric};

/// What turns virtual gauges into a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Method {
    /// Linear regression.
    #[serde(rename = "LR")]
    Linear,
    /// k nearest neighbours, k = 6, weights 1/distance.
    #[serde(rename = "k-NN")]
    Knn,
    /// The reconstruction net F_R.
    #[serde(rename = "FNN")]
    Fnn,
}

/// How many contacts the training samples have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
pub enum TrainSet {
    /// One.
    I,
    /// One or two.
    #[serde(rename = "I–II")]
    ToII,
    /// One to three.
    #[serde(rename = "I–III")]
    ToIII,
    /// One to four.
    #[serde(rename = "I–IV")]
    ToIV,
}

/// How many contacts the test samples have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[allow(clippy::upper_case_acronyms, reason = "the paper's names")]
pub enum TestSet {
    /// One.
    I,
    /// Two.
    II,
    /// Three.
    III,
    /// Four.
    IV,
}

impl Method {
    /// The rows of the table, in the paper's order.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Knn, Self::Fnn];

    /// The paper's name.
    pub fn name(self) -> &'static str {
        ["LR", "k-NN", "FNN"][self as usize]
    }
}

impl TrainSet {
    /// In rising order.
    pub const ALL: [Self; 4] = [Self::I, Self::ToII, Self::ToIII, Self::ToIV];

    /// The paper's name.
    pub fn name(self) -> &'static str {
        ["I", "I–II", "I–III", "I–IV"][self as usize]
    }

    /// Whether samples with as many contacts as `test` were trained on.
    pub fn contains(self, test: TestSet) -> bool {
        test as usize <= self as usize
    }
}

impl TestSet {
    /// In rising order.
    pub const ALL: [Self; 4] = [Self::I, Self::II, Self::III, Self::IV];

    /// The paper's name.
    pub fn name(self) -> &'static str {
        ["I", "II", "III", "IV"][self as usize]
    }
}

/// Table 1 of Sun & Martius 2019, displacement error on test data, µm:
/// `[method][trained on][tested on]`.
const PAPER_TEST_UM: [[[f64; 4]; 4]; 3] = [
    [
        [2.2, 36.6, 60.3, 78.2],
        [1.9, 16.1, 24.4, 31.8],
        [2.0, 15.6, 23.0, 29.8],
        [2.1, 15.6, 22.6, 29.0],
    ],
    [
        [2.3, 159.0, 225.1, 286.9],
        [2.4, 36.3, 97.8, 144.6],
        [2.3, 36.8, 75.8, 109.6],
        [2.3, 37.8, 73.36, 99.8],
    ],
    [
        [0.6, 82.3, 123.6, 158.1],
        [0.7, 7.7, 30.6, 48.6],
        [0.8, 7.0, 15.5, 25.7],
        [1.1, 6.8, 13.4, 20.2],
    ],
];

/// The training errors of the same table, µm: `[method][trained on]`.
const PAPER_TRAINING_UM: [[f64; 4]; 3] =
    [[2.2, 6.2, 10.9, 13.6], [2.3, 12.8, 27.5, 40.9], [0.6, 2.9, 5.7, 8.1]];

/// Whether a cell holds a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CellState {
    /// Measured, finite.
    Measured,
    /// Measured, NaN or infinite.
    NotFinite,
    /// Not measured.
    Skipped,
}

/// Map errors of each method, training set and test set by one metric, in its unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table1 {
    metric: MapMetric,
    tests: [[[Option<f64>; 4]; 4]; 3],
    trainings: [[Option<f64>; 4]; 3],
}

/// A method trained on the first so many sets.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct TrainedMethod {
    /// The method.
    pub method: Method,
    /// Sets that it was trained on, one at least.
    pub n_sets: usize,
    /// On the test samples of each set.
    pub test: Vec<MapError>,
    /// On its own training samples.
    pub training: MapError,
}

/// One cell with its place, for files.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Table1Record {
    /// What is measured.
    pub metric: MapMetric,
    /// Row group.
    pub method: Method,
    /// Row.
    pub trained_on: TrainSet,
    /// Column; `None` for the training error.
    pub tested_on: Option<TestSet>,
    /// Whether `ours_um` holds a number.
    pub state: CellState,
    /// Measured here, in `unit`.
    pub ours: Option<f64>,
    /// Printed in the paper, in `unit`; `None` where it prints none.
    pub paper: Option<f64>,
    /// "µm" or "%".
    pub unit: &'static str,
}

impl Table1 {
    /// The errors of these methods by `metric`; the other cells are empty.
    pub fn of(trained: &[TrainedMethod], metric: MapMetric) -> Self {
        let mut table = Self { metric, ..Self::default() };
        for of in trained {
            let train = TrainSet::ALL[of.n_sets - 1];
            for (test, error) in TestSet::ALL.into_iter().zip(&of.test) {
                table.set_test(of.method, train, test, metric.of(error));
            }
            table.trainings[of.method as usize][train as usize] = Some(metric.of(&of.training));
        }
        table
    }

    /// What its cells measure.
    pub fn metric(&self) -> MapMetric {
        self.metric
    }

    /// The paper's own numbers. It calls them displacement errors in µm and does not say whether
    /// absolute values or squares were averaged.
    pub fn paper() -> Self {
        Self {
            metric: MapMetric::MeanAbs,
            tests: PAPER_TEST_UM.map(|m| m.map(|row| row.map(Some))),
            trainings: PAPER_TRAINING_UM.map(|m| m.map(Some)),
        }
    }

    /// Enters a test error.
    pub fn set_test(&mut self, method: Method, train: TrainSet, test: TestSet, error: f64) {
        self.tests[method as usize][train as usize][test as usize] = Some(error);
    }

    /// A test error; `None` if not measured.
    pub fn test(&self, method: Method, train: TrainSet, test: TestSet) -> Option<f64> {
        self.tests[method as usize][train as usize][test as usize]
    }

    /// A training error; `None` if not measured.
    pub fn training(&self, method: Method, train: TrainSet) -> Option<f64> {
        self.trainings[method as usize][train as usize]
    }

    /// All 60 cells: 48 test errors, 12 training errors.
    pub fn cells(&self) -> CellCount {
        let test = self.tests.iter().flatten().flatten();
        CellCount::of(test.chain(self.trainings.iter().flatten()).copied())
    }

    /// All 60 cells beside the paper's, training error after the test errors of its row.
    pub fn records(&self) -> Vec<Table1Record> {
        let mut records = Vec::with_capacity(60);
        let paper = Self::paper();
        for method in Method::ALL {
            for trained_on in TrainSet::ALL {
                for tested_on in TestSet::ALL.map(Some).into_iter().chain([None]) {
                    let cell = |table: &Self| match tested_on {
                        Some(test) => table.test(method, trained_on, test),
                        None => table.training(method, trained_on),
                    };
                    records.push(Table1Record {
                        metric: self.metric,
                        method,
                        trained_on,
                        tested_on,
                        state: state(cell(self)),
                        ours: cell(self).filter(|v| v.is_finite()),
                        paper: cell(&paper).filter(|_| self.metric != MapMetric::Fvu),
                        unit: self.metric.unit(),
                    });
                }
            }
        }
        records
    }

    /// One row per method and training set, "ours (paper)"; of each training and test set
    /// the best method is strong.
    pub fn to_text(&self) -> TextTable {
        let header = ["method", "trained on", "I", "II", "III", "IV", "training error"];
        let rows = self.records().chunks(5).map(|row| self.text_row(row)).collect();
        TextTable { header: header.map(str::to_owned).to_vec(), rows }
    }

    fn text_row(&self, row: &[Table1Record]) -> Vec<TextCell> {
        let names = [row[0].method.name(), row[0].trained_on.name()].map(TextCell::plain);
        let cells = row.iter().map(|record| TextCell {
            text: match record.paper {
                Some(_) => format!("{} ({})", cell_text(ours(record)), cell_text(record.paper)),
                None => cell_text(ours(record)),
            },
            strong: self.is_best(record),
        });
        names.into_iter().chain(cells).collect()
    }

    fn is_best(&self, record: &Table1Record) -> bool {
        record.tested_on.is_some_and(|test| {
            let value = |m| self.test(m, record.trained_on, test).unwrap_or(f64::INFINITY);
            let rivals = Method::ALL.into_iter().filter(|m| *m != record.method);
            let mine = value(record.method);
            mine.is_finite() && rivals.into_iter().all(|m| mine < value(m))
        })
    }
}

fn ours(record: &Table1Record) -> Option<f64> {
    let is_measured = record.state != CellState::Skipped;
    is_measured.then(|| record.ours.unwrap_or(f64::NAN))
}

fn state(cell: Option<f64>) -> CellState {
    match cell {
        None => CellState::Skipped,
        Some(v) if v.is_finite() => CellState::Measured,
        Some(_) => CellState::NotFinite,
    }
}

impl serde::Serialize for Table1 {
    /// As the list of [`Table1::records`].
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serde::Serialize::serialize(&self.records(), serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_table_is_complete() {
        let paper = Table1::paper();
        assert_eq!(paper.cells(), CellCount { total: 60, measured: 60, nan: 0 });
        let worst = paper.test(Method::Knn, TrainSet::I, TestSet::IV).unwrap();
        assert!((worst - 286.9).abs() < 1e-9, "{worst}");
    }

    #[test]
    fn gaps_and_nan_are_counted_and_shown() {
        let mut ours = Table1::default();
        ours.set_test(Method::Fnn, TrainSet::ToII, TestSet::II, 7.25);
        ours.set_test(Method::Linear, TrainSet::ToII, TestSet::II, 20.0);
        ours.set_test(Method::Knn, TrainSet::I, TestSet::I, f64::NAN);
        ours.trainings[Method::Knn as usize][0] = Some(1.0);
        assert_eq!(ours.cells(), CellCount { total: 60, measured: 4, nan: 1 });
        let text = ours.to_text().to_markdown();
        assert!(text.contains("| FNN | I–II | – (0.70) | **7.2 (7.7)** | – (30.6) |"), "{text}");
        assert!(text.contains("| k-NN | I | NaN (2.3) | – (159) |"), "{text}");
        assert_eq!(text.lines().count(), 14);
    }

    #[test]
    fn json_is_a_list_of_cells() {
        let mut ours = Table1::default();
        ours.set_test(Method::Linear, TrainSet::I, TestSet::II, f64::INFINITY);
        let json = serde_json::to_value(&ours).unwrap();
        assert_eq!(json.as_array().unwrap().len(), 60);
        assert_eq!(json[1]["state"], "not_finite");
        assert_eq!(json[1]["ours"], serde_json::Value::Null);
        assert_eq!((&json[1]["method"], &json[1]["tested_on"]), (&"LR".into(), &"II".into()));
        assert!((json[59]["paper"].as_f64().unwrap() - 8.1).abs() < 1e-12);
    }

    /// A scene of two contacts at most: what was not run must not show up as measured.
    #[test]
    fn cells_that_were_not_run_stay_empty() {
        let error = |um: f64| MapError { mean_abs_um: um, rms_um: 2.0 * um, fvu: 0.25 };
        let trained = |(method, n_sets)| TrainedMethod {
            method,
            n_sets,
            test: vec![error(1.0), error(2.0)],
            training: error(0.5),
        };
        let all = [(Method::Linear, 1), (Method::Knn, 1), (Method::Fnn, 1), (Method::Linear, 2)];
        let all = all.map(trained);
        let of = |metric, test| {
            let table = Table1::of(&all, metric);
            assert_eq!(table.cells().measured, 12);
            table.test(Method::Linear, TrainSet::I, test)
        };
        assert_eq!(of(MapMetric::MeanAbs, TestSet::II), Some(2.0));
        assert_eq!(of(MapMetric::Rms, TestSet::II), Some(4.0));
        assert_eq!(of(MapMetric::Fvu, TestSet::I), Some(25.0));
        assert_eq!(of(MapMetric::Rms, TestSet::III), None);
        let table = Table1::of(&all, MapMetric::MeanAbs);
        assert_eq!(table.training(Method::Fnn, TrainSet::ToIV), None);
    }
}
