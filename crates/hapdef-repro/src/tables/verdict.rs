//! The two messages of Table 1, checked cell by cell.

use super::{Method, Table1, TestSet, TrainSet};

/// Whether a claim held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VerdictState {
    /// In every cell.
    Held,
    /// Not in the cells listed.
    Broken,
    /// No cell breaks it, but some were not measured.
    NotMeasured,
}

/// A cell where the claimed method is not the best.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct BrokenCell {
    /// Training set.
    pub trained_on: TrainSet,
    /// Test set.
    pub tested_on: TestSet,
    /// Error of the method that should be best, µm.
    pub claimed_um: f64,
    /// The method that is better or as good, or whose error is not finite.
    pub rival: Method,
    /// Its error, µm.
    pub rival_um: f64,
}

/// A claim of the paper and how it fared here.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// The claim, in words.
    pub claim: &'static str,
    /// How it fared.
    pub state: VerdictState,
    /// Cells the claim speaks of.
    pub n_cells: usize,
    /// Cells of which at least one method was not measured.
    pub n_missing: usize,
    /// Cells that break it, one entry per rival.
    pub broken: Vec<BrokenCell>,
}

/// Message 1: trained on single contacts alone, linear regression extrapolates best, i.e. has
/// the lowest error of the three methods on two, three and four contacts.
#[must_use]
pub fn message_1(table: &Table1) -> Verdict {
    let cells = [TestSet::II, TestSet::III, TestSet::IV].map(|test| (TrainSet::I, test));
    let claim = "trained on I alone, LR has the lowest error on II, III and IV";
    judge(table, claim, Method::Linear, &cells)
}

/// Message 2: the FNN is best wherever the number of contacts was in training, and best on four
/// contacts when trained on one to three.
#[must_use]
pub fn message_2(table: &Table1) -> Verdict {
    let mut cells = Vec::new();
    for train in TrainSet::ALL {
        cells.extend(
            TestSet::ALL
                .into_iter()
                .filter(|t| train.contains(*t))
                .map(|t| (train, t)),
        );
    }
    cells.push((TrainSet::ToIII, TestSet::IV));
    let claim =
        "the FNN has the lowest error wherever the count was in training, and on IV from I–III";
    judge(table, claim, Method::Fnn, &cells)
}

fn judge(
    table: &Table1,
    claim: &'static str,
    best: Method,
    cells: &[(TrainSet, TestSet)],
) -> Verdict {
    let (mut broken, mut n_missing) = (Vec::new(), 0);
    for &(trained_on, tested_on) in cells {
        let error_um = |m| table.test(m, trained_on, tested_on).map(|v| v * 1e6);
        n_missing += usize::from(Method::ALL.into_iter().any(|m| error_um(m).is_none()));
        let Some(claimed_um) = error_um(best) else {
            continue;
        };
        for rival in Method::ALL.into_iter().filter(|m| *m != best) {
            let Some(rival_um) = error_um(rival) else {
                continue;
            };
            if !(claimed_um < rival_um && rival_um.is_finite()) {
                broken.push(BrokenCell {
                    trained_on,
                    tested_on,
                    claimed_um,
                    rival,
                    rival_um,
                });
            }
        }
    }
    let state = match (broken.is_empty(), n_missing) {
        (false, _) => VerdictState::Broken,
        (true, 0) => VerdictState::Held,
        (true, _) => VerdictState::NotMeasured,
    };
    Verdict {
        claim,
        state,
        n_cells: cells.len(),
        n_missing,
        broken,
    }
}

impl Verdict {
    /// How the claim fared, in words, with the cells that break it.
    #[must_use]
    pub fn fate(&self) -> String {
        match self.state {
            VerdictState::Held => format!("held in all {} cells", self.n_cells),
            VerdictState::NotMeasured => {
                format!(
                    "open: {} of {} cells not measured",
                    self.n_missing, self.n_cells
                )
            }
            VerdictState::Broken => {
                let cells: Vec<String> = self.broken.iter().map(BrokenCell::text).collect();
                format!("broken: {}", cells.join("; "))
            }
        }
    }
}

impl BrokenCell {
    fn text(&self) -> String {
        format!(
            "{} tested on {}: {:.2} µm, {} {:.2} µm",
            self.trained_on.name(),
            self.tested_on.name(),
            self.claimed_um,
            self.rival.name(),
            self.rival_um
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_own_numbers_hold_both() {
        let paper = Table1::paper();
        let (one, two) = (message_1(&paper), message_2(&paper));
        assert_eq!((one.state, one.n_cells), (VerdictState::Held, 3), "{one:?}");
        assert_eq!(
            (two.state, two.n_cells),
            (VerdictState::Held, 11),
            "{two:?}"
        );
        assert!(two.fate().contains("held in all 11 cells"));
    }

    #[test]
    fn a_better_rival_breaks_its_cell_only() {
        let mut table = Table1::paper();
        let linear = table
            .test(Method::Linear, TrainSet::I, TestSet::III)
            .unwrap();
        table.set_test(Method::Knn, TrainSet::I, TestSet::III, linear);
        let one = message_1(&table);
        assert_eq!(one.state, VerdictState::Broken);
        assert_eq!(one.broken.len(), 1, "a draw is no win: {one:?}");
        assert_eq!(
            (one.broken[0].rival, one.broken[0].tested_on),
            (Method::Knn, TestSet::III)
        );
        assert_eq!(message_2(&table).state, VerdictState::Held);
    }

    #[test]
    fn nan_breaks_and_gaps_leave_open() {
        let mut table = Table1::paper();
        table.set_test(Method::Fnn, TrainSet::ToIII, TestSet::IV, f64::NAN);
        assert_eq!(message_2(&table).broken.len(), 2);
        let mut table = Table1::paper();
        table.set_test(Method::Linear, TrainSet::ToIII, TestSet::IV, f64::NAN);
        assert_eq!(
            message_2(&table).broken.len(),
            1,
            "a rival's NaN proves nothing"
        );
        let none = message_1(&Table1::default());
        assert_eq!((none.state, none.n_missing), (VerdictState::NotMeasured, 3));
        assert!(none.fate().contains("open: 3 of 3"));
    }
}
