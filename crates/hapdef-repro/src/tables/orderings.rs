//! The claims of Table 1, checked cell by cell on each metric's table.

use super::claim::{Check, Claim, MetricVerdict};
use super::{MapMetric, Method, Table1, TestSet, TrainSet};

/// LR's share of the error that the FNN leaves, both trained on I–IV, tested on I to IV: the
/// quotients of Table 1's last rows.
const PAPER_FNN_OVER_LR: [f64; 4] = [0.52, 0.44, 0.60, 0.70];

/// Every claim about Table 1, with a verdict for each metric's table; the quotient of FNN and LR by
/// errors alone, as squares have other quotients.
pub fn table1_claims(tables: &[Table1]) -> Vec<Claim> {
    let claim = |id, text, paper, checks: fn(&Table1) -> Vec<Check>| Claim {
        id,
        text,
        paper,
        verdicts: tables
            .iter()
            .filter(|table| id != "fnn_over_lr" || table.metric() != MapMetric::Fvu)
            .map(|table| judge(table, &checks(table)))
            .collect(),
    };
    vec![
        claim(
            "message_1",
            "trained on I alone, LR has the lowest error of the three on II, III and IV",
            "LR 36.6 / 60.3 / 78.2 µm, the next best 82.3 / 123.6 / 158.1",
            message_1,
        ),
        claim(
            "message_2",
            "the FNN has the lowest error wherever the count was in training, and on IV from I–III",
            "lowest in all 11 cells",
            message_2,
        ),
        claim(
            "more_contacts_help",
            "training on I–IV instead of I lowers the error on II, III and IV, for each method",
            "in all 9 cells",
            more_contacts_help,
        ),
        claim(
            "harder_with_contacts",
            "the error grows with the number of contacts tested on, in each row",
            "in all 36 steps",
            harder_with_contacts,
        ),
        claim(
            "training_error_grows",
            "the training error grows with the number of contacts trained on, for each method",
            "in all 9 steps",
            training_error_grows,
        ),
        claim(
            "fnn_over_lr",
            "trained on I–IV, the FNN's error over LR's is no more than the paper's on I, II, III, IV",
            "0.52 / 0.44 / 0.60 / 0.70",
            fnn_over_lr_checks,
        ),
    ]
}

/// The FNN's error over LR's, both trained on I–IV, by test set.
pub fn fnn_over_lr(table: &Table1) -> [Option<f64>; 4] {
    TestSet::ALL.map(|test| {
        let of = |method| table.test(method, TrainSet::ToIV, test);
        Some(of(Method::Fnn)? / of(Method::Linear)?)
    })
}

fn judge(table: &Table1, checks: &[Check]) -> MetricVerdict {
    let is_ratio = checks.iter().any(|c| c.high_name == "paper");
    let unit = if is_ratio { "" } else { table.metric().unit() };
    MetricVerdict::of(table.metric().name(), unit, checks)
}

fn message_1(table: &Table1) -> Vec<Check> {
    let cells = [TestSet::II, TestSet::III, TestSet::IV].map(|test| (TrainSet::I, test));
    best_in(table, Method::Linear, &cells)
}

fn message_2(table: &Table1) -> Vec<Check> {
    let mut cells = Vec::new();
    for train in TrainSet::ALL {
        let seen = TestSet::ALL.into_iter().filter(|t| train.contains(*t));
        cells.extend(seen.map(|test| (train, test)));
    }
    cells.push((TrainSet::ToIII, TestSet::IV));
    best_in(table, Method::Fnn, &cells)
}

/// Per cell, the claimed method against the better of the other two; one that was not measured or
/// is not finite counts as the better.
fn best_in(table: &Table1, best: Method, cells: &[(TrainSet, TestSet)]) -> Vec<Check> {
    let check = |&(train, test): &(TrainSet, TestSet)| {
        let of = |m| table.test(m, train, test);
        let rivals = Method::ALL.into_iter().filter(|m| *m != best);
        let rival = rivals.min_by(|a, b| {
            let key = |m: Method| of(m).filter(|v| v.is_finite()).unwrap_or(f64::NEG_INFINITY);
            key(*a).total_cmp(&key(*b))
        });
        let rival = rival.unwrap_or(best);
        let place = format!("{} on {}", train.name(), test.name());
        Check::below(place, (best.name(), of(best)), (rival.name(), of(rival)))
    };
    cells.iter().map(check).collect()
}

