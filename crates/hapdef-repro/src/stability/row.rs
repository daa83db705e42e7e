//! One row of the table: a method at an extreme, what must hold, and what came of it.

use crate::ReproError;

/// One method at one extreme.
#[derive(Clone, Debug, PartialEq)]
pub struct NetsRow {
    /// The method.
    pub method: &'static str,
    /// What is extreme.
    pub extreme: String,
    /// What must hold, in words; `measured ≤ limit` in numbers.
    pub must_hold: &'static str,
    /// What came out.
    pub outcome: Result<NetsFigure, NetsRefusal>,
    /// What should have come out.
    pub wanted: NetsWanted,
}

/// What was measured, and the most it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NetsFigure {
    /// The figure.
    pub measured: f64,
    /// Its limit.
    pub limit: f64,
}

/// A typed error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NetsRefusal {
    /// The variant, such as `RowNotFinite`.
    pub kind: String,
    /// What it says.
    pub text: String,
}

/// What should come of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NetsWanted {
    /// What must hold, holds.
    Result,
    /// An error whose text has these words.
    Refusal(&'static str),
    /// What must hold, holds, or any typed error.
    Either,
}

/// What a row shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NetsVerdict {
    /// What must hold, holds.
    Accurate,
    /// A typed error.
    Refused,
    /// Neither.
    SilentlyWrong,
}

impl NetsRow {
    /// Accurate, refused or wrong.
    #[must_use]
    pub fn verdict(&self) -> NetsVerdict {
        match &self.outcome {
            Err(_) => NetsVerdict::Refused,
            Ok(figure) if figure.measured <= figure.limit => NetsVerdict::Accurate,
            Ok(_) => NetsVerdict::SilentlyWrong,
        }
    }

    /// Whether the row is wrong, or not what it should be.
    #[must_use]
    pub fn is_failed(&self) -> bool {
        let as_wanted = match (self.wanted, &self.outcome) {
            (NetsWanted::Either, _) | (NetsWanted::Result, Ok(_)) => true,
            (NetsWanted::Refusal(words), Err(refusal)) => refusal.text.contains(words),
            _ => false,
        };
        !as_wanted || self.verdict() == NetsVerdict::SilentlyWrong
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

impl NetsVerdict {
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

impl NetsRefusal {
    fn of(error: &ReproError) -> Self {
        let name = match error {
            ReproError::Nets(cause) => format!("{cause:?}"),
            ReproError::Data(cause) => format!("{cause:?}"),
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
    pub(super) wanted: NetsWanted,
    pub(super) run: Box<dyn Fn() -> Result<f64, ReproError>>,
}

impl Case {
    pub(super) fn row(&self) -> NetsRow {
        let figure = |measured| NetsFigure {
            measured,
            limit: self.limit,
        };
        NetsRow {
            method: self.method,
            extreme: self.extreme.clone(),
            must_hold: self.must_hold,
            outcome: (self.run)().map(figure).map_err(|e| NetsRefusal::of(&e)),
            wanted: self.wanted,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(outcome: Result<f64, ReproError>, wanted: NetsWanted) -> NetsRow {
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
            let row = row(Ok(measured), NetsWanted::Either);
            assert_eq!(row.verdict(), NetsVerdict::SilentlyWrong);
            assert!(row.is_failed());
        }
        assert!(!row(Ok(1.0), NetsWanted::Result).is_failed());
    }

    #[test]
    fn what_should_be_refused_and_is_not_fails() {
        assert!(row(Ok(0.0), NetsWanted::Refusal("stopped")).is_failed());
        assert!(row(Err(ReproError::Stopped), NetsWanted::Refusal("row 3")).is_failed());
        let refused = row(Err(ReproError::Stopped), NetsWanted::Refusal("stopped"));
        assert_eq!((refused.is_failed(), refused.said()), (false, "Stopped"));
        assert!(row(Err(ReproError::Stopped), NetsWanted::Result).is_failed());
    }
}
