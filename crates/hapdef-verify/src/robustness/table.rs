//! The table of docs/stability-fe.md, and what a trial of the solver gives.

use hapdef_bench::robustness::{Column, Expected, Measured, Refusal, SolverMetrics, Table};
use hapdef_mesh::MeshError;
use hapdef_sim::{ElasticModel, SimError, SolveInfo};

use crate::VerifyError;

/// The rows of the table.
pub type RobustnessTrials = hapdef_bench::robustness::Trials<(), VerifyError>;

/// docs/stability-fe.md.
pub const ROBUSTNESS_TABLE: Table = Table {
    folder: "stability-fe",
    title: "Robustness of the elasticity solver",
    note: "Error: the largest of a displacement over the largest displacement. Bound: what the \
           solver says that it is at most.",
    layer: "elements, factor, solve",
    columns: &[
        Column::CASE,
        Column::EXTREME,
        Column::PATH,
        Column::EQUATIONS,
        Column::ERROR,
        Column::BACKWARD,
        Column::CONDITION,
        Column::BOUND,
        Column::SAID,
        Column::VERDICT,
    ],
    // what the solver's own rounding leaves; smaller errors differ from machine to machine
    least: (1e-13, "round-off"),
    rounded_refusals: &[
        "IllConditioned",
        "NotConverged",
        "NotPositiveDefinite",
        "Residual",
        "Singular",
    ],
    word: rounded_word,
};

/// A row on one of the solver's paths.
pub(super) fn add(
    rows: &mut RobustnessTrials,
    (case, extreme): (&'static str, impl Into<String>),
    path: &'static str,
    expected: Expected,
    run: impl Fn() -> Result<Measured, VerifyError> + 'static,
) {
    let must_hold = "the error is within the stated bound";
    rows.of(case).path(path).solved(extreme, must_hold, expected, move |()| run());
}

/// An error against the solver's bound on it.
pub(super) fn measured(model: &ElasticModel, info: &SolveInfo, error: f64) -> Measured {
    let solver = SolverMetrics {
        n_equations: model.info().n_equations,
        backward_error: info.worst_backward_error,
        relative_residual: info.worst_relative_residual,
        condition: info.condition,
    };
    Measured { value: error, limit: info.forward_error_bound(), solver: Some(solver) }
}

/// A refusal is named by its cause.
impl From<VerifyError> for Refusal {
    fn from(error: VerifyError) -> Self {
        let text = error.to_string();
        match &error {
            VerifyError::Sim(SimError::ShellElement { problem, .. }) => Self::new(problem, text),
            VerifyError::Sim(cause) => Self::new(cause, text),
            VerifyError::Mesh(MeshError::Solid(fault)) => Self::new(fault, text),
            VerifyError::Mesh(cause) => Self::new(cause, text),
            _ => Self { kind: Self::FAULT.to_owned(), text },
        }
    }
}

/// A word without the digits that rounding moves, and without the sign of a zero.
fn rounded_word(word: &str) -> String {
    let is_number = |c: char| c.is_ascii_digit() || "-+.e".contains(c);
    let number = word.trim_matches(|c| !is_number(c)).trim_end_matches('.');
    match number.parse::<f64>() {
        Ok(0.0) => word.replace("-0", "0"),
        Ok(value) if number.len() > 8 => word.replace(number, &format!("{value:.2e}")),
        _ => word.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::rounded_word;

    #[test]
    fn words_keep_the_digits_that_hold_everywhere() {
        assert_eq!(rounded_word("-3.1524758424985325e-2"), "-3.15e-2");
        assert_eq!(rounded_word("(-0.0000,"), "(0.0000,");
        assert_eq!(rounded_word("(2.5000,"), "(2.5000,");
        assert_eq!(rounded_word("remesh."), "remesh.");
    }
}
