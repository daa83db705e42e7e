//! Solving cases and judging them.

use std::time::Instant;

use crate::{Case, Measured, Reference, VerifyError};

/// All cases, judged.
#[derive(Clone, Default)]
pub struct Report {
    /// One entry per case, in order.
    pub cases: Vec<CaseReport>,
}

/// One case, judged.
#[derive(Clone)]
pub struct CaseReport {
    /// What was solved.
    pub case: Case,
    /// One entry per mesh that was solved, coarse to fine.
    pub rows: Vec<Row>,
    /// How it went.
    pub verdict: Verdict,
}

/// One mesh of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What it gave.
    pub measured: Measured,
    /// What it is compared with.
    pub reference: Reference,
    /// Relative error, where there is a reference.
    pub rel_err: Option<f64>,
    /// Observed order up to this mesh, where it can be estimated.
    pub order: Option<f64>,
    /// Seconds for mesh, factor, solve and evaluation.
    pub elapsed_s: f64,
}

/// How a case went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The target is met.
    Pass,
    /// It is missed for a known reason, in words.
    KnownMiss(String),
    /// It is not, or the solver gave an error, in words.
    Fail(String),
    /// It could not be run here, with the reason.
    NotRun(String),
    /// Nothing to judge.
    Reported,
}

impl Verdict {
    /// `ok`, `misses (known)`, `FAILED`, `not run` or `reported`.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Pass => "ok",
            Self::KnownMiss(_) => "misses (known)",
            Self::Fail(_) => "FAILED",
            Self::NotRun(_) => "not run",
            Self::Reported => "reported",
        }
    }

    /// The reason of what is no pass; empty where there is none.
    pub fn why(&self) -> &str {
        match self {
            Self::KnownMiss(why) | Self::Fail(why) | Self::NotRun(why) => why,
            Self::Pass | Self::Reported => "",
        }
    }
}

impl Report {
    /// Cases that were judged: pass, known miss or fail.
    pub fn n_judged(&self) -> usize {
        self.count(|verdict| !matches!(verdict, Verdict::NotRun(_) | Verdict::Reported))
    }

    /// Cases whose verdict is so.
    pub fn count(&self, is: impl Fn(&Verdict) -> bool) -> usize {
        self.cases.iter().filter(|case| is(&case.verdict)).count()
    }

    /// Cases whose target is missed for a known reason.
    pub fn n_known_misses(&self) -> usize {
        self.count(|verdict| matches!(verdict, Verdict::KnownMiss(_)))
    }

    /// Cases whose target is missed for no known reason.
    pub fn n_failed(&self) -> usize {
        self.count(|verdict| matches!(verdict, Verdict::Fail(_)))
    }

    /// The largest relative error on the finest mesh over all judged cases.
    pub fn worst(&self) -> Option<f64> {
        let errors = self.cases.iter().filter_map(|case| case.rows.last()?.rel_err);
        errors.max_by(f64::total_cmp)
    }
}

/// A known miss may grow by the digits it is recorded in.
const KNOWN_SLACK: f64 = 1.02;

/// Solves and judges cases in order; `after` sees each as it is done.
pub fn run_cases(cases: &[Case], mut after: impl FnMut(&CaseReport)) -> Report {
    let done = cases.iter().map(|case| {
        let report = run_case(case);
        after(&report);
        report
    });
    Report { cases: done.collect() }
}

/// Solves and judges one case.
pub fn run_case(case: &Case) -> CaseReport {
    let mut rows: Vec<Row> = Vec::new();
    let mut stopped = None;
    for level in 0..case.meshes.len() {
        let started = Instant::now();
        match case.measure(level) {
            Ok(measured) => {
                let elapsed_s = started.elapsed().as_secs_f64();
                let rel_err = case.reference.rel_err(measured.value);
                let reference = case.reference;
                rows.push(Row { measured, reference, rel_err, order: None, elapsed_s });
                let order = observed_order(&rows);
                rows[level].order = order;
            }
            Err(error) => {
                stopped = Some(error);
                break;
            }
        }
    }
    let verdict = judge(case, &rows, stopped);
    CaseReport { case: case.clone(), rows, verdict }
}

fn judge(case: &Case, rows: &[Row], stopped: Option<VerifyError>) -> Verdict {
    match stopped {
        Some(VerifyError::NotRun { reason }) => return Verdict::NotRun(reason),
        Some(error) => return Verdict::Fail(error.to_string()),
        None => {}
    }
    let Some(last) = rows.last() else {
        return Verdict::NotRun("the case has no mesh".to_owned());
    };
    let Some(rel_err) = last.rel_err else {
        return Verdict::Reported;
    };
    match case.known_miss {
        None => meets(case, last, rel_err).map_or_else(Verdict::Fail, |()| Verdict::Pass),
        Some(known) => match meets(case, last, rel_err) {
            Ok(()) => {
                Verdict::Fail("meets its target now: it is no known miss any more".to_owned())
            }
            // a value that is not a number is worse than any
            Err(_) if !rel_err.is_finite() || rel_err > known.rel_err * KNOWN_SLACK => {
                let recorded = known.rel_err;
                Verdict::Fail(format!(
                    "relative error {rel_err:.2e}, worse than the known miss of {recorded:.2e}"
                ))
            }
            Err(_) => Verdict::KnownMiss(known.why.to_owned()),
        },
    }
}

