//! A fact of a report or page.

use serde::Serialize;

/// A name and what it stands for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NamedText {
    /// The name.
    pub name: String,
    /// What it stands for.
    pub text: String,
}

impl NamedText {
    /// The hash of a text.
    #[must_use]
    pub fn hash_of(name: &str, text: &str) -> Self {
        Self { name: name.into(), text: blake3::hash(text.as_bytes()).to_hex().to_string() }
    }
}
