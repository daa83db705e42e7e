//! One row of the table: a method at an extreme, what must hold, and what came of it.

use crate::ReproError;

/// One method at one extreme.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityRow {
    /// The method.
    pub method: &'static str,
    /// What is extreme.
    pub extreme: String,
    /// What must hold, in words; `measured ≤ limit` in numbers.
    pub must_hold: &'static str,
    /// What came out.
    pub outcome: Result<StabilityFigure, StabilityRefusal>,
    /// What should have come out.
    pub wanted: StabilityWanted,
}

/// What was measured, and the most it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityFigure {
    /// The figure.
    pub measured: f64,
    /// Its limit.
    pub limit: f64,
}

/// A typed error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StabilityRefusal {
    /// The variant, such as `RowNotFinite`.
    pub kind: String,
    /// What it says.
    pub text: String,
}

/// What should come of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StabilityWanted {
    /// What must hold, holds.
    Result,
    /// An error whose text has these words.
    Refusal(&'static str),
    /// What must hold, holds, or any typed error.
    Either,
}

/// What a row shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StabilityVerdict {
    /// What must hold, holds.
    Accurate,
    /// A typed error.
    Refused,
    /// Neither.
    SilentlyWrong,
}

impl StabilityRow {
    /// Accurate, refused or wrong.
    #[must_use]
    pub fn verdict(&self) -> StabilityVerdict {
        match &self.outcome {
            Err(_) => StabilityVerdict::Refused,
            Ok(figure) if figure.measured <= figure.limit => StabilityVerdict::Accurate,
            Ok(_) => StabilityVerdict::SilentlyWrong,
        }
    }

    /// Whether the row is wrong, or not what it should be.
    #[must_use]
    pub fn is_failed(&self) -> bool {
        let as_wanted = match (self.wanted, &self.outcome) {
            (StabilityWanted::Either, _) | (StabilityWanted::Result, Ok(_)) => true,
            (StabilityWanted::Refusal(words), Err(refusal)) => refusal.text.contains(words),
            _ => false,
        };
        !as_wanted || self.verdict() == StabilityVerdict::SilentlyWrong
    }

    /// `ok`, or the kind of error.
    #[must_use]
    pub fn said(&self) -> &str {
        match &self.outcome {
            Ok(_) => "ok",
            Err(refusal) => &refusal.kind,
        }
    }
}

impl StabilityVerdict {
    /// The word that the table shows.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Accurate => "accurate",
            Self::Refused => "refused",
            Self::SilentlyWrong => "SILENTLY WRONG",
        }
    }
}

impl StabilityRefusal {
    fn of(error: &ReproError) -> Self {
        let name = match error {
            ReproError::Nets(cause) => format!("{cause:?}"),
            ReproError::Data(cause) => format!("{cause:?}"),
            ReproError::Inverse(cause) => format!("{cause:?}"),
            ReproError::Mesh(hapdef_mesh::MeshError::Solid(cause)) => format!("{cause:?}"),
            ReproError::KMax(cause) => format!("{cause:?}"),
            ReproError::Daq(cause) => format!("{cause:?}"),
            other => format!("{other:?}"),
        };
        let is_letter = |c: &char| c.is_ascii_alphanumeric();
        Self {
            kind: name.chars().take_while(is_letter).collect(),
            text: error.to_string(),
        }
    }
}

/// A row to be run.
pub(super) struct Case {
    pub(super) method: &'static str,
    pub(super) extreme: String,
    pub(super) must_hold: &'static str,
    pub(super) limit: f64,
    pub(super) wanted: StabilityWanted,
    pub(super) run: Box<dyn Fn() -> Result<f64, ReproError>>,
}

impl Case {
    pub(super) fn row(&self) -> StabilityRow {
        let figure = |measured| StabilityFigure {
            measured,
            limit: self.limit,
        };
        StabilityRow {
            method: self.method,
            extreme: self.extreme.clone(),
            must_hold: self.must_hold,
            outcome: (self.run)()
                .map(figure)
                .map_err(|e| StabilityRefusal::of(&e)),
            wanted: self.wanted,
        }
    }
}

/// A case, written in the order of the table's columns.
pub(super) fn case(
    method: &'static str,
    extreme: impl Into<String>,
    (must_hold, limit): (&'static str, f64),
    wanted: StabilityWanted,
    run: impl Fn() -> Result<f64, ReproError> + 'static,
) -> Case {
    Case {
        method,
        extreme: extreme.into(),
        must_hold,
        limit,
        wanted,
        run: Box::new(run),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(outcome: Result<f64, ReproError>, wanted: StabilityWanted) -> StabilityRow {
        let outcome = std::cell::RefCell::new(Some(outcome));
        Case {
            method: "LR",
            extreme: String::new(),
            must_hold: "",
            limit: 1.0,
            wanted,
            run: Box::new(move || outcome.borrow_mut().take().unwrap()),
        }
        .row()
    }

    #[test]
    fn beyond_the_limit_is_silently_wrong() {
        for measured in [1.1, f64::INFINITY, f64::NAN] {
            let row = row(Ok(measured), StabilityWanted::Either);
            assert_eq!(row.verdict(), StabilityVerdict::SilentlyWrong);
            assert!(row.is_failed());
        }
        assert!(!row(Ok(1.0), StabilityWanted::Result).is_failed());
    }

    #[test]
    fn what_should_be_refused_and_is_not_fails() {
        assert!(row(Ok(0.0), StabilityWanted::Refusal("stopped")).is_failed());
        assert!(row(Err(ReproError::Stopped), StabilityWanted::Refusal("row 3")).is_failed());
        let refused = row(
            Err(ReproError::Stopped),
            StabilityWanted::Refusal("stopped"),
        );
        assert_eq!((refused.is_failed(), refused.said()), (false, "Stopped"));
        assert!(row(Err(ReproError::Stopped), StabilityWanted::Result).is_failed());
    }
}
