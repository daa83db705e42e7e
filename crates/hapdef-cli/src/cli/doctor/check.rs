//! One thing that was looked at.

use hapdef_contact::printable;
use serde_json::{Value, json};

/// How a check ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// As it should be.
    Ok,
    /// Readings come, but something could be better.
    Warn,
    /// Has to be mended.
    Bad,
}

/// One check: what was looked at, how it is, and what to do where it is not well.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Check {
    pub(super) name: String,
    pub(super) state: State,
    pub(super) found: String,
    pub(super) fix: Option<String>,
}

impl Check {
    pub(super) fn ok(name: &str, found: impl Into<String>) -> Self {
        Self::new(name, State::Ok, found, None)
    }

    pub(super) fn warn(name: &str, found: impl Into<String>, fix: impl Into<String>) -> Self {
        Self::new(name, State::Warn, found, Some(fix.into()))
    }

    pub(super) fn bad(name: &str, found: impl Into<String>, fix: impl Into<String>) -> Self {
        Self::new(name, State::Bad, found, Some(fix.into()))
    }

    pub(super) fn as_json(&self) -> Value {
        json!({
            "check": self.name,
            "state": self.state.word(),
            "found": self.found,
            "fix": self.fix,
        })
    }

    fn new(name: &str, state: State, found: impl Into<String>, fix: Option<String>) -> Self {
        Self { name: name.to_owned(), state, found: found.into(), fix }
    }
}

impl State {
    fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warn => "warn",
            Self::Bad => "bad",
        }
    }
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [name, found] = [&self.name, &self.found].map(|text| printable(text));
        write!(f, "{:4} {name}: {found}", self.state.word())?;
        match &self.fix {
            Some(fix) => write!(f, "\n     → {}", printable(fix)),
            None => Ok(()),
        }
    }
}
