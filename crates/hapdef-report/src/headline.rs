//! A number that matters.

use serde::Serialize;

/// A number in large type.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Headline {
    /// The number with its unit.
    pub value: String,
    /// What it is.
    pub what: String,
    /// What it compares with.
    pub beside: String,
}