fn more_contacts_help(table: &Table1) -> Vec<Check> {
    let each = Method::ALL.into_iter().flat_map(|method| {
        [TestSet::II, TestSet::III, TestSet::IV].map(|test| {
            let of = |train| table.test(method, train, test);
            Check::below(
                format!("{} on {}", method.name(), test.name()),
                ("from I–IV", of(TrainSet::ToIV)),
                ("from I", of(TrainSet::I)),
            )
        })
    });
    each.collect()
}

fn harder_with_contacts(table: &Table1) -> Vec<Check> {
    let mut checks = Vec::new();
    for method in Method::ALL {
        for train in TrainSet::ALL {
            for pair in TestSet::ALL.windows(2) {
                let of = |test: TestSet| (test.name(), table.test(method, train, test));
                let place = format!("{} from {}", method.name(), train.name());
                checks.push(Check::below(place, of(pair[0]), of(pair[1])));
            }
        }
    }
    checks
}

fn training_error_grows(table: &Table1) -> Vec<Check> {
    let steps = Method::ALL.into_iter().flat_map(|method| {
        TrainSet::ALL.windows(2).map(move |pair| {
            let of = |train: TrainSet| (train.name(), table.training(method, train));
            Check::below(method.name(), of(pair[0]), of(pair[1]))
        })
    });
    steps.collect()
}

fn fnn_over_lr_checks(table: &Table1) -> Vec<Check> {
    let ratios = TestSet::ALL.into_iter().zip(fnn_over_lr(table));
    let checks = ratios.zip(PAPER_FNN_OVER_LR).map(|((test, ratio), paper)| {
        Check::at_most(test.name(), ("ours", ratio), ("paper", Some(paper)))
    });
    checks.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::Fate;

    fn fate(table: &Table1, id: &str) -> Fate {
        let claims = table1_claims(std::slice::from_ref(table));
        let found = claims.iter().find(|c| c.id == id).unwrap();
        found.fate()
    }

    #[test]
    fn the_papers_own_numbers_hold_every_claim() {
        let claims = table1_claims(&[Table1::paper()]);
        let n: Vec<usize> = claims.iter().map(|c| c.verdicts[0].n_checks).collect();
        assert_eq!(n, [3, 11, 9, 36, 9, 4]);
        for claim in claims {
            let off = claim.id == "fnn_over_lr";
            let verdict = &claim.verdicts[0];
            assert!(off || verdict.fate == Fate::Holds, "{verdict:?}");
        }
        let found = fnn_over_lr(&Table1::paper()).map(|r| (r.unwrap() * 100.0).round());
        assert_eq!(found, [52.0, 44.0, 59.0, 70.0]);
    }

    #[test]
    fn a_better_rival_breaks_its_cell_only() {
        let mut table = Table1::paper();
        let linear = table.test(Method::Linear, TrainSet::I, TestSet::III).unwrap();
        table.set_test(Method::Knn, TrainSet::I, TestSet::III, linear);
        let claims = table1_claims(std::slice::from_ref(&table));
        assert_eq!(claims[0].verdicts[0].n_held, 2, "a draw is no win");
        let reason = &claims[0].verdicts[0].reason;
        assert_eq!(reason, "2 of 3; worst I on III: LR 60.3, k-NN 60.3 µm");
        assert_eq!(fate(&table, "message_2"), Fate::Holds);
    }

    #[test]
    fn nan_breaks_and_gaps_leave_open() {
        let mut table = Table1::paper();
        table.set_test(Method::Fnn, TrainSet::ToIII, TestSet::IV, f64::NAN);
        assert_eq!(fate(&table, "message_2"), Fate::HoldsPartly);
        assert_eq!(fate(&Table1::default(), "message_1"), Fate::NotMeasured);
        let fvu = table1_claims(&[Table1::of(&[], MapMetric::Fvu)]);
        let ratio = fvu.iter().find(|claim| claim.id == "fnn_over_lr").unwrap();
        assert!(ratio.verdicts.is_empty(), "the paper's quotients are of errors");
    }
}