/// Whether the finest mesh meets the target; what is missed otherwise.
fn meets(case: &Case, last: &Row, rel_err: f64) -> Result<(), String> {
    // a value that is not a number must not pass
    if !rel_err.is_finite() || rel_err > case.target.rel_err {
        let allowed = case.target.rel_err;
        return Err(format!("relative error {rel_err:.2e}, allowed {allowed:.0e}"));
    }
    match (case.target.order, last.order) {
        (Some(least), Some(order)) if order < least => {
            Err(format!("observed order {order:.2}, at least {least} asked"))
        }
        (Some(least), None) => Err(format!("no observed order, at least {least} asked")),
        _ => Ok(()),
    }
}

/// ln(e₁/e₂) / ln(h₁/h₂) of errors on the two finest meshes; for published values
/// ln(|v₁ − v₀| / |v₂ − v₁|) / ln(h₁/h₂) of the three finest, if they
/// are refined by one ratio
/// (Roache, Verification and Validation in Computational Science and Engineering, 1998, section 5).
fn observed_order(rows: &[Row]) -> Option<f64> {
    let (differences, h) = match (rows.last()?.reference, rows) {
        (Reference::Exact(_) | Reference::Zero, [.., a, b]) => {
            ((a.rel_err?, b.rel_err?), (a.measured.h, b.measured.h))
        }
        (Reference::Published(_), [.., a, b, c]) => {
            let ratios = [a.measured.h / b.measured.h, b.measured.h / c.measured.h];
            if (ratios[0] - ratios[1]).abs() > 1e-6 * ratios[0] {
                return None;
            }
            let step = |a: &Row, b: &Row| (b.measured.value - a.measured.value).abs();
            ((step(a, b), step(b, c)), (b.measured.h, c.measured.h))
        }
        _ => return None,
    };
    // at round-off there is no order left to see
    if differences.0 < 1e-11 || differences.1 <= 0.0 {
        return None;
    }
    let order = (differences.0 / differences.1).ln() / (h.0 / h.1).ln();
    order.is_finite().then_some(order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Target;
    use crate::case::Solve;

    fn case(reference: Reference, target: Target, values: [f64; 3]) -> Case {
        Case {
            reference,
            target,
            meshes: &[[0; 3], [1; 3], [2; 3]],
            solve: Solve::by(move |_, [level, ..]| {
                Ok(Measured {
                    value: values[level],
                    mesh: String::new(),
                    n_nodes: 1,
                    n_equations: 1,
                    h: 0.5_f64.powi(level as i32),
                })
            }),
            ..Case::default()
        }
    }

    #[track_caller]
    fn check(reference: Reference, target: Target, values: [f64; 3], pass: bool, order: f64) {
        let report = run_case(&case(reference, target, values));
        assert_eq!(report.verdict == Verdict::Pass, pass, "{:?}", report.verdict);
        let found = report.rows[2].order.unwrap_or(f64::NAN);
        assert!((found - order).abs() < 1e-9 || (found.is_nan() && order.is_nan()), "{found}");
    }

    #[test]
    fn errors_and_orders_decide() {
        let quartering = [1.16, 1.04, 1.01];
        let within = Target::within(0.02);
        check(Reference::Exact(1.0), within, quartering, true, 2.0);
        check(Reference::Published(1.0), within, quartering, true, 2.0);
        check(Reference::Exact(1.0), within.and_order(2.5), quartering, false, 2.0);
        check(Reference::Exact(1.0), Target::within(0.005), quartering, false, 2.0);
        check(Reference::Zero, within, [0.16, 0.04, 0.01], true, 2.0);
        check(Reference::Zero, within, [1e-13, 1e-13, 1e-13], true, f64::NAN);
        check(Reference::Exact(1.0), within, [1.0, 1.0, f64::NAN], false, f64::NAN);
    }

    #[track_caller]
    fn check_known(value: f64, recorded: f64, word: &str) {
        let mut case = case(Reference::Exact(1.0), Target::within(0.01), [value; 3]);
        case.known_miss = Some(crate::KnownMiss { rel_err: recorded, why: "why" });
        let report = Report { cases: vec![run_case(&case)] };
        assert_eq!(report.cases[0].verdict.word(), word);
        let failed = usize::from(word == "FAILED");
        assert_eq!((report.n_judged(), report.n_failed()), (1, failed));
        assert_eq!(report.n_known_misses(), 1 - failed);
    }

    #[test]
    fn a_known_miss_may_neither_grow_nor_vanish() {
        check_known(1.05, 0.05, "misses (known)");
        check_known(1.04, 0.05, "misses (known)");
        check_known(1.06, 0.05, "FAILED");
        check_known(1.005, 0.05, "FAILED");
        check_known(f64::NAN, 0.05, "FAILED");
    }

    #[test]
    fn what_can_not_run_is_neither_pass_nor_fail() {
        let mut case = case(Reference::Exact(1.0), Target::within(1.0), [1.0; 3]);
        case.solve = Solve::by(|_, _| Err(VerifyError::not_run("element S8R")));
        let report = Report { cases: vec![run_case(&case)] };
        assert_eq!(report.cases[0].verdict, Verdict::NotRun("element S8R".to_owned()));
        assert_eq!((report.n_judged(), report.n_failed()), (0, 0));
    }
}
