//! The columns of robustness tables.

use super::row::{Measured, Row, SolverMetrics};

/// A column of a table.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    pub(super) name: &'static str,
    /// Whether rounding moves its numbers: they are shown, and not compared.
    pub(super) is_rounded: bool,
    pub(super) cell: fn(&Row, Digits) -> String,
}

/// How a table writes its numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Digits {
    /// Orders of magnitude; a word for what is below the least.
    Magnitude((f64, &'static str)),
    /// Two digits, and errors in full.
    Two,
}

impl Column {
    /// The layer of the software.
    pub const LAYER: Self = Self::exact("layer", |row, _| match row.layer.as_str() {
        "" => row.case.clone(),
        layer => layer.to_owned(),
    });
    /// The method.
    pub const METHOD: Self = Self::exact("method", |row, _| row.case.clone());
    /// The problem.
    pub const CASE: Self = Self::exact("case", |row, _| row.case.clone());
    /// The problem and its path, where the layer does not name it already.
    pub const LAYER_CASE: Self = Self::exact("case", |row, _| match &row.path {
        _ if row.layer.is_empty() => String::new(),
        Some(path) => format!("{}, {path}", row.case),
        None => row.case.clone(),
    });
    /// What is extreme.
    pub const EXTREME: Self = Self::exact("extreme", |row, _| row.extreme.clone());
    /// The solver's path.
    pub const PATH: Self = Self::exact("path", |row, _| row.path.clone().unwrap_or_default());
    /// What must hold.
    pub const MUST_HOLD: Self = Self::exact("must hold", |row, _| row.must_hold.clone());
    /// Equations solved.
    pub const EQUATIONS: Self =
        Self::exact("equations", |row, _| of_solver(row, |s| Some(s.n_equations.to_string())));
    /// The measured error.
    pub const ERROR: Self = Self::rounded("error", |row, digits| digits.of(row, |m| m.value));
    /// The backward error.
    pub const BACKWARD: Self = Self::rounded("backward", |row, digits| {
        of_solver(row, |s| Some(digits.text(s.backward_error)))
    });
    /// The condition number.
    pub const CONDITION: Self = Self::rounded("condition", |row, digits| {
        of_solver(row, |s| s.condition.map(|c| digits.text(c)))
    });
    /// The bound on the error.
    pub const BOUND: Self = Self::rounded("bound", |row, digits| digits.of(row, |m| m.limit));
    /// The most that the metric may be.
    pub const LIMIT: Self = Self::exact("limit", |row, _| of(row, |m| format!("{:e}", m.limit)));
    /// The metric.
    pub const MEASURED: Self = Self::rounded("measured", |row, digits| digits.of(row, |m| m.value));
    /// The metric and its limit.
    pub const MEASURED_OF_LIMIT: Self = Self::rounded("measured", |row, digits| {
        of(row, |m| format!("{} of {}", digits.text(m.value), digits.text(m.limit)))
    });
    /// `ok`, or the error.
    pub const SAID: Self = Self::exact("said", |row, digits| match (digits, &row.outcome) {
        (Digits::Two, Err(refusal)) => refusal.text.clone(),
        _ => row.said().to_owned(),
    });
    /// Accurate, refused or wrong.
    pub const VERDICT: Self = Self::exact("verdict", |row, _| row.verdict.word().to_owned());

    const fn exact(name: &'static str, cell: fn(&Row, Digits) -> String) -> Self {
        Self { name, is_rounded: false, cell }
    }

    const fn rounded(name: &'static str, cell: fn(&Row, Digits) -> String) -> Self {
        Self { name, is_rounded: true, cell }
    }
}

/// Something of what was measured; nothing of a refusal.
fn of(row: &Row, text: impl Fn(&Measured) -> String) -> String {
    row.outcome.as_ref().map_or_else(|_| String::new(), text)
}

/// Something that a solver reports.
fn of_solver(row: &Row, text: impl Fn(&SolverMetrics) -> Option<String>) -> String {
    of(row, |m| m.solver.as_ref().and_then(&text).unwrap_or_default())
}

impl Digits {
    /// A number of what was measured.
    fn of(self, row: &Row, get: fn(&Measured) -> f64) -> String {
        of(row, |m| self.text(get(m)))
    }

    pub(super) fn text(self, value: f64) -> String {
        match self {
            Self::Two => format!("{value:.1e}"),
            Self::Magnitude(_) if value.is_nan() => "NaN".to_owned(),
            Self::Magnitude((least, word)) if value < least => word.to_owned(),
            Self::Magnitude(_) if value.is_finite() => format!("1e{}", value.log10().round()),
            Self::Magnitude(_) => "∞".to_owned(),
        }
    }
}
