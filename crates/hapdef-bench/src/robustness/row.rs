//! One row: a method at an extreme, and what came of it.

use std::fmt::Debug;

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};

/// One method at one extreme.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The layer of the software; empty where the case names it.
    pub layer: String,
    /// The problem or the method.
    pub case: String,
    /// `direct`, `iterative` or `shell`, where equations are solved.
    pub path: Option<String>,
    /// What is extreme.
    pub extreme: String,
    /// What must hold, in words; `measured ≤ limit` in numbers.
    pub must_hold: String,
    /// What came out.
    pub outcome: Result<Measured, Refusal>,
    /// Accurate, refused or wrong.
    pub verdict: Verdict,
    /// Whether the row is wrong, or not what was expected.
    pub failed: bool,
}

/// What was measured, and the most it may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The metric.
    #[serde(deserialize_with = "null_is_nan")]
    pub value: f64,
    /// Its limit.
    #[serde(deserialize_with = "null_is_nan")]
    pub limit: f64,
    /// What a solver reports besides.
    pub solver: Option<SolverMetrics>,
}

/// What a solver of equations reports.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolverMetrics {
    /// Equations solved.
    pub n_equations: usize,
    /// Backward error of the scaled system after refinement.
    #[serde(deserialize_with = "null_is_nan")]
    pub backward_error: f64,
    /// Residual over load.
    #[serde(deserialize_with = "null_is_nan")]
    pub relative_residual: f64,
    /// Condition number of the scaled stiffness, where it is estimated.
    pub condition: Option<f64>,
}

/// A typed error.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refusal {
    /// The variant, such as `RowNotFinite`.
    pub kind: String,
    /// Its message.
    pub text: String,
}

/// What a row shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// What must hold, holds.
    Accurate,
    /// A typed error.
    Refused,
    /// Neither.
    SilentlyWrong,
}

impl Row {
    /// `ok`, or the kind of error.
    #[must_use]
    pub fn said(&self) -> &str {
        self.outcome.as_ref().map_or_else(|refusal| refusal.kind.as_str(), |_| "ok")
    }

    /// One line for the terminal.
    #[must_use]
    pub fn line(&self) -> String {
        let failed = if self.failed { "FAIL" } else { "pass" };
        let path = self.path.as_deref().unwrap_or_default();
        let head = format!(
            "{failed} {:<14} {:<12} {:<46} {path:<9}",
            self.verdict.word(),
            self.case,
            self.extreme
        );
        let measured = match &self.outcome {
            Ok(measured) => measured,
            Err(refusal) => return format!("{head} {}: {}", refusal.kind, refusal.text),
        };
        let Measured { value, limit, solver } = measured;
        let solver = solver.map_or_else(String::new, |s| {
            let condition = s.condition.map_or_else(|| "-".to_owned(), |c| format!("{c:.1e}"));
            format!(
                "  {} equations  backward {:.1e}  residual {:.1e}  condition {condition}",
                s.n_equations, s.backward_error, s.relative_residual
            )
        });
        format!("{head} {}: {value:.3e} (limit {limit:.3e}){solver}", self.must_hold)
    }

    /// The row for machines.
    #[must_use]
    pub fn json(&self) -> Value {
        let measured = self.outcome.as_ref().ok();
        let (value, limit) = (measured.map(|m| m.value), measured.map(|m| m.limit));
        let mut row = json!({
            "extreme": self.extreme,
            "said": self.said(),
            "text": self.outcome.as_ref().err().map(|refusal| &refusal.text),
            "verdict": self.verdict.word(),
            "failed": self.failed,
        });
        let own = match &self.path {
            Some(path) => {
                let solver = measured.and_then(|m| m.solver);
                json!({
                    "case": self.case,
                    "path": path,
                    "error": value,
                    "bound": limit,
                    "equations": solver.map(|s| s.n_equations),
                    "relative_residual": solver.map(|s| s.relative_residual),
                    "backward_error": solver.map(|s| s.backward_error),
                    "condition": solver.and_then(|s| s.condition),
                })
            }
            None => json!({
                "method": self.case,
                "must_hold": self.must_hold,
                "measured": value,
                "limit": limit,
            }),
        };
        if let (Value::Object(row), Value::Object(own)) = (&mut row, own) {
            row.extend(own);
        }
        row
    }
}

impl Refusal {
    /// The kind of a row whose own set-up is wrong, which no row expects.
    pub const FAULT: &str = "Fault";

    /// Of an enum's variant, named as `Debug` names it.
    #[must_use]
    pub fn new(variant: &impl Debug, text: String) -> Self {
        let name = format!("{variant:?}");
        let is_letter = |c: &char| c.is_ascii_alphanumeric();
        Self { kind: name.chars().take_while(is_letter).collect(), text }
    }
}

impl Verdict {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Accurate, Self::Refused, Self::SilentlyWrong];

    /// The word in the table.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Accurate => "accurate",
            Self::Refused => "refused",
            Self::SilentlyWrong => "SILENTLY WRONG",
        }
    }

    /// Rows with this verdict.
    #[must_use]
    pub fn count(self, rows: &[Row]) -> usize {
        rows.iter().filter(|row| row.verdict == self).count()
    }

    pub(super) fn of(outcome: &Result<Measured, Refusal>) -> Self {
        match outcome {
            Err(_) => Self::Refused,
            // a NaN is wrong
            Ok(measured) if measured.value <= measured.limit => Self::Accurate,
            Ok(_) => Self::SilentlyWrong,
        }
    }
}

/// JSON has no infinity and no NaN: both are written as null.
fn null_is_nan<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(source)?.unwrap_or(f64::NAN))
}
