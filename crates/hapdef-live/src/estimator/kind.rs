//! Which estimator.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// What finds contacts; scenes, bundles, programs and Python have the same names for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EstimatorKind {
    /// By superposition, contacts followed from frame to frame.
    Tracking,
    /// By superposition, each frame on its own.
    Superposition,
    /// The paper's chain of nets, each frame on its own.
    Hapdefx,
}

/// No estimator has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected 'superposition', 'tracking' or 'hapdefx', found {0:?}")]
pub struct UnknownEstimator(String);

impl EstimatorKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Tracking, Self::Superposition, Self::Hapdefx];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tracking => "tracking",
            Self::Superposition => "superposition",
            Self::Hapdefx => "hapdefx",
        }
    }

    /// What it is for a stream of frames where a scene or a bundle names it: superposition follows
    /// contacts there.
    #[must_use]
    pub const fn in_stream(self) -> Self {
        match self {
            Self::Superposition => Self::Tracking,
            kind => kind,
        }
    }
}

impl Display for EstimatorKind {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for EstimatorKind {
    type Err = UnknownEstimator;

    fn from_str(name: &str) -> Result<Self, UnknownEstimator> {
        let kind = Self::ALL.into_iter().find(|kind| kind.name() == name);
        kind.ok_or_else(|| UnknownEstimator(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::EstimatorKind;

    #[test]
    fn names_are_read_as_they_are_written() {
        for kind in EstimatorKind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(kind));
            assert_eq!(serde_json::to_value(kind).unwrap(), kind.name());
        }
        let error = "Hapdefx".parse::<EstimatorKind>().unwrap_err().to_string();
        assert!(error.ends_with("'hapdefx', found \"Hapdefx\""), "{error}");
    }
}
