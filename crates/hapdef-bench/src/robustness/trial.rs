//! Rows that are to be run.

use super::row::{Measured, Refusal};

/// What should come of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// What must hold, holds.
    Result,
    /// An error.
    Refusal {
        /// The variant; any if empty.
        kind: &'static str,
        /// Words of its text.
        words: &'static str,
    },
    /// What must hold, holds, or any typed error.
    Either,
}

/// What must hold in words, and the most that the metric may be.
pub type MustHold = (&'static str, f64);

/// A row that is refused: what is extreme, words of the refusal, what is run.
pub type Refused<E> = (&'static str, &'static str, fn() -> Result<f64, E>);

/// The rows of a table that are to be run, in its order; each is measured on a `W`.
pub struct Trials<W, E> {
    case: &'static str,
    path: Option<&'static str>,
    on: W,
    refusal: fn(E) -> Refusal,
    pub(super) all: Vec<Trial>,
}

pub(super) struct Trial {
    pub(super) case: &'static str,
    pub(super) path: Option<&'static str>,
    pub(super) extreme: String,
    pub(super) must_hold: &'static str,
    pub(super) expected: Expected,
    pub(super) run: Box<dyn Fn() -> Result<Measured, Refusal>>,
}

impl Expected {
    /// An error of any kind whose text has these words.
    #[must_use]
    pub fn saying(words: &'static str) -> Self {
        Self::Refusal { kind: "", words }
    }

    pub(super) fn is_met_by(self, outcome: &Result<Measured, Refusal>) -> bool {
        match (self, outcome) {
            (_, Err(refusal)) if refusal.kind == Refusal::FAULT => false,
            (Self::Either, _) | (Self::Result, Ok(_)) => true,
            (Self::Refusal { kind, words }, Err(refusal)) => {
                (kind.is_empty() || refusal.kind == kind) && refusal.text.contains(words)
            }
            _ => false,
        }
    }
}

impl<W: Clone + 'static, E: Into<Refusal> + 'static> Trials<W, E> {
    /// No rows yet.
    #[must_use]
    pub fn new(on: W) -> Self {
        Self { case: "", path: None, on, refusal: E::into, all: Vec::new() }
    }

    /// The rows that follow are of this case: the problem or the method.
    pub fn of(&mut self, case: &'static str) -> &mut Self {
        self.case = case;
        self
    }

    /// Those that follow are measured on this.
    pub fn on(&mut self, on: W) -> &mut Self {
        self.on = on;
        self
    }

    /// Those that follow solve equations: `direct`, `iterative` or `shell`.
    pub fn path(&mut self, path: &'static str) -> &mut Self {
        self.path = Some(path);
        self
    }

    /// A row in which what must hold, holds.
    pub fn accurate(
        &mut self,
        extreme: impl Into<String>,
        must_hold: MustHold,
        run: impl Fn(&W) -> Result<f64, E> + 'static,
    ) {
        self.add(extreme, must_hold, Expected::Result, run);
    }

    /// A row in which what must hold, holds, or that is refused.
    pub fn either(
        &mut self,
        extreme: impl Into<String>,
        must_hold: MustHold,
        run: impl Fn(&W) -> Result<f64, E> + 'static,
    ) {
        self.add(extreme, must_hold, Expected::Either, run);
    }

    /// A row that is refused with these words.
    pub fn refused(
        &mut self,
        extreme: impl Into<String>,
        must_hold: &'static str,
        words: &'static str,
        run: impl Fn(&W) -> Result<f64, E> + 'static,
    ) {
        self.add(extreme, (must_hold, 0.0), Expected::saying(words), run);
    }

    /// Rows that are refused.
    pub fn all_refused<const N: usize>(&mut self, rows: [Refused<E>; N]) {
        for (extreme, words, run) in rows {
            self.refused(extreme, "it is refused", words, move |_| run());
        }
    }

    /// A row of which something is expected.
    pub fn add(
        &mut self,
        extreme: impl Into<String>,
        (must_hold, limit): MustHold,
        expected: Expected,
        run: impl Fn(&W) -> Result<f64, E> + 'static,
    ) {
        self.solved(extreme, must_hold, expected, move |on| {
            Ok(Measured { value: run(on)?, limit, solver: None })
        });
    }

    /// The same where more is measured than a number.
    pub fn solved(
        &mut self,
        extreme: impl Into<String>,
        must_hold: &'static str,
        expected: Expected,
        run: impl Fn(&W) -> Result<Measured, E> + 'static,
    ) {
        let (on, refusal) = (self.on.clone(), self.refusal);
        self.all.push(Trial {
            case: self.case,
            path: self.path,
            extreme: extreme.into(),
            must_hold,
            expected,
            run: Box::new(move || run(&on).map_err(refusal)),
        });
    }
}
