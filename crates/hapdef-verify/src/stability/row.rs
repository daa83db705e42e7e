//! One row of the stability table: an extreme problem, its error, and what the solver said.

use hapdef_sim::{SimError, SolveInfo};

use crate::VerifyError;

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
    pub outcome: Result<StabilityFigures, Refusal>,
    /// What should have come out.
    pub wanted: Wanted,
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

/// A typed error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The variant, such as `FreeRigidModes`.
    pub kind: String,
    /// What it says.
    pub text: String,
}

/// What should come of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// A solution within its bound.
    Solution,
    /// An error of a kind whose text has these words.
    Refusal {
        /// The variant.
        kind: &'static str,
        /// Words of its text.
        words: &'static str,
    },
    /// A solution within its bound, or any typed error.
    Either,
}

/// What a row shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StabilityVerdict {
    /// The error is within the bound that the solver states.
    Accurate,
    /// A typed error.
    Refused,
    /// Neither.
    SilentlyWrong,
}

impl StabilityFigures {
    /// The bound on the relative error that the solver states.
    #[must_use]
    pub fn bound(&self) -> f64 {
        self.info.forward_error_bound()
    }
}

impl StabilityRow {
    /// Accurate, refused or wrong.
    #[must_use]
    pub fn verdict(&self) -> StabilityVerdict {
        match &self.outcome {
            Err(_) => StabilityVerdict::Refused,
            Ok(figures) if figures.error <= figures.bound() => StabilityVerdict::Accurate,
            Ok(_) => StabilityVerdict::SilentlyWrong,
        }
    }

    /// Whether the row is wrong, or not what it should be.
    #[must_use]
    pub fn is_failed(&self) -> bool {
        let as_wanted = match (self.wanted, &self.outcome) {
            (Wanted::Either, _) | (Wanted::Solution, Ok(_)) => true,
            (Wanted::Refusal { kind, words }, Err(refusal)) => {
                refusal.kind == kind && refusal.text.contains(words)
            }
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

impl Refusal {
    /// The refusal that `error` is; a fault of the row's own set-up stays an error.
    pub(super) fn of(error: VerifyError) -> Result<Self, VerifyError> {
        let (name, text) = match &error {
            VerifyError::Sim(SimError::ShellElement { problem, .. }) => {
                (format!("{problem:?}"), error.to_string())
            }
            VerifyError::Sim(cause) => (format!("{cause:?}"), cause.to_string()),
            VerifyError::Mesh(hapdef_mesh::MeshError::Solid(fault)) => {
                (format!("{fault:?}"), fault.to_string())
            }
            VerifyError::Mesh(cause) => (format!("{cause:?}"), cause.to_string()),
            _ => return Err(error),
        };
        let kind = name
            .chars()
            .take_while(char::is_ascii_alphanumeric)
            .collect();
        Ok(Self { kind, text })
    }
}

/// A row to be solved.
pub(super) struct Trial {
    pub(super) case: &'static str,
    pub(super) extreme: String,
    pub(super) path: &'static str,
    pub(super) wanted: Wanted,
    pub(super) run: Run,
}

pub(super) type Run = Box<dyn Fn() -> Result<StabilityFigures, VerifyError>>;

impl Trial {
    /// Solves the row.
    pub(super) fn row(&self) -> Result<StabilityRow, VerifyError> {
        let outcome = match (self.run)() {
            Ok(figures) => Ok(figures),
            Err(error) => Err(Refusal::of(error)?),
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
