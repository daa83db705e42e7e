//! The columns of robustness tables.

use super::row::{Measured, Row, SolverMetrics};

/// A column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// The layer of the software.
    Layer,
    /// The method.
    Method,
    /// The problem.
    Case,
    /// The problem and its path, where the layer does not name it already.
    LayerCase,
    /// What is extreme.
    Extreme,
    /// The solver's path.
    Path,
    /// What must hold.
    MustHold,
    /// Equations solved.
    Equations,
    /// The measured error.
    Error,
    /// The backward error.
    Backward,
    /// The condition number.
    Condition,
    /// The bound on the error.
    Bound,
    /// The most that the metric may be.
    Limit,
    /// The metric.
    Measured,
    /// The metric and its limit.
    MeasuredOfLimit,
    /// `ok`, or the error.
    Said,
    /// Accurate, refused or wrong.
    Verdict,
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
    /// Its heading.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Layer => "layer",
            Self::Method => "method",
            Self::Case | Self::LayerCase => "case",
            Self::Extreme => "extreme",
            Self::Path => "path",
            Self::MustHold => "must hold",
            Self::Equations => "equations",
            Self::Error => "error",
            Self::Backward => "backward",
            Self::Condition => "condition",
            Self::Bound => "bound",
            Self::Limit => "limit",
            Self::Measured | Self::MeasuredOfLimit => "measured",
            Self::Said => "said",
            Self::Verdict => "verdict",
        }
    }

    /// Whether rounding moves its numbers: they are shown, and not compared.
    pub(super) fn is_rounded(self) -> bool {
        matches!(
            self,
            Self::Error | Self::Backward | Self::Condition | Self::Bound | Self::Measured
        )
    }

    /// A row's cell.
    pub(super) fn cell(self, row: &Row, digits: Digits) -> String {
        let measured = row.outcome.as_ref().ok();
        let number =
            |get: fn(&Measured) -> f64| measured.map_or_else(String::new, |m| digits.text(get(m)));
        let solver = |get: &dyn Fn(&SolverMetrics) -> Option<String>| {
            measured.and_then(|m| get(m.solver.as_ref()?)).unwrap_or_default()
        };
        let path = row.path.as_deref();
        match (self, digits) {
            (Self::Layer, _) if !row.layer.is_empty() => row.layer.clone(),
            (Self::LayerCase, _) if row.layer.is_empty() => String::new(),
            (Self::LayerCase, _) if path.is_some() => {
                format!("{}, {}", row.case, path.unwrap_or_default())
            }
            (Self::Layer | Self::Method | Self::Case | Self::LayerCase, _) => row.case.clone(),
            (Self::Extreme, _) => row.extreme.clone(),
            (Self::Path, _) => path.unwrap_or_default().to_owned(),
            (Self::MustHold, _) => row.must_hold.clone(),
            (Self::Equations, _) => solver(&|s| Some(s.n_equations.to_string())),
            (Self::Backward, _) => solver(&|s| Some(digits.text(s.backward_error))),
            (Self::Condition, _) => solver(&|s| s.condition.map(|c| digits.text(c))),
            (Self::Limit, Digits::Magnitude(_)) => {
                measured.map_or_else(String::new, |m| format!("{:e}", m.limit))
            }
            (Self::Bound | Self::Limit, _) => number(|m| m.limit),
            (Self::Error | Self::Measured, _) => number(|m| m.value),
            (Self::MeasuredOfLimit, _) => measured.map_or_else(String::new, |m| {
                format!("{} of {}", digits.text(m.value), digits.text(m.limit))
            }),
            (Self::Said, Digits::Magnitude(_)) => row.said().to_owned(),
            (Self::Said, Digits::Two) => match &row.outcome {
                Ok(_) => row.said().to_owned(),
                Err(refusal) => refusal.text.clone(),
            },
            (Self::Verdict, _) => row.verdict.word().to_owned(),
        }
    }
}

impl Digits {
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
