//! One row of the stability table: an extreme problem, its error, and what the solver said.

use hapdef_mesh::MeshError;
use hapdef_report::{StabilityCase, StabilityRefusal, StabilityWanted, magnitude_text};
use hapdef_sim::{SimError, SolveInfo};

use crate::VerifyError;

/// The error that the solver's own rounding leaves; smaller ones differ from machine to machine.
const ROUND_OFF: f64 = 1e-13;

/// One problem at one extreme, and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityRow {
    /// The problem in words.
    pub case: &'static str,
    /// What is extreme about it.
    pub extreme: String,
    /// `direct`, `iterative`, or `shell` for the direct solver on a shell.
    pub path: &'static str,
    /// What came out.
    pub outcome: Result<StabilityFigures, StabilityRefusal>,
    /// What should have come out.
    pub wanted: StabilityWanted,
}

/// The figures of a problem that was solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityFigures {
    /// Equations solved.
    pub n_equations: usize,
    /// The largest error of a displacement over the largest displacement, against a trusted value.
    pub error: f64,
    /// The solver's own figures.
    pub info: SolveInfo,
}

impl StabilityFigures {
    /// The bound on the relative error that the solver states.
    #[must_use]
    pub fn bound(&self) -> f64 {
        self.info.forward_error_bound()
    }
}

impl StabilityCase for StabilityRow {
    type Figures = StabilityFigures;

    fn outcome(&self) -> Result<&StabilityFigures, &StabilityRefusal> {
        self.outcome.as_ref()
    }

    fn holds(&self, figures: &StabilityFigures) -> bool {
        figures.error <= figures.bound()
    }

    fn wanted(&self) -> StabilityWanted {
        self.wanted
    }

    fn cells(&self) -> Vec<String> {
        let figures: [String; 5] = match &self.outcome {
            Ok(f) => [
                f.n_equations.to_string(),
                magnitude(f.error),
                magnitude(f.info.worst_backward_error),
                f.info.condition.map_or_else(String::new, magnitude),
                magnitude(f.bound()),
            ],
            Err(_) => Default::default(),
        };
        let head = [self.case, &self.extreme, self.path].map(str::to_owned);
        let tail = [self.said(), self.verdict().word()].map(str::to_owned);
        head.into_iter().chain(figures).chain(tail).collect()
    }

    fn words(&self, refusal: &StabilityRefusal) -> String {
        let words = refusal.text.split(' ').map(short).collect::<Vec<_>>();
        let words = words.join(" ");
        format!("{}, {} ({}): {words}", self.case, self.extreme, self.path)
    }
}

fn magnitude(value: f64) -> String {
    magnitude_text(value, (ROUND_OFF, "round-off"))
}

/// A word without the digits that rounding moves, and without the sign of a zero.
fn short(word: &str) -> String {
    let is_number = |c: char| c.is_ascii_digit() || "-+.e".contains(c);
    let number = word.trim_matches(|c| !is_number(c)).trim_end_matches('.');
    match number.parse::<f64>() {
        Ok(0.0) => word.replace("-0", "0"),
        Ok(value) if number.len() > 8 => word.replace(number, &format!("{value:.2e}")),
        _ => word.to_owned(),
    }
}

/// The refusal that `error` is; a fault of the row's own set-up stays an error.
fn refusal(error: VerifyError) -> Result<StabilityRefusal, VerifyError> {
    Ok(match &error {
        VerifyError::Sim(SimError::ShellElement { problem, .. }) => {
            StabilityRefusal::new(problem, error.to_string())
        }
        VerifyError::Sim(cause) => StabilityRefusal::new(cause, cause.to_string()),
        VerifyError::Mesh(MeshError::Solid(fault)) => {
            StabilityRefusal::new(fault, fault.to_string())
        }
        VerifyError::Mesh(cause) => StabilityRefusal::new(cause, cause.to_string()),
        _ => return Err(error),
    })
}

/// A row to be solved.
pub(super) struct Trial {
    pub(super) case: &'static str,
    pub(super) extreme: String,
    pub(super) path: &'static str,
    pub(super) wanted: StabilityWanted,
    pub(super) run: Run,
}

pub(super) type Run = Box<dyn Fn() -> Result<StabilityFigures, VerifyError>>;

impl Trial {
    /// Solves the row.
    pub(super) fn row(&self) -> Result<StabilityRow, VerifyError> {
        let outcome = match (self.run)() {
            Ok(figures) => Ok(figures),
            Err(error) => Err(refusal(error)?),
        };
        Ok(StabilityRow {
            case: self.case,
            extreme: self.extreme.clone(),
            path: self.path,
            outcome,
            wanted: self.wanted,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hapdef_mesh::FeNodeId;
    use hapdef_report::StabilityVerdict;
    use hapdef_sim::NodalLoad;
    use nalgebra::Vector3;

    /// A solved row with another error.
    fn row(error: f64) -> StabilityRow {
        let block = crate::stability::solids::block(1e9, 0.3, 1.0, 1.0).unwrap();
        let model = hapdef_sim::ElasticModel::build(&block.mesh, &block.params).unwrap();
        let load = NodalLoad::nodal(FeNodeId::from_index(40), Vector3::x());
        let (_, info) = model.solve(&load).unwrap();
        StabilityRow {
            case: "a block",
            extreme: String::new(),
            path: "direct",
            outcome: Ok(StabilityFigures { n_equations: model.info().n_equations, error, info }),
            wanted: StabilityWanted::Either,
        }
    }

    #[test]
    fn an_error_beyond_the_bound_is_silently_wrong() {
        assert_eq!(row(1e-15).verdict(), StabilityVerdict::Accurate);
        for error in [1e-3, f64::INFINITY, f64::NAN] {
            assert_eq!(row(error).verdict(), StabilityVerdict::SilentlyWrong);
        }
    }

    #[test]
    fn words_keep_the_digits_that_hold_everywhere() {
        assert_eq!(short("-3.1524758424985325e-2"), "-3.15e-2");
        assert_eq!(short("(-0.0000,"), "(0.0000,");
        assert_eq!(short("(2.5000,"), "(2.5000,");
        assert_eq!(short("remesh."), "remesh.");
    }
}
